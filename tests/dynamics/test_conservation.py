"""Energy of conservative mechanisms, work of drives, and the virtual power of reactions."""

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.deck import read_deck
from spacar.dynamics import Dynamics
from spacar.kinematics.transfer import velocity_transfer
from spacar.mechanism import Mechanism, build
from tests.examples import DATA

from .reduced_form import chain, evaluator, random_state

G = 9.81


def energy(m: Mechanism, r: spacar.Result) -> np.ndarray:
    """Kinetic energy + half of e S e + potential of constant forces and gravity, at every stored step."""
    d = Dynamics(m)
    i, j, S = m.stiffness
    active = (i >= m.numbering.e_class["input"].stop) & (j >= m.numbering.e_class["input"].stop)
    result = []
    for f in r.frames:
        d.sweep.strain(f.x)
        d.sweep.mass()
        kinetic = 0.5 * f.xd @ d.sweep.mass_times(f.xd)
        elastic = 0.5 * np.sum((f.e[i] * S * f.e[j])[active])
        result.append(kinetic + elastic - m.loads.force @ f.x + potential(d, f.x))
    return np.array(result)


def potential(d: Dynamics, x: np.ndarray) -> float:
    """Minus the work of gravity on the masses from the start configuration: lumped masses and centre lines of beams.

    The gravity force of all families is M(x) g with constant weight, so the potential is -(g, first moments); for the
    families here M g is linear in the positions and tangents, and the integral along a straight path in x is exact by
    Gauss quadrature with 8 points to rounding (tangents are trigonometric or quadratic).
    """
    nodes, weights = np.polynomial.legendre.leggauss(8)
    x0 = d.mechanism.x0
    total = 0.0
    for s, w in zip(0.5 * (nodes + 1), 0.5 * weights, strict=True):
        d.sweep.strain(x0 + s * (x - x0))
        d.sweep.mass()
        total -= w * d.forces.gravity(d.sweep) @ (x - x0)
    return total


def conservative(rows: list[tuple], dynamics: list[tuple], tolerance: float) -> tuple[np.ndarray, spacar.Result]:
    deck = Deck.build(rows, [*dynamics, ("ERROR", tolerance, tolerance)])
    r = spacar.run(1, deck)
    return energy(build(deck), r), r


PENDULUM = (
    [
        ("PLBEAM", 1, 1, 2, 3, 4), ("PLBEAM", 2, 3, 4, 5, 6), ("X", 3, 0.5, 0.0), ("X", 5, 1.0, 0.0), ("FIX", 1), ("DYNX", 2),  # noqa: E501
        ("DYNE", 1, 2, 3), ("DYNE", 2),
    ],
    [
        ("EM", 1, 1.0, 0.01), ("EM", 2, 1.0), ("XM", 5, 0.5), ("ESTIFF", 1, 0.0, 5.0), ("ESTIFF", 2, 2000.0, 5.0),
        ("GRAVITY", 0.0, -G), ("XF", 5, 0.7, 0.3), ("TIMESTEP", 0.5, 12),
    ],
)  # fmt: skip
SPATIAL = (
    [
        ("HINGE", 1, 1, 2, 0.0, 0.0, 1.0), ("BEAM", 2, 3, 2, 4, 5, 0.0, 1.0, 0.0), ("HINGE", 3, 5, 6, 0.0, 1.0, 0.0),
        ("RBEAM", 4, 4, 6, 7, 0.0, 0.0, 1.0), ("X", 4, 0.6, 0.0, 0.2), ("X", 7, 0.6, -0.3, 0.5), ("FIX", 1), ("FIX", 3),
        ("DYNE", 1, 1), ("DYNE", 2, 2, 3, 4, 5, 6), ("DYNE", 3, 1),
    ],
    [
        ("EM", 2, 1.0, 0.02, 0.01, 0.01), ("EM", 4, 0.5), ("XM", 7, 0.4), ("XM", 6, 0.02, 0.0, 0.001, 0.03, 0.0, 0.02),
        ("ESTIFF", 2, 0.0, 30.0, 60.0, 40.0), ("GRAVITY", 0.0, 0.0, -G), ("STARTDE", 1, 1, 0.0, 3.0), ("STARTDE", 3, 1, 0.0, -2.0),  # noqa: E501
        ("TIMESTEP", 0.25, 6),
    ],
)  # fmt: skip


@pytest.mark.parametrize(("model", "tolerance"), [(PENDULUM, 1e-9), (SPATIAL, 1e-9)], ids=["planar", "spatial"])
def test_energy_is_kept_to_the_tolerance_of_the_integrator(model: tuple, tolerance: float) -> None:
    """Largest error a few hundred local errors: about 1000 steps; measured 30 to 100 times the tolerance."""
    E, r = conservative(*model, tolerance)
    d = Dynamics(r.mechanism)
    size = max(0.5 * f.xd @ _mass_times(d, f) for f in r.frames)
    assert size > 1.0
    assert np.abs(E - E[0]).max() < 300 * tolerance * size


