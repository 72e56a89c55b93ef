"""What source distributions and wheels contain: the files of git and generated text; the folders of the packages."""

import importlib.util
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest
from spacar_cli.command_table import TOPICS

HOUSE = Path(__file__).parents[2]
STUB = "spacar/deck/keyword_methods.pyi"
TEXTS = {f"spacar/compiled/generated/{name}" for name in ("kernels.c", "derivatives.c")}
PACKAGES = {"spacar": "spacar", "formats/spacar_formats": "spacar_formats", "cli/spacar_cli": "spacar_cli",
            "cli/spacar_drawing": "spacar_drawing", "data": "spacar_cli/examples"}  # fmt: skip
pytestmark = [
    pytest.mark.skipif(not (HOUSE / ".git").exists(), reason="no files of git"),
    pytest.mark.skipif(importlib.util.find_spec("hatchling") is None, reason="no hatchling"),
    pytest.mark.skipif(not all((HOUSE / text).is_file() for text in TEXTS), reason="nothing was derived here"),
]


PAGES = {f"docs/{page}" for page in TOPICS.values()}


def of_git() -> set[str]:
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=HOUSE, capture_output=True, text=True, check=True)
    return {name for name in listed.stdout.split("\0") if name and (HOUSE / name).is_file()}


@pytest.fixture(scope="module")
def clone(tmp_path_factory) -> Path:
    """The files of git with what an installation in place leaves there, and machine code of somebody else."""
    folder = tmp_path_factory.mktemp("clone")
    for name in (*of_git(), *TEXTS):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(HOUSE / name, folder / name)
    for name in ("engine.so", "engine.dylib", "engine.dll"):
        (folder / "spacar" / "compiled" / name).write_bytes(b"foreign")
    (folder / ".git").mkdir()  # ends the search for rules about ignored files
    return folder


def built(clone: Path, target: str, folder: Path) -> Path:
    """A package without a compiler in sight."""
    words = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(folder)]
    done = subprocess.run(words, cwd=clone, env={**os.environ, "CC": "/nowhere/cc"}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    [made] = folder.iterdir()
    return made


def test_a_source_distribution_holds_the_files_of_git_and_generated_text(clone, tmp_path):
    with tarfile.open(built(clone, "sdist", tmp_path)) as packed:
        found = {name.partition("/")[2] for name in packed.getnames()}
    assert found == of_git() | TEXTS | {STUB, "PKG-INFO"}


def test_a_wheel_holds_what_the_folders_of_the_packages_hold(clone, tmp_path):
    """And the reason why it has no engine; no C text of the engine, no machine code of somebody else."""
    with zipfile.ZipFile(built(clone, "wheel", tmp_path)) as packed:
        found = {name for name in packed.namelist() if ".dist-info/" not in name and ".data/" not in name}
        assert packed.read("spacar/compiled/left_out.txt") == b"no C compiler (/nowhere/cc) was found"
    expected = {STUB, "spacar/compiled/left_out.txt", *(page.replace("docs", "spacar_cli/pages") for page in PAGES)}
    for name in of_git():
        for folder, package in PACKAGES.items():
            if name.startswith(f"{folder}/") and not (name.startswith("spacar/compiled/") and name.endswith(".c")):
                expected.add(f"{package}{name.removeprefix(folder)}")
    assert found == expected
    assert "spacar_formats/matlab/spacar.c" in found
