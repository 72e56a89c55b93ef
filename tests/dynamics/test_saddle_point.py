"""Accelerations, stresses and nodal forces from the saddle-point form against the reduced dense form and 40 digits."""

import mpmath
import numpy as np
import pytest

from spacar.deck import read_deck
from spacar.dynamics import Dynamics
from spacar.mechanism import DriveState, build
from tests.examples import DATA

from .reduced_form import Solution, chain, difference, evaluator, parts, random_state, reduced


def saddle_point(d: Dynamics, t: float, y: np.ndarray) -> tuple[Solution, DriveState]:
    """What the program stores. Placed twice: then V belongs to the converged position and not to an iterate
    1e-11 away.
    """
    d.place(t, y)
    f = d.frame(t, y)
    return Solution(f.xdd, f.edd, f.sig, f.fxtot, 0.0), d.drive.at(t)


def compare(d: Dynamics, y: np.ndarray, tolerance: float, t: float = 0.3) -> float:
    """Differences of all four results; returns the condition of the reduced mass matrix."""
    a, drive = saddle_point(d, t, y)
    b = reduced(d, t, drive)
    for name in ("xdd", "edd", "sigma"):
        assert difference(getattr(a, name), getattr(b, name)) < tolerance, name
    size = max(np.abs(b.nodal).max(), np.abs(b.sigma).max(initial=0.0))
    assert np.abs(a.nodal - b.nodal).max() < tolerance * size
    return b.condition


@pytest.mark.parametrize("kind", ["dense", "banded", "sparse"])
def test_50_planar_beams_with_every_class_mixed(kind: str) -> None:
    d = evaluator(*chain(50, "mixed"), kind=kind)
    y = random_state(d, 1e-3, 0.3)
    condition = compare(d, y, 1e-10)
    assert condition > 1e5  # agreement is asked for below that only
    assert d.kinematics.velocity_system.kind == kind
    assert d.saddle is not None
    assert d.saddle.system.kind == kind


def test_storages_agree() -> None:
    """The same equations in four storages: rounding only (saddle-point matrix with condition about 1e7)."""
    results = []
    for kind in ("dense", "banded", "sparse", "condensed"):
        d = evaluator(*chain(50, "mixed"), kind=kind)
        results.append(saddle_point(d, 0.3, random_state(d, 1e-3, 0.3))[0])
    for other in results[1:]:
        for name in ("xdd", "edd", "sigma", "nodal"):
            assert difference(getattr(other, name), getattr(results[0], name)) < 1e-12, name


@pytest.mark.parametrize(
    ("name", "mode"),
    [("crankfl", 1), ("fingersim", 1), ("trike2", 1), ("trike3v", 1), ("trike3i", 1), ("screw", 1), ("lateral4", 7),
     ("robotsim", 1), ("massspring", 7), ("crank", 1), ("fourbar", 1), ("lever", 9)],
)  # fmt: skip
def test_examples(name: str, mode: int) -> None:
    d = Dynamics(build(read_deck(DATA / f"{name}.dat", mode), mode))
    y = random_state(d, 1e-3, 0.1)
    condition = compare(d, y, 1e-10, t=0.0)
    assert condition < 1e5


def test_deformation_inertia() -> None:
    """MEE on dynamic, prescribed, fixed and released deformations, diagonal and coupled."""
    rows, dynamics = chain(12, "mixed")
    mee = [("MEE", 1, 2, 0.02), ("MEE", 2, 3, 0.03), ("MEE", 4, 1, 0.05), ("MEE", 3, 2, 0.01),
           ("MEE", 1, 2, 1, 3, 0.005), ("MEE", 2, 2, 2, 3, 0.004), ("MEE", 3, 2, 8, 3, 0.002), ("MEE", 5, 1, 4, 1, 0.001)]  # fmt: skip  # noqa: E501
    d = evaluator(rows, dynamics + mee)
    assert compare(d, random_state(d, 1e-3, 0.3), 1e-10) < 1e6


