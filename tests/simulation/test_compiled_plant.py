"""The mechanism of a simulation in C and in NumPy: the same outputs, derivatives and frames to rounding.

Positions are known to 1e-11 of their size where Newton's iteration stops; stiffness and inertia turn that into
accelerations and stresses: 1e-8 of the largest value of each kind, as in tests/compiled/test_everything.py.
"""

from pathlib import Path

import numpy as np
import pytest

from spacar.compiled.library import why_off
from spacar.simulation.plant import Spasim
from tests.command_line import call
from tests.examples import DATA

pytestmark = pytest.mark.skipif(why_off() is not None, reason=str(why_off()))
MODEL = "TRUSS 1 1 2\nX 2 0. 0. 1.\nFIX 1\nDYNX 2 1 2\nDYNE 1 1\nEND\nHALT\nXM 2 2.\nESTIFF 1 50.\nEDAMP 1 0.3\n"
INPUTS = "END\nHALT\nINPUTS 1 1 1\nINPUTF 2 2 1\n"
OUTPUTS = "OUTE 1 1 1\nOUTEP 2 1 1\nOUTEDP 3 1 1\nOUTX 4 2 1\nOUTXP 5 2 2\nOUTXDP 6 2 1\nEND\nEND\n"
USER = "def law(t, ne, le, e, ep, nx, lnp, x, xp):\n  return t, [[1, 1, 2.0 * t]], [[2, 2, -x[lnp[1][0]]]]\n"


def pair(model: Path) -> tuple[Spasim, Spasim]:
    compiled, general = Spasim(model), Spasim(model)
    general.choose(False)
    assert (compiled.engine[0], general.engine[0]) == ("compiled", "general")
    return compiled, general


def close(got: np.ndarray, want: np.ndarray) -> None:
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-8 * np.abs(want).max(initial=1.0))


def compare(compiled: Spasim, general: Spasim) -> None:
    x0, rng = compiled.start(), np.random.default_rng(3)
    np.testing.assert_array_equal(x0, general.start())
    for k in range(4):
        t, x, u = 0.01 * k, x0 + 1e-3 * rng.standard_normal(len(x0)), rng.standard_normal(compiled.n_in)
        close(compiled.state_outputs(t, x), general.state_outputs(t, x))
        placed = compiled.state_outputs(t, x)
        for inputs in (u, -u):
            np.testing.assert_array_equal(compiled.outputs(t, x, inputs)[~compiled.direct], placed[~compiled.direct])
            close(compiled.outputs(t, x, inputs), general.outputs(t, x, inputs))
            close(compiled.derivative(t, x, inputs), general.derivative(t, x, inputs))
        a, b = compiled.frame(t, x, u), general.frame(t, x, u)
        for name in ("x", "xd", "xdd", "e", "ed", "edd", "sig", "fx", "fxtot"):
            close(getattr(a, name), getattr(b, name))


@pytest.mark.parametrize("name", ["robotsim", "robotflexsim"])
def test_examples(name: str) -> None:
    compare(*pair(DATA / f"{name}.dat"))


@pytest.fixture(params=["", "USERSIG law\n"], ids=["plain", "user function"])
def model(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    (tmp_path / "law.py").write_text(USER)
    (tmp_path / "a.dat").write_text(MODEL.replace("EDAMP", f"{request.param}EDAMP") + INPUTS + OUTPUTS)
    return tmp_path / "a.dat"


def test_all_kinds_of_ports(model: Path) -> None:
    compare(*pair(model))


def test_a_state_that_c_cannot_do_is_left_to_numpy(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled, general = pair(model)
    monkeypatch.setattr(compiled.motion.evaluator, "reach", lambda *_: False)
    compare(compiled, general)


def test_inputs_that_stay_are_not_asked_for_again(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant = Spasim(model)
    x, u, count = plant.start(), np.ones(2), []
    reach = plant.motion.evaluator.reach
    monkeypatch.setattr(plant.motion.evaluator, "reach", lambda *at: count.append(1) or reach(*at))
    plant.derivative(0.0, x, u)
    assert len(count) == 2
    for k in range(1, 4):
        plant.state_outputs(0.1 * k, x)
        plant.derivative(0.1 * k, x, u)
        assert len(count) == 2 + k


@pytest.mark.parametrize("general", [False, True])
def test_the_log_says_which_engine(model: Path, general: bool) -> None:
    source = model.with_name("b.sim")
    source.write_text("[simulation]\ntime = 0.1\nstep = 0.05\n\n[truss]\nblock = spasim\nmodel = a\n\n[wires]\n")
    call.done("sim", source, *["--general"] * general)
    log = source.with_name("b_sim.log").read_text()
    assert ("engine: general (--general or compiled=False asks for it)" in log) == general
    assert ("engine: compiled (" in log) != general
