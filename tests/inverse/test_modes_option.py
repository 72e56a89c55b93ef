"""`spacar 3 --modes` and what reads its files, as a user meets them above the size from which equations are sparse."""

import numpy as np
import pytest
from spacar_formats.ltvfile import read_ltv

import spacar
from spacar.errors import UsageError
from spacar.linear import form
from tests.command_line import call

BEAMS = 3
NODES = range(1, BEAMS + 1)
ARM = [*(f"PLBEAM {i} {2 * i - 1} {2 * i} {2 * i + 1} {2 * i + 2}" for i in NODES),
       *(f"X {2 * i + 1} {0.3 * i} 0." for i in NODES), "FIX 1", "INPUTX 2 1"]  # fmt: skip
MASSES = [f"EM {i} 2." for i in NODES]
STIFF = [*(f"ESTIFF {i} 0. 200." for i in NODES), *(f"EDAMP {i} 0. 0.02" for i in NODES)]
TURN = ["TRAJECT 1", "TROT 2 0.8", "TRVMAX 2 0.1", "TRTIME 0.5 5"]
PORTS = ["NOMF 1 2 1", "REFX 1 2 1", f"REFX 2 {2 * BEAMS + 1} 1"]
BENDING = [f"INPUTE {i} 3" for i in NODES]  # rigid in mode 2


def text(*blocks: list[str]) -> str:
    return "\nHALT\n".join("\n".join([*block, "END"]) for block in blocks) + "\nEND\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A turning arm in three beams, linearized along its motion as a large model is."""
    monkeypatch.setattr(form, "LARGE", 0)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.dat").write_text(text(ARM, MASSES, [*TURN, *PORTS]))
    (tmp_path / "armlin.dat").write_text(text([*ARM, *BENDING], [*MASSES, *STIFF], PORTS))
    call.done(2, "arm")
    call.done(3, "armlin")
    return tmp_path


def test_a_number_of_modes_is_refused_before_files_are_touched(folder):
    before = {p.name: p.read_bytes() for p in folder.iterdir()}
    err = call.refused(3, "armlin", "--modes", 5)
    assert "mode 3 computes no modes of vibration: the option modes = 5 can only be 0" in err
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before
    with pytest.raises(UsageError, match="modes = 5 can only be 0"):
        spacar.run(3, folder / "armlin.dat", modes=5)


def test_gains_need_the_matrices_that_modes_0_asks_for(folder):
    """The refusal says how large the model is and what to do, and leaves no file; what it says helps."""
    gain = ("spacntrl", "armlin", "--kp", 10)
    err = call.refused(*gain)
    assert "armlin.ltv has no m0" in err
    assert f"({BEAMS + 1} degrees of freedom) with --modes 0 (MODES 0): run it again" in err
    assert not (folder / "armlinkp.ltv").exists()
    call.done(3, "armlin", "--modes", 0)
    log = (folder / "armlin.log").read_text()
    assert "--modes      0" in log
    assert "sparse" not in log
    call.done(*gain)
    before, after = (read_ltv(folder / name)[0] for name in ("armlin", "armlinkp"))
    change = np.zeros((BEAMS + 1, BEAMS + 1))
    change[0, 0] = 10.0  # the moment acts on the input, the first degree of freedom
    np.testing.assert_allclose(after.k0b - before.k0b, np.broadcast_to(change, before.k0b.shape), atol=1e-9)
