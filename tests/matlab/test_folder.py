"""The command `spacar matlab`, what is in the folder, and that all of it is MATLAB's language, not only Octave's."""

import re
import stat
from pathlib import Path

import pytest
from spacar_cli.main import main
from spacar_formats import mex

HOUSE = Path(__file__).resolve().parents[2]
EXPECTED = {
    "spacar", "spacar_build", "getfrsbf", "loadsbd", "loadsbm", "getss", "repinsbf", "combsbd", "checksbf", "spavisual",
    "spadraw", "stressbeam", "mrltv", "spacntrl",
}  # fmt: skip
ONLY_OCTAVE = {
    "a double-quoted text": r'(?<![\w\'\]\)}"])"(?!\')[^"\']*"',
    "a comment with #": r"^\s*#|\s#\s",
    "an end with a name": r"\bend(if|for|while|function|switch)\b|\bend_",
    "not as !": r"!(=|\w|\()",
    "+= and the like": r"[-+*/|]=(?!=)|\+\+|--\w*;",
    "a function of Octave": r"(?<!\.)\b(printf|puts|stat|unwind_protect|fdisp|postpad|prepad|merge)\s*\(",
    "indexing a result": r"\)\(|\}\([^)]*\)\(",
}


def code(path: Path) -> list[str]:
    """Lines without comments and texts."""
    found = []
    for line in path.read_text(encoding="utf-8").splitlines():
        plain = re.sub(r"(?<![\w\])}'.])'(?:[^']|'')*'", "0", line)
        found.append(plain.split("%")[0])
    return found


def test_the_command_prints_a_folder_that_has_everything(capsys):
    assert main(["matlab"]) == 0
    folder = Path(capsys.readouterr().out.strip())
    assert folder == mex.FOLDER
    assert {path.stem for path in folder.glob("*.m")} >= EXPECTED
    contents = (folder / "Contents.m").read_text(encoding="utf-8")
    assert set(re.findall(r"^%   (\w+) +- ", contents, re.MULTILINE)) == EXPECTED


def test_the_folder_is_in_the_wheel():
    project = (HOUSE / "pyproject.toml").read_text()
    packages = re.findall('"([^"]+)"', re.findall(r"^packages = \[(.*)\]$", project, re.MULTILINE)[0])
    assert any((HOUSE / package) in mex.FOLDER.parents for package in packages)


@pytest.mark.parametrize("path", sorted(mex.FOLDER.rglob("*.m")), ids=lambda p: p.name)
def test_it_is_the_language_of_matlab(path):
    for number, line in enumerate(code(path), 1):
        for what, pattern in ONLY_OCTAVE.items():
            assert not re.search(pattern, line), f"{path.name}:{number}: {what}: {line}"


def test_without_a_compiler_nothing_is_written(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["matlab", "--build", str(tmp_path / "made")]) == 2
    said = capsys.readouterr().err
    assert "octave-dev" in said
    assert "spacar_build(" in said
    assert not (tmp_path / "made").exists()


def compiler(folder: Path, name: str, text: str) -> None:
    path = folder / name
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


def test_a_compiler_that_fails_is_told(tmp_path, monkeypatch, capsys):
    """Also `mex` of a TeX installation, which is another program: it gets no input and writes no MEX file."""
    compiler(tmp_path, "mkoctfile", "echo no headers >&2; exit 1")
    compiler(tmp_path, "mex", "exit 0")
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin" if not Path("/usr/bin/mex").exists() else str(tmp_path))
    assert main(["matlab", "--build", str(tmp_path / "made")]) == 1
    said = capsys.readouterr().err
    assert "no headers" in said
    assert "wrote no MEX file" in said
    assert (tmp_path / "made" / "getfrsbf.m").is_file()


def test_both_compilers_build_into_one_folder(tmp_path, monkeypatch, capsys):
    compiler(tmp_path, "mkoctfile", "echo octave > spacar.mex")
    compiler(tmp_path, "mex", "echo matlab > spacar.mexa64")
    monkeypatch.setenv("PATH", f"{tmp_path}")
    assert main(["matlab", "--build", str(tmp_path / "made here")]) == 0
    done = capsys.readouterr()
    assert done.out.strip() == str(tmp_path / "made here")
    assert "built spacar.mex\nbuilt spacar.mexa64" in done.err
    made = {path.relative_to(tmp_path / "made here") for path in (tmp_path / "made here").rglob("*.[mc]")}
    assert made == {path.relative_to(mex.FOLDER) for path in mex.FOLDER.rglob("*.[mc]")}


def test_a_folder_that_cannot_be_written_is_refused(tmp_path, monkeypatch, capsys):
    compiler(tmp_path, "mkoctfile", "exit 0")
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "file").write_text("")
    assert main(["matlab", "--build", str(tmp_path / "file")]) == 2
    assert "cannot write" in capsys.readouterr().err
