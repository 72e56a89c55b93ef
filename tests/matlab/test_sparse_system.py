"""getss.m of the sparse system of a large model (asp, bsp, csp) in Octave, against getss of Python."""

import numpy as np
from spacar_formats.getss import getss
from spacar_formats.mex import FOLDER

import spacar
from spacar.deck import parse_deck
from spacar.linear import form

from .models import TRANSFER
from .octave import need, run_octave


def test_eliminated_in_octave(tmp_path, monkeypatch):
    need("octave-cli")
    monkeypatch.setattr(form, "LARGE", 1)
    spacar.run(9, parse_deck(TRANSFER.replace("OUTLEVEL 0 1\n", ""), mode=9)).save(tmp_path / "large")
    expected = getss(tmp_path / "large")
    script = "[out.A, out.B, out.C, out.D] = getss('large'); s = getss('large'); out.names = s.StateName;"
    found = run_octave(script, tmp_path, FOLDER)
    for name, matrix in zip("ABCD", (*expected,), strict=True):
        size = max(np.abs(matrix).max(), 1e-9)  # D is zero here
        np.testing.assert_allclose(np.reshape(found[name], matrix.shape), matrix, atol=1e-9 * size)
    assert tuple(map(str, found["names"])) == expected.states