def _mass_times(d: Dynamics, f: spacar.Frame) -> np.ndarray:
    d.sweep.strain(f.x)
    d.sweep.mass()
    return d.sweep.mass_times(f.xd)


def test_energy_with_wide_tolerances() -> None:
    for tolerance in (1e-4, 1e-6):
        E, _ = conservative(*PENDULUM, tolerance)
        assert np.abs(E - E[0]).max() < 300 * tolerance


def test_work_of_a_drive_equals_the_change_of_energy() -> None:
    """Prescribed hinge and prescribed elongation drive a flexible arm: integral of -sigma de/dt over the drives.

    Gauss-Legendre quadrature over the output points would need dense output; the trapezoidal rule over 2000 points a
    second has an error of (dt)^2 of the power's second derivative: 4e-5 of the work.
    """
    rows = [
        ("PLTOR", 1, 1, 2), ("PLBEAM", 2, 3, 2, 4, 5), ("X", 4, 0.7, 0.0), ("FIX", 1), ("FIX", 3), ("INPUTE", 1, 1),
        ("DYNE", 2, 2, 3), ("INPUTE", 2, 1),
    ]  # fmt: skip
    dynamics = [
        ("EM", 2, 1.0), ("XM", 4, 0.5), ("ESTIFF", 2, 0.0, 20.0), ("GRAVITY", 0.0, -G), ("INPUTE", 1, 1, 0.0, 1.0, 2.0),
        ("INPUTE", 2, 1, 0.0, 0.05, -0.02), ("TIMESTEP", 0.25, 500), ("ERROR", 1e-9, 1e-9),
    ]  # fmt: skip
    deck = Deck.build(rows, dynamics)
    r = spacar.run(1, deck)
    E = energy(build(deck), r)
    power = -(r.element(1, 1, "sig") * r.element(1, 1, "ed") + r.element(2, 1, "sig") * r.element(2, 1, "ed"))
    work = np.concatenate(([0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(r.t))))
    np.testing.assert_allclose(E - E[0], work, atol=4e-5 * np.abs(work).max())


def test_damping_takes_exactly_what_the_energy_loses() -> None:
    rows, dynamics = PENDULUM
    dynamics = [*dynamics[:-1], ("EDAMP", 1, 0.0, 0.02), ("EDAMP", 2, 5.0, 0.03), ("TIMESTEP", 0.25, 500)]
    E, r = conservative(rows, dynamics, 1e-9)
    m = r.mechanism
    i, j, S = m.damping
    power = np.array([np.sum(f.ed[i] * S * f.ed[j]) for f in r.frames])
    lost = np.concatenate(([0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(r.t))))
    np.testing.assert_allclose(E[0] - E, lost, atol=5e-4 * lost[-1])  # trapezoidal rule on 1 kHz vibrations


@pytest.mark.parametrize(
    "name", ["crank", "crankfl", "fourbar", "trike3v", "screw", "fingersim", "robotsim", "lateral4"]
)
def test_virtual_power_of_the_reactions_vanishes(name: str) -> None:
    """For every virtual velocity W dq that the constraints allow: dx.(f - M xdd - h) - de.sigma = 0 on dynamic q."""
    d = Dynamics(build(read_deck(DATA / f"{name}.dat", 1)))
    y = random_state(d, 1e-3, 0.1)
    d.place(0.0, y)
    f = d.frame(0.0, y)
    n = d.numbering
    W = velocity_transfer(d.kinematics)
    reactions = f.fxtot - f.fx - f.fxgrav
    dyn = n.dynamic
    fixed = np.arange(n.nx)[n.x_class["fixed"]]
    assert not W[fixed].any()
    power = W[:, dyn].T @ reactions
    assert np.abs(power).max(initial=0.0) < 1e-9 * max(np.abs(f.fxtot).max(), np.abs(f.sig).max(), 1e-12)
    # multipliers of fixed deformations do no work either
    We = d.kinematics.sweep_rates(W)
    assert np.abs(We[: n.e_class["input"].start, dyn]).max(initial=0.0) < 1e-10


def test_reactions_balance_weight_and_inertia() -> None:
    """Newton's law for a whole chain: sum of all external forces = rate of momentum."""
    d = evaluator(*chain(10, "mixed"))
    f = d.frame(0.3, random_state(d, 1e-3, 0.3))
    rows = [i for i in range(d.numbering.nx) if d.numbering.kind[d.numbering.x_owner(i)[0]] == "position"]
    for axis in (0, 1):
        direction = np.zeros(d.numbering.nx)
        direction[[i for i in rows if d.numbering.x_owner(i)[1] == axis + 1]] = 1.0
        h = d.sweep.inertia_force(d.xd, None)
        assert direction @ f.fxtot == pytest.approx(direction @ (d.sweep.mass_times(f.xdd) + h), rel=1e-10)
