"""A, B, C, D (theory-system.md (15)) of every input and output kind against differences of the non-linear model.

The truth is the saddle-point form of the equations of motion, evaluated with varied state and inputs.
"""

from dataclasses import replace

import numpy as np
import pytest

from spacar import run
from spacar.arrays import Array
from spacar.deck import parse_deck
from spacar.kinematics.transfer import configuration_transfer, second_order_transfer, third_order_transfer
from spacar.linear.state_space import state_space
from spacar.linearization import linearize
from spacar.linearization.signals import DRIVING_SIGN, Signal, linearization_signals
from tests.examples import DATA

from .linear_models import PLANAR, SPATIAL, TRIKE_SPRING, TUBE, example, mechanism
from .nonlinear import Nonlinear, State, jacobian, random_state


def signals(inputs: dict[str, str], outputs: dict[str, str]) -> str:
    """A third block: the nodes and elements of every kind, each with a coordinate or a mode, numbered from 1."""
    lines = []
    for given in (inputs, outputs):
        places = [(kind, place) for kind, several in given.items() for place in several.split(", ")]
        lines += [f"{kind} {k} {place}" for k, (kind, place) in enumerate(places, 1)]
    return "\n".join([*lines, ""])


PLANAR_SIGNALS = signals(
    {"INPUTS": "1 2, 2 1", "INPUTF": "5 1, 5 2", "INE": "4 1", "INEP": "4 1", "INEDP": "4 1",
     "INX": "7 1", "INXP": "7 1", "INXDP": "7 1"},
    {"OUTS": "1 1, 4 1, 1 3, 3 1, 1 2, 2 1", "OUTE": "2 1, 4 1", "OUTEP": "2 1", "OUTEDP": "3 1",
     "OUTF": "1 1, 7 1, 8 1", "OUTX": "9 1", "OUTXP": "9 2, 7 1", "OUTXDP": "6 1"},
)  # fmt: skip
SPATIAL_SIGNALS = signals(
    {"INPUTS": "1 4, 4 1", "INPUTF": "6 2, 7 3", "INE": "5 1", "INEP": "5 1", "INEDP": "5 1",
     "INX": "8 1", "INXP": "8 1", "INXDP": "8 1"},
    {"OUTS": "1 1, 5 2, 3 5, 4 1", "OUTEDP": "4 1", "OUTEP": "4 1", "OUTF": "1 3, 8 1, 9 3",
     "OUTX": "10 3", "OUTXP": "7 2", "OUTXDP": "6 1"},
)  # fmt: skip
TRIKE_SIGNALS = signals(
    {"INPUTS": "6 1", "INPUTF": "3 1"},
    {"OUTS": "1 1, 2 2", "OUTE": "6 1", "OUTXP": "1 1", "OUTXDP": "7 2", "OUTEDP": "6 1"},
)
TUBE_SIGNALS = signals(
    {"INX": "2 1", "INXP": "2 1", "INXDP": "2 1", "INPUTF": "5 2"},
    {"OUTF": "2 1, 1 1", "OUTS": "2 1", "OUTXDP": "5 2"},
)
SPATIAL_TRIKE_SIGNALS = signals(
    {"INPUTS": "8 1", "INPUTF": "3 1"},
    {"OUTE": "5 1, 12 1", "OUTEP": "10 1", "OUTXP": "1 1", "OUTXDP": "9 2", "OUTEDP": "13 1"},
)
# a distance, whose rate depends on the configuration, is a kinematic coordinate in place of x
DISTANCE = ("KINX 1 1\n", "TRUSS 13 15 1\nX 15 -1. 0.5 0.2\nFIX 15\nKINE 13 1\n")


def with_signals(text: str) -> tuple[str, str]:
    """The end of a tricycle's file, and this with signals behind it."""
    return "TIMESTEP 1.0 100\nEND\n", f"TIMESTEP 1.0 100\nEND\nHALT\n{text}END\n"


MODELS = {
    "planar": lambda folder: (mechanism(PLANAR, third=PLANAR_SIGNALS), 0.05),
    "with user function": lambda folder: (
        mechanism(PLANAR, extra="USERSIG forces", third=PLANAR_SIGNALS, folder=folder), 0.05,
    ),
    "spatial": lambda folder: (mechanism(SPATIAL, third=SPATIAL_SIGNALS), 0.05),
    "tubes": lambda folder: (mechanism(TUBE, third=TUBE_SIGNALS), 0.05),
    "tricycle": lambda folder: (example("trike2", 4, TRIKE_SPRING, with_signals(TRIKE_SIGNALS)), 0.1),
    "spatial tricycle": lambda folder: (example("trike3v", 4, DISTANCE, with_signals(SPATIAL_TRIKE_SIGNALS)), 0.02),
}  # fmt: skip
RATE = {"INX": 0, "INE": 0, "INXP": 1, "INEP": 1, "INXDP": 2, "INEDP": 2}


