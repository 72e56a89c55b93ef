"""Result files of non-holonomic systems: K0, N0, G0 have more columns than M0, C0."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

DATA = Path(__file__).resolve().parents[2] / "data"
BIN = Path(sys.executable).parent


def test_eigenvalues_of_a_tricycle_can_be_read(tmp_path):
    """M0 2 x 2 beside K0 2 x 7: a right file, nine eigenvalues."""
    shutil.copy(DATA / "trike2.dat", tmp_path)
    for command in (["spacar", "7", "trike2"], ["spacar", "getfrsbf", "trike2.sbm", "eigval"]):
        found = subprocess.run([BIN / command[0], *command[1:]], cwd=tmp_path, capture_output=True, text=True)
        assert found.returncode == 0, found.stderr
    assert len(found.stdout.strip().splitlines()) >= 9
