"""Result files of non-holonomic systems: K0, N0, G0 have more columns than M0, C0."""

import shutil

from tests.command_line import call
from tests.examples import DATA


def test_eigenvalues_of_a_tricycle_can_be_read(tmp_path):
    """M0 2 x 2 beside K0 2 x 7: a right file, nine eigenvalues."""
    shutil.copy(DATA / "trike2.dat", tmp_path)
    assert call("7", tmp_path / "trike2").status == 0
    found = call.done("getfrsbf", tmp_path / "trike2.sbm", "eigval")
    assert len(found.out.strip().splitlines()) >= 9