class Loaded:
    """zdot and the outputs as functions of the state z and the inputs u."""

    def __init__(self, model: Nonlinear, inputs: list[Signal], outputs: list[Signal]) -> None:
        self.model, self.inputs, self.outputs = model, inputs, outputs
        self.force, self.preload = model.d.forces.constant.copy(), model.d.law.preload.copy()

    def state(self, z: Array, u: Array) -> State:
        n, base = self.model.n, self.model.base
        s, qd, qdd = base.s.copy(), base.qd.copy(), base.qdd.copy()
        rows = np.r_[n.dynamic, np.arange(n.ndof, n.nkdof)]
        s[rows], qd[n.dynamic] = z[: len(rows)], z[len(rows) :]
        for signal, value in zip(self.inputs, u, strict=True):
            if signal.kind in RATE:
                places = n.q_x if signal.kind.startswith("INX") else n.q_e
                row = list(places).index(signal.index) + (0 if signal.kind.startswith("INX") else len(n.q_x))
                (s, qd, qdd)[RATE[signal.kind]][row] += value
        return State(s, qd, qdd)

    def load(self, u: Array) -> None:
        forces, law = self.model.d.forces, self.model.d.law
        forces.constant[:], law.preload[:] = self.force, self.preload
        for signal, value in zip(self.inputs, u, strict=True):
            if signal.kind == "INPUTF":
                forces.constant[signal.index] += value
            if signal.kind == "INPUTS":
                law.preload[signal.index] -= DRIVING_SIGN * value

    def __call__(self, zu: Array) -> Array:
        """zdot and y, one after the other."""
        d, n = self.model.d, self.model.n
        u = zu[len(zu) - len(self.inputs) :]
        state = self.state(zu[: len(zu) - len(u)], u)
        self.load(u)
        self.model.place(state)
        frame = d.frame(0.0, self.model.y)
        qd = np.concatenate((frame.xd[n.q_x], frame.ed[n.q_e]))[n.dynamic]
        qdd = np.concatenate((frame.xdd[n.q_x], frame.edd[n.q_e]))[n.dynamic]
        kinematic = np.concatenate((frame.xd[n.x_class["kinematic"]], frame.ed[n.e_class["kinematic"]]))
        vectors = {
            "OUTX": frame.x, "OUTXP": frame.xd, "OUTXDP": frame.xdd, "OUTF": frame.fxtot,
            "OUTE": frame.e, "OUTEP": frame.ed, "OUTEDP": frame.edd, "OUTS": frame.sig,
        }  # fmt: skip
        return np.concatenate((qd, kinematic, qdd, [vectors[s.kind][s.index] for s in self.outputs]))


@pytest.mark.parametrize("name", MODELS)
def test_state_space_matrices(name, tmp_path):
    m, size = MODELS[name](tmp_path)
    base = random_state(m, size, seed=5)
    model = Nonlinear(m, base)
    inputs, outputs = linearization_signals(m)
    loaded = Loaded(model, inputs, outputs)
    drive = model.place(base)
    xdd, sigma, _ = model.d.accelerate(0.0, drive)
    n = m.numbering
    qdd = np.concatenate((xdd[n.q_x], (model.d.sweep.rate(xdd) + model.d.sweep.convective(model.d.xd))[n.q_e]))
    model.base = replace(base, qdd=qdd)
    ss = state_space(model.d, linearize(model.d, xdd, sigma), inputs, outputs)

    rows = np.r_[n.dynamic, np.arange(n.ndof, n.nkdof)]
    z = np.concatenate((base.s[rows], base.qd[n.dynamic]))
    truth = jacobian(loaded, np.concatenate((z, np.zeros(len(inputs)))))
    ours = np.block([[ss.A, ss.B], [ss.C, ss.D]])
    for row, signal in enumerate([*n.dynamic, *n.k_names, *n.dynamic, *(s.name for s in outputs)]):
        error, scale = np.max(np.abs(ours[row] - truth[row])), np.max(np.abs(truth[row]))
        assert error <= 1e-7 * max(scale, 1.0), (row, signal, error, scale)


