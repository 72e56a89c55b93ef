"""What is executed and when: `check` runs nothing, modes run the functions of the deck, libraries are our own."""

import os
import re
import shutil
import subprocess
import sys

import pytest

from spacar.errors import UsageError
from spacar.native import store
from spacar.symbolic import MultibodySystem
from spacar.symbolic.name_rules import control_character, escaped, is_name, is_output
from tests.command_line import call as run

from .processes import ENVIRONMENT, done, model

DECK = """PLBEAM 1 1 2 3 4
X 3 1. 0.
FIX 1
FIX 2
DYNE 1 2 3
END
HALT
EM 1 1.
ESTIFF 1 1e5 10.
USERSIG push
TIMESTEP 0.1 2
END
END
"""
PUSH = "open('RUN', 'w').close()\ndef push(t, *rest):\n    return t, [], []\n"


def test_check_lists_functions_and_imports_none(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.dat").write_text(DECK)
    (tmp_path / "push.py").write_text(PUSH)
    err = run.done("check", "a").err
    assert "USERSIG: runs of this model execute" in err
    assert not (tmp_path / "RUN").exists()
    assert run("check", "a", "--mode", 1)[0] == 0
    assert not (tmp_path / "RUN").exists()
    assert run(1, "a")[0] == 0
    assert (tmp_path / "RUN").exists()  # modes execute it, as they must


def test_check_tells_what_is_missing_without_running_anything(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.dat").write_text(DECK)
    assert "a.dat:10: USERSIG: the function file push.py was not found" in run.refused("check", "a")
    (tmp_path / "long.dat").write_text(DECK.replace("push", 260 * "p"))
    assert "ppp.py was not found" in run.refused("check", "long")
    (tmp_path / "push.py").write_text("raise SystemExit\n")
    err = run.done("check", "a").err
    assert "does not seem to define a function push" in err


def test_who_executes_functions_of_a_model(tmp_path, monkeypatch):
    """What computes does; what builds no motion, and what reads results, does not."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.dat").write_text(DECK)
    (tmp_path / "push.py").write_text(PUSH)
    said = {}
    for line in ("0 a", "check a", "1 a", "7 a", "sweep a --set EM.1=1 -r x[3,1]@end", "trade a --target 1e-2",
                 "sensitivity a -p EM.1 --of x[3,1]@end", "flexure a --move 3y=1e-6", "draw a -o a.svg", "eigen a",
                 "plot a x[3,1] --csv -", "checksbf a", "report a", "view a", "stress a"):  # fmt: skip
        run.done(*line.split())
        said[line.split()[0]] = (tmp_path / "RUN").exists()
        (tmp_path / "RUN").unlink(missing_ok=True)
    assert {word for word, ran in said.items() if ran} == {"1", "7", "sweep", "trade", "sensitivity", "flexure"}


@pytest.mark.parametrize("raised", ["raise SystemExit(3)", "import sys; sys.exit()", "raise GeneratorExit"])
@pytest.mark.parametrize("engine", ["--compiled", "--general"])
def test_a_function_that_ends_the_program_ends_its_run(tmp_path, raised, engine):
    """A sentence and status 1, later as at the start; a failed row in a study, whose other cases run."""
    (tmp_path / "a.dat").write_text(DECK)
    (tmp_path / "push.py").write_text(f"def push(t, *rest):\n    if t > 0.06: {raised}\n    return t, [], []\n")
    err = run.refused(1, tmp_path / "a.dat", engine, status=1)
    [sentence] = [line for line in err.splitlines() if line.startswith("error: ")]
    assert "the user function push failed at t = " in sentence
    told = "GeneratorExit" if "Gen" in raised else "SystemExit: 3" if "3" in raised else "SystemExit"
    assert re.search(rf"failed at t = [\d.e-]+: {told}$", sentence.partition("; ")[0]), sentence
    rows = tmp_path / "a.csv"
    words = ["--set", "TIMESTEP=0.05,0.1", "--result", "tip:x[3,1]@end", "-o", rows, engine]
    status, out, _ = run("sweep", tmp_path / "a.dat", *words)
    assert (status, "2 cases: 2 run" in out, "1 of them failed" in out) == (1, True, True)
    assert [line.split(",")[3] for line in rows.read_text().splitlines()] == ["status", "done", "failed"]


def test_a_file_of_functions_that_ends_the_program_is_refused(tmp_path):
    (tmp_path / "a.dat").write_text(DECK)
    (tmp_path / "push.py").write_text("raise SystemExit(3)\n")
    err = run.refused(1, tmp_path / "a.dat")
    assert "a.dat:10: USERSIG: " in err
    assert "push.py cannot be loaded: SystemExit: 3" in err
    (tmp_path / "a.py").write_text("import sys\nsys.exit(3)\n")
    assert "a.py:2: SystemExit: 3" in run.refused("symbolic", "check", tmp_path / "a.py")


@pytest.mark.parametrize("name", ["../push", "a/push", "push.x", "..", "os;x"])
def test_names_with_separators_are_refused(tmp_path, name):
    (tmp_path / "a.dat").write_text(DECK.replace("push", name))
    (tmp_path / "push.py").write_text(PUSH)
    assert "USERSIG" in run.refused(1, tmp_path / "a.dat")


# -- compiled libraries ------------------------------------------------------------------------------------------

compiled = pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache, and a compiler that makes small libraries quickly."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    store._private.cache_clear()
    return tmp_path / "spacar"


SMALL = b"int spacar_one(void) { return 1; }\n"
FLAGS = (("-shared", "-fPIC"),)


def small():
    return store.stored("small.so", store.compiler(), FLAGS, SMALL, ("spacar_one",))


@compiled
def test_a_sound_library_is_built_once(cache):
    path = small()
    assert path.parent == cache
    assert sorted(p.name for p in cache.iterdir()) == ["small.so", "small.so.sha256"]
    assert (cache.stat().st_mode & 0o777, path.stat().st_mode & 0o077) == (0o700, 0)
    before = path.stat().st_mtime_ns
    assert small().stat().st_mtime_ns == before


@compiled
@pytest.mark.parametrize("damage", ["truncated", "changed", "no checksum", "writable by others", "link"])
def test_a_library_that_is_not_sound_is_built_again(cache, tmp_path, damage):
    path = small()
    good = path.read_bytes()
    if damage == "truncated":
        path.write_bytes(good[: len(good) // 2])
    elif damage == "changed":
        path.write_bytes(good[:-1] + bytes([good[-1] ^ 1]))
    elif damage == "no checksum":
        (cache / "small.so.sha256").unlink()
    elif damage == "writable by others":
        path.chmod(0o722)
    else:
        path.rename(tmp_path / "elsewhere.so")
        path.symlink_to(tmp_path / "elsewhere.so")
    assert not store.is_sound(path)
    assert store.is_sound(small())
    assert not path.is_symlink()
    assert path.stat().st_mode & 0o022 == 0


@compiled
def test_a_folder_that_others_may_write_is_not_used(cache):
    cache.mkdir()
    cache.chmod(0o777)
    path = small()
    assert path.parent != cache
    assert not list(cache.iterdir())
    assert path.parent.stat().st_mode & 0o077 == 0


@compiled
@pytest.mark.parametrize(("mode", "used"), [(0o777, False), (0o770, False), (0o1777, True), (0o755, True)])
def test_a_folder_that_others_may_replace_is_not_used(cache, tmp_path, monkeypatch, mode, used):
    """Who may write a folder above it can move it away and put another one there, unless that one is sticky as /tmp."""
    above = tmp_path / "above"
    (above / "cache").mkdir(mode=0o700, parents=True)
    above.chmod(mode)
    monkeypatch.setenv("XDG_CACHE_HOME", str(above / "cache"))
    assert (small().parent == above / "cache" / "spacar") is used
    monkeypatch.setenv("XDG_CACHE_HOME", str(above))
    assert (small().parent == above / "spacar") is used


@compiled
@pytest.mark.parametrize(
    ("script", "found"),
    [
        ('while [ "$1" != -o ]; do shift; done; echo garbage > "$2"', "cannot be loaded"),
        ("exit 0", "wrote no library"),
        ("echo 'int x;' > x.c; while [ \"$1\" != -o ]; do shift; done; cc -shared -fPIC x.c -o \"$2\"",
         "cannot be loaded"),
        ('while [ "$1" != -o ]; do shift; done; echo "int spacar_one(void){return 1;}" > x.c; '
         'cc -shared -fPIC x.c -o y.so; head -c 5000 y.so > "$2"', "cannot be loaded"),
    ],
    ids=["garbage", "nothing", "another library", "half a library"],
)  # fmt: skip
def test_what_a_compiler_wrote_is_tried_before_it_is_stored(cache, tmp_path, monkeypatch, script, found):
    monkeypatch.chdir(tmp_path)
    program = tmp_path / "mycc"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("CC", str(program))
    with pytest.raises(UsageError, match=found):
        small()
    assert not [p for p in cache.iterdir() if p.name.startswith("small")]


@pytest.mark.parametrize(("cc", "found"), [("", "CC is empty"), ("  ", "CC is empty"), ("cc 'x", "cannot read")])
def test_a_wrong_cc_is_a_sentence(monkeypatch, cc, found):
    monkeypatch.setenv("CC", cc)
    with pytest.raises(UsageError, match=found):
        store.compiler()


def test_a_run_starts_no_compiler_and_writes_no_library(tmp_path):
    """The engine comes with the package: whatever CC is and whatever lies in the cache, nothing of it is used."""
    model(tmp_path)
    cache = tmp_path / "cache" / "spacar"
    cache.mkdir(parents=True)
    environment = {**ENVIRONMENT, "CC": "/no/such/compiler", "XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert done(tmp_path, 1, "crank", env=environment)[0] == 0
    assert not list(cache.iterdir())


def test_symbolic_scripts_run_and_toml_files_do_not(tmp_path):
    """A .py model is a program of the user; the page of promises says so."""
    script = "open('RUN', 'w').close()\nfrom spacar.symbolic import MultibodySystem\nsystem = MultibodySystem()\n"
    (tmp_path / "m.py").write_text(script)
    program = [sys.executable, "-c", "import sys; from spacar_cli.main import main; sys.exit(main())"]
    subprocess.run([*program, "symbolic", "check", "m.py"], cwd=tmp_path, env=dict(os.environ), capture_output=True,
                   check=False)  # fmt: skip
    assert (tmp_path / "RUN").exists()


# A TOML model runs no code: no text of it enters what is executed or compiled, except checked names and numbers.
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
