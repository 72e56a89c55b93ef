"""A TOML model runs no code: no text of it enters what is executed or compiled, except checked names and numbers."""

import shutil
import subprocess
import sys

import pytest

from spacar.errors import UsageError
from spacar.symbolic import MultibodySystem
from spacar.symbolic.name_rules import control_character, escaped, is_name, is_output
from tests.command_line import call as run

PENDULUM = """
[system]
title = TITLE
gravity = ["0", "-9.81", "0"]
[parameters]
m = 1.0
[coordinates]
q = { speed = "s", start = 0.1 }
[[frame]]
name = "B"
parent = "N"
axis = 3
angle = "q"
EXTRA
[[point]]
name = "P"
base = "O"
in = "B"
offset = ["0", "-1", "0"]
[[body]]
name = "bob"
at = "P"
mass = "m"
[simulate]
time = 0.1
steps = 2
[outputs]
OUTPUT = "q"
"""
BREAKOUTS = {
    "docstring": '"x\\"\\"\\"; open(\'PWNED\', \'w\'); \\"\\"\\""',
    "comment of C": '"x */ #include \\"PWNED\\" /*"',
    "backslash": '"x\\\\"',
    "trigraph": '"x ??/ y *??/ /"',
    "latex": '"\\\\immediate\\\\write18{touch PWNED} %"',
}


def write(folder, title='"a pendulum"', extra="", output="a"):
    path = folder / "model.toml"
    text = PENDULUM.replace("TITLE", title).replace("EXTRA", extra).replace("OUTPUT", output)
    path.write_text(text, encoding="utf-8")
    return path


def test_the_attack_of_the_issue_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = write(tmp_path, '"x\\n\\"\\"\\"\\nimport os; os.system(\'id > PWNED\')\\n\\"\\"\\"\\n"')
    assert "control character" in run.refused("symbolic", "simulate", path)
    assert not (tmp_path / "PWNED").exists()


@pytest.mark.parametrize("compiled", [(), ("--compiled",)], ids=["python", "c"])
@pytest.mark.parametrize("title", BREAKOUTS.values(), ids=BREAKOUTS)
def test_a_title_never_enters_what_is_executed(tmp_path, monkeypatch, title, compiled):
    monkeypatch.chdir(tmp_path)
    if compiled and not shutil.which("cc"):
        pytest.skip("no C compiler")
    status, _, err = run("symbolic", "simulate", write(tmp_path, title), *compiled)
    assert (status, err) == (0, "")
    assert not (tmp_path / "PWNED").exists()


@pytest.mark.parametrize("language", ["python", "c", "fortran", "latex"])
def test_exported_files_hold_the_title_escaped(tmp_path, monkeypatch, language):
    monkeypatch.chdir(tmp_path)
    for title in BREAKOUTS.values():
        target = tmp_path / f"out.{language}"
        err = run.done("symbolic", "export", write(tmp_path, title), "--language", language, "-o", target).err
        assert err.startswith("information: check: energy")  # what was found out about the equations, nothing else
        assert len(err.splitlines()) == 1
        text = target.read_text(encoding="utf-8")
        if language == "python":
            subprocess.run([sys.executable, str(target)], check=True, cwd=tmp_path)
        if language == "c":
            head = text[: text.index("*/") + 2]
            assert "PWNED" not in text.replace(head, "")
            assert head.endswith("\n */")
        assert not (tmp_path / "PWNED").exists()
        assert "\\immediate" not in text


@pytest.mark.parametrize(
    ("extra", "output", "found"),
    [
        ('symbol = "}\\\\input{/etc/passwd"', "a", "key 'symbol' must be a name"),
        ("", '"../../a"', "is not a name for an output"),
        ("", '"a\\"\\"\\""', "is not a name for an output"),
        ("", '"a\\u001b[31m"', "control character"),
        ("", '"a\\u202e"', "control character"),
    ],
)
def test_names_are_checked(tmp_path, extra, output, found):
    err = run.refused("symbolic", "check", write(tmp_path, extra=extra, output=output))
    assert found in err
    assert "\x1b" not in err
    assert "internal" not in err


def test_a_name_of_a_library_model_is_checked_before_it_becomes_program_text():
    system = MultibodySystem(title="x")
    q, s = system.coordinate("q"), system.speed("s): import os #")
    system.kinematic(q, s)
    system.particle("bob", system.point("P", system.O, q * system.N[1]), 1.0)
    with pytest.raises(UsageError, match="is not a name"):
        system.derive("recursive").program({}).code("python")


def test_a_file_name_as_title_is_escaped(tmp_path):
    path = write(tmp_path)
    hostile = tmp_path / 'x"""; import os.toml'
    hostile.write_text(path.read_text().replace('title = "a pendulum"\n', ""))
    run.done("symbolic", "export", hostile, "--language", "python", "-o", tmp_path / "out.py")
    assert "x<U+0022><U+0022><U+0022>; import os" in (tmp_path / "out.py").read_text()


def test_deeply_nested_toml_is_one_sentence(tmp_path):
    path = tmp_path / "deep.toml"
    path.write_text("a = " + "[" * 5000 + "]" * 5000)
    assert "nested" in run.refused("symbolic", "check", path)


def test_the_white_list():
    assert all(map(is_name, ("q1", "Q", "φ", "_a")))
    assert not any(map(is_name, ("", "1a", "a b", "a\n", "ﬁ", "a" * 300)))
    assert all(map(is_output, ("tip.x", "x (m)", "a-b", "F_1")))
    assert not any(map(is_output, ("", "../x", "a/b", "a\n", "a\0", ".x")))
    assert escaped('a*/"\\\n') == "a<U+002A>/<U+0022><U+005C><U+000A>"
    assert control_character({"a": ["b", {"c": "d\x1b"}]}) == "d\x1b"