def test_lever():
    """The printed numbers of the lever: A = [0 1; -1000 -5], |B| 2000, |C| 3000, |D| 6000, sign of D by figure."""
    frame = run(9, DATA / "lever.dat").frames[0].state_space
    assert np.allclose(frame["A"], [[0, 1], [-1000, -5]], rtol=1e-12, atol=1e-9)
    assert np.allclose(frame["B"], [[0], [-2000]], rtol=1e-12, atol=1e-9)
    assert np.allclose(frame["C"], [[-3000, 0]], rtol=1e-12, atol=1e-9)
    assert np.allclose(frame["D"], [[-6000]], rtol=1e-12)


# Matrices of theory-system.md (13) against differences of the non-linear residual at moving, loaded, flexible
# states. 1e-7 relative is the accuracy that the project demands; differences of order 8 reach about 1e-10.
MATRIX_MODELS = {
    "planar": lambda folder: (mechanism(PLANAR), 0.05),
    "planar with user function": lambda folder: (mechanism(PLANAR, extra="USERSIG forces", folder=folder), 0.05),
    "spatial": lambda folder: (mechanism(SPATIAL), 0.05),
    "planar tubes": lambda folder: (mechanism(TUBE), 0.05),
    "planar tricycle": lambda folder: (example("trike2", 4, TRIKE_SPRING), 0.1),
    "spatial tricycle": lambda folder: (example("trike3v", 4), 0.02),
    "finger": lambda folder: (example("finger", 4), 0.05),
    "spatial crank": lambda folder: (example("lateral4", 4), 0.05),
}


def close(value: np.ndarray, truth: np.ndarray, tolerance: float = 1e-7) -> bool:
    size = np.max(np.abs(truth), initial=0.0)
    return bool(np.max(np.abs(value - truth), initial=0.0) <= tolerance * max(size, 1e-3))


@pytest.fixture(params=MATRIX_MODELS, scope="module")
def case(request, tmp_path_factory):
    m, size = MATRIX_MODELS[request.param](tmp_path_factory.mktemp("model"))
    base = random_state(m, size, seed=3)
    model = Nonlinear(m, base)
    model.place(base)
    xdd = model.accelerations(base)
    sigma, _ = model.d.constitutive(0.0)
    return model, base, linearize(model.d, xdd, sigma)


def test_matrices(case):
    model, base, L = case
    assert close(L.m0, jacobian(lambda a: model.residual(replace(base, qdd=a)), base.qdd))
    assert close(L.m0, L.m0.T, 1e-13)
    assert close(L.c0 + L.d0, jacobian(lambda v: model.residual(replace(base, qd=v)), base.qd))
    assert close(L.d0, L.d0.T, 1e-13)
    assert close(L.k0 + L.n0 + L.g0, jacobian(lambda s: model.residual(replace(base, s=s)), base.s))
    assert close(L.ak0, jacobian(lambda v: model.kinematic_rates(replace(base, qd=v)), base.qd))
    assert close(L.bk0, jacobian(lambda s: model.kinematic_rates(replace(base, s=s)), base.s))


# Third order transfer functions against differences of the second order ones, and what the log gets.
@pytest.mark.parametrize("text", [PLANAR, SPATIAL], ids=["planar", "spatial"])
def test_third_order_transfer(text):
    m = mechanism(text)
    base = random_state(m, 0.05, seed=1)
    model = Nonlinear(m, base)

    def second(s: np.ndarray) -> np.ndarray:
        model.place(type(base)(s, 0 * base.qd, 0 * base.qdd))
        k = model.d.kinematics
        return np.concatenate([A.ravel() for A in second_order_transfer(k, configuration_transfer(k))])

    truth = jacobian(second, base.s)
    model.place(base)
    k = model.d.kinematics
    G = configuration_transfer(k)
    ours = np.concatenate(
        [A.reshape(-1, G.shape[1]) for A in third_order_transfer(k, G, second_order_transfer(k, G)[0])]
    )
    # differences of order 8 of numbers of size 10 to 1000: 1e-8 relative is far above their rounding
    assert np.max(np.abs(ours - truth)) <= 1e-8 * np.max(np.abs(truth))


@pytest.mark.parametrize("mode", [4, 7, 8, 9])
def test_log_levels(mode):
    text = PLANAR.format(extra="", third="").replace("DYNE 1 2 3 ", "DYNE 1 2 3   OUTLEVEL 15 0 ", 1)
    if mode != 4:
        text = text.replace("1.6 0.3 0.2", "1.6").replace("0.1 0.2 0.3", "0.1")
    frame = run(mode, parse_deck(text, mode=mode)).frames[0]
    assert set(frame.log) == {"dx", "de", "d2x", "d2e", "d3x", "d3e", "bigd"}
    assert frame.dx is None  # not asked for in the result file
    n = frame.log["dx"].shape[1]
    assert frame.log["d2x"].shape[1] == n**2
    assert frame.log["d3e"].shape == (len(frame.e), n**3)