def test_mixed_prescribed_coordinates_and_deformations_with_accelerations() -> None:
    """A four-bar with a prescribed support point, a prescribed elongation and a free hinge."""
    rows = [
        ("PLBEAM", 1, 1, 2, 3, 4), ("PLTOR", 2, 4, 5), ("PLBEAM", 3, 3, 5, 6, 7), ("PLBEAM", 4, 6, 8, 9, 10),
        ("X", 3, 0.0, 1.0), ("X", 6, 1.5, 1.2), ("X", 9, 2.0, 0.0),
        ("FIX", 1), ("INPUTX", 9, 1, 2), ("DYNX", 2), ("INPUTE", 3, 1), ("RLSE", 2, 1),
    ]  # fmt: skip
    dynamics = [
        ("EM", 1, 1.0), ("EM", 3, 2.0), ("EM", 4, 1.5, 0.1), ("XM", 6, 3.0), ("GRAVITY", 1.0, -9.0),
        ("INPUTX", 9, 1, 2.0, 0.3, 1.1), ("INPUTX", 9, 2, 0.0, -0.2, 0.7), ("INPUTE", 3, 1, 0.0, 0.2, -0.9),
        ("STARTDX", 2, 1, 0.1, 2.0), ("ESTIFF", 2, 3.0),
    ]  # fmt: skip
    d = evaluator(rows, dynamics)
    compare(d, d.start(), 1e-12, t=0.0)
    compare(d, d.start(), 1e-12, t=0.4)


def test_forty_digits() -> None:
    """16 uneven stiff beams with a heavy tip: the saddle-point form is right to 1e-12 where the reduced one is not."""
    d = evaluator(*chain(16, "flexible", tip=50.0, uneven=0.5))
    y = random_state(d, 1e-3, 0.3)
    a, drive = saddle_point(d, 0.3, y)
    b = reduced(d, 0.3, drive)
    assert b.condition > 1e6
    exact_x, exact_sigma = exact(d, 0.3, drive)
    assert difference(a.xdd, exact_x) < 1e-12
    assert difference(a.sigma[: len(exact_sigma)], exact_sigma) < 1e-12
    assert difference(b.xdd, exact_x) > 1e-12  # the reduced form loses the condition of its mass matrix


def exact(d: Dynamics, t: float, drive: object) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations and multipliers of the same element evaluations with 40 digits, theory-system.md (9)."""
    n = d.numbering
    V, M, load, H, sigma, _ = parts(d, t)
    fixed = np.r_[np.arange(n.nx)[n.x_class["fixed"]], np.arange(n.nx)[n.x_class["input"]]]
    F = np.setdiff1d(np.arange(n.nx), fixed)
    R = np.arange(n.e_class["input"].stop)
    with mpmath.workdps(40):
        size = len(F) + len(R)
        A, b = mpmath.zeros(size, size), mpmath.zeros(size, 1)
        for i, r in enumerate(F):
            for j, c in enumerate(F):
                A[i, j] = mpmath.mpf(M[r, c])
        for i, r in enumerate(R):
            for j, c in enumerate(F):
                A[len(F) + i, j] = A[j, len(F) + i] = mpmath.mpf(V[r, c])
        xdd = np.zeros(n.nx)
        xdd[n.x_class["input"]] = drive.xdd  # type: ignore[attr-defined]
        edd = np.zeros(n.ne)
        edd[n.e_class["input"]] = drive.edd  # type: ignore[attr-defined]
        active = sigma.copy()
        active[R] = 0.0

        def product(row: np.ndarray, v: np.ndarray) -> object:
            return mpmath.fsum(mpmath.mpf(p) * mpmath.mpf(q) for p, q in zip(row, v, strict=True) if p and q)

        for i, r in enumerate(F):
            b[i] = mpmath.mpf(load[r]) - product(V[:, r], active) - product(M[r], xdd)
        for i, r in enumerate(R):
            b[len(F) + i] = mpmath.mpf(edd[r]) - mpmath.mpf(H[r]) - product(V[r], xdd)
        solution = mpmath.lu_solve(A, b)
        xdd[F] = [float(v) for v in solution[: len(F)]]
        return xdd, np.array([float(v) for v in solution[len(F) :]])


def test_nodal_forces_vanish_where_nothing_is_applied() -> None:
    """fxtot is the sum of applied, gravity and support forces: free coordinates balance exactly."""
    d = evaluator(*chain(20, "mixed"))
    f = d.frame(0.3, random_state(d, 1e-3, 0.3))
    n = d.numbering
    free = np.setdiff1d(
        np.arange(n.nx), np.r_[np.arange(n.nx)[n.x_class["fixed"]], np.arange(n.nx)[n.x_class["input"]]]
    )
    out_of_balance = (f.fxtot - f.fx - f.fxgrav)[free]
    assert np.abs(out_of_balance).max() < 1e-11 * np.abs(f.fxtot).max()
