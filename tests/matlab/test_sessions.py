"""Sessions of SPACAR's documentation, typed into Octave as printed there: arrays of a run are in the workspace."""

import re
import shutil

import numpy as np
import pytest
from spacar_formats import mex
from spacar_formats.getss import getss

import spacar
from spacar.deck import parse_deck
from spacar.linear import form
from tests.docs.documents import blocks
from tests.examples import DATA

from .models import TRANSFER
from .octave import PROGRAM, need, run_octave

# what is typed, and what is printed there (signs of the lever are those of the theory: the scan has none)
SESSIONS = {
    "massspring": ("""
spacar(7,'massspring')
out.x1 = x(lnp(3,1)); out.x2 = x(lnp(5,1));
spacar(7,'massspring')
out.m = m0; out.k = k0; out.n = n0;
""", {"x1": 0.1184, "x2": 0.2891, "m": [[0.8, 0], [0, 0.5]], "k": [[2000, -700], [-700, 700]],
      "n": [[-80, 0], [0, -50]]}),
    "lever": ("""
spacar(9,'lever')
out.A=getfrsbf('lever.ltv','A',1); out.B=getfrsbf('lever.ltv','B',1);
out.C=getfrsbf('lever.ltv','C',1); out.D=getfrsbf('lever.ltv','D',1);
""", {"A": [[0, 1], [-1000, -5]], "B": [0, -2000], "C": [-3000, 0], "D": -6000}),
    "crank": ("""
spacar(1,'crank')
out.size = size(x); out.times = numel(time); out.first = x(1,lnp(6,1)); out.acceleration = xdd(1,lnp(6,1));
out.stress = size(sig(:,le(1:2,1)));
""", {"size": [101, 10], "times": 101, "first": 0.45, "acceleration": -5062.5, "stress": [101, 2]}),
}  # fmt: skip
FUNCTION = """
function stays()
  m0 = 5; spacar(7, 'massspring'); assert(m0 == 5); assert(~exist('k0', 'var'));
end
stays()
out.before = exist('k0', 'var');
result = spacar(7, 'massspring'); out.field = result.k0; out.after = exist('k0', 'var');
spacar(7, 'massspring')
out.typed = k0; out.marker = exist('spacar_is_called_from_here', 'var');
spavisual('massspring', 7);
"""


@pytest.fixture(scope="module", params=["m", "mex"])
def folder(request, tmp_path_factory):
    need("octave-cli", *(["mkoctfile"] if request.param == "mex" else []))
    if request.param == "m":
        return mex.FOLDER
    made = tmp_path_factory.mktemp("mex")
    mex.build(made)
    return made


@pytest.mark.slow
@pytest.mark.parametrize("name", SESSIONS)
def test_a_session_of_the_documentation(tmp_path, monkeypatch, folder, name):
    monkeypatch.setenv("SPACAR_COMMAND", f'"{PROGRAM}"')
    shutil.copy(DATA / f"{name}.dat", tmp_path)
    typed, printed = SESSIONS[name]
    out = run_octave(typed, tmp_path, folder)
    for key, value in printed.items():
        np.testing.assert_allclose(out[key], value, rtol=1e-3, atol=1e-3, err_msg=key)


@pytest.mark.slow
def test_functions_keep_their_variables(tmp_path, monkeypatch, folder):
    """The front-end calls spacar from functions and reads the files."""
    monkeypatch.setenv("SPACAR_COMMAND", f'"{PROGRAM}"')
    shutil.copy(DATA / "massspring.dat", tmp_path)
    out = run_octave(FUNCTION, tmp_path, folder)
    assert (out["before"], out["after"], out["marker"]) == (0, 0, 0)
    assert np.array_equal(out["field"], out["typed"])
    assert list(tmp_path.glob("massspring*.png"))


# The blocks of docs/matlab.md, from top to bottom in one Octave session; `value   % = 1.5` is compared.
PAGE = DATA.parent / "docs" / "matlab.md"
VALUE = re.compile(r"^(\S.*?[^;\s])\s+% = (\S+)$", re.MULTILINE)
CHECK = r"out.values(end + 1) = \1; out.expected(end + 1) = \2;"


@pytest.mark.slow
def test_the_page(tmp_path, monkeypatch):
    """Printed numbers to their last digit."""
    need("octave-cli")
    for name in ("plbeam5", "robotinv", "robotinvlin", "massspring"):
        shutil.copy(DATA / f"{name}.dat", tmp_path)
    text = "\n".join(block.text for block in blocks(PAGE) if block.language == "matlab")
    monkeypatch.setenv("SPACAR_COMMAND", str(PROGRAM))
    script = "out.values = []; out.expected = [];\n" + VALUE.sub(CHECK, text)
    done = run_octave(script, tmp_path, mex.FOLDER)
    assert len(done["values"]) == 10
    assert abs(done["values"] - done["expected"]).max() < 5e-5


def test_eliminated_in_octave(tmp_path, monkeypatch):
    """getss.m of the sparse system of a large model (asp, bsp, csp), against getss of Python."""
    need("octave-cli")
    monkeypatch.setattr(form, "LARGE", 1)
    spacar.run(9, parse_deck(TRANSFER.replace("OUTLEVEL 0 1\n", ""), mode=9)).save(tmp_path / "large")
    expected = getss(tmp_path / "large")
    script = "[out.A, out.B, out.C, out.D] = getss('large'); s = getss('large'); out.names = s.StateName;"
    found = run_octave(script, tmp_path, mex.FOLDER)
    for name, matrix in zip("ABCD", (*expected,), strict=True):
        size = max(np.abs(matrix).max(), 1e-9)  # D is zero here
        np.testing.assert_allclose(np.reshape(found[name], matrix.shape), matrix, atol=1e-9 * size)
    assert tuple(map(str, found["names"])) == expected.states
