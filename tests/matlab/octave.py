"""Octave as a process: one script, its results as arrays."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from scipy.io import loadmat
from spacar_cli.main import main

QUOTE = "'"
PROGRAM = Path(sys.executable).parent / "spacar"


def need(*programs: str) -> None:
    """Skip where Octave is not installed, with a word."""
    for program in programs:
        if shutil.which(program) is None:
            pytest.skip(f"{program} is not installed (Debian: octave, octave-dev)")


def run_octave(script: str, folder: Path, *path: Path) -> dict[str, Any]:
    """The fields of the structure `out` that the script fills; strings and cells as loadmat gives them squeezed.

    The script runs in `folder` with `path` on Octave's path. What Octave prints is the field `printed`.
    """
    lines = ["out = struct();", *(f"addpath('{str(p).replace(QUOTE, 2 * QUOTE)}');" for p in path)]
    lines += [script, "save('-mat7-binary', 'octave_out.mat', '-struct', 'out');"]
    (folder / "octave_script.m").write_text("\n".join(lines), encoding="utf-8")
    done = subprocess.run(
        ["octave-cli", "--norc", "--quiet", "octave_script.m"], cwd=folder, capture_output=True, text=True, timeout=300,
        stdin=subprocess.DEVNULL, env=os.environ | {"OMP_NUM_THREADS": "1"}, check=False,
    )  # fmt: skip
    result = folder / "octave_out.mat"
    assert result.is_file(), f"{done.stdout}\n{done.stderr}"
    found: dict[str, Any] = loadmat(result, simplify_cells=True)
    result.unlink()
    return found | {"printed": done.stdout + done.stderr}


def analyse(mode: int, source: Path) -> Path:
    """Run a mode in this process; the name of the results without extension."""
    assert main([str(mode), str(source), "--quiet"]) == 0
    return source.with_suffix("")
