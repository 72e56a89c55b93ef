"""Frequencies against closed forms: beams, rotating beams, rotors, rigid motions, repeated values; large systems."""

import numpy as np
import pytest
from cantilever_eigen import ROOTS, cantilever
from scipy.linalg import eigh

import spacar
from spacar.errors import Report
from spacar.linear import form
from spacar.linear.eigen import damped_modes, undamped_modes


def frequencies(text: str, mode: int = 7) -> np.ndarray:
    """|lambda| of the pairs, ascending."""
    values = spacar.run(mode, spacar.parse_deck(text, mode=mode))["eigval"][-1]
    return np.sort(np.hypot(*values.T))[::2]


def orders(errors: list[float]) -> np.ndarray:
    return np.log2(np.array(errors[:-1]) / errors[1:])


def test_cantilever_has_fourth_order_without_rounding():
    """Up to 64 elements (omega^2 spans 9 decades) the error follows n^-4, so rounding is below 1e-10."""
    errors = [abs(frequencies(cantilever(n))[0] / ROOTS[0] ** 2 - 1) for n in (8, 16, 32, 64)]
    assert np.all(np.abs(orders(errors) - 4.0) < 0.05), errors


def test_damped_cantilever():
    """Kelvin-Voigt EdI = c: lambda^2 + c w^2 lambda + w^2 = 0 for every mode; the overdamped ones too."""
    c, n = 1e-3, 20
    damper = "\n".join(f"EDAMP {k} 0. {c!r}" for k in range(1, n + 1))
    values = spacar.run(7, spacar.parse_deck(cantilever(n, more=damper), mode=7))["eigval"][0] @ [1, 1j]
    w = frequencies(cantilever(n))
    roots = np.array([np.roots([1, c * a * a, a * a]) for a in w]).ravel()
    for root in roots:
        # pairs close to the critical damping are ill-conditioned: half of the digits
        assert np.min(np.abs(values - root)) <= 1e-6 * abs(root)
    lowest = np.roots([1, c * w[0] ** 2, w[0] ** 2])[0]
    assert np.min(np.abs(values - lowest)) <= 1e-10 * abs(lowest)


def rotating_beam(speed: float, count: int = 9) -> np.ndarray:
    """Flap frequencies of a uniform beam that rotates about its clamped end, l = EI = m = 1: Rayleigh-Ritz.

    int w''^2 + Omega^2/2 int (1 - x^2) w'^2 = omega^2 int w^2 with x^2 P_k(2x - 1), converged to 10 digits.
    """
    from numpy.polynomial import Legendre, Polynomial

    x2 = Polynomial([0, 0, 1])
    basis = [x2 * Legendre.basis(k, domain=[0, 1]).convert(kind=Polynomial) for k in range(count)]

    def inner(u: Polynomial, v: Polynomial, weight: Polynomial | float = 1.0) -> float:
        p = (u * v * weight).integ()
        return float(p(1.0) - p(0.0))

    tension = 0.5 * speed**2 * Polynomial([1, 0, -1])
    K = [[inner(u.deriv(2), v.deriv(2)) + inner(u.deriv(), v.deriv(), tension) for v in basis] for u in basis]
    M = [[inner(u, v) for v in basis] for u in basis]
    return np.sqrt(eigh(K, M, eigvals_only=True))


def test_the_series_reproduces_published_flap_frequencies():
    """Wright, Smith, Thresher, Wang, J. Appl. Mech. 49 (1982): 3.6817 at 1, 6.4495 at 5, 11.2023 at 10."""
    for speed, printed in ((1.0, 3.6817), (5.0, 6.4495), (10.0, 11.2023)):
        assert rotating_beam(speed)[0] == pytest.approx(printed, abs=6e-5)


@pytest.mark.parametrize("speed", [2.0, 5.0])
def test_lead_lag_of_a_rotating_beam(speed):
    """omega^2 = omega_flap^2 - Omega^2 in the plane of rotation."""
    exact = np.sqrt(rotating_beam(speed)[0] ** 2 - speed**2)
    errors = []
    for n in (4, 8, 16):
        text = cantilever(n, "FIX 1\nINPUTX 2 1", f"INPUTX 2 1 0. {speed!r}")
        errors.append(abs(frequencies(text)[0] / exact - 1))
    assert errors[-1] < 1e-3
    assert np.all(orders(errors) > 1.8), (errors, orders(errors))


def flap(n: int, speed: float) -> str:
    """A chain of spatial beams on a hinge about z that turns with constant speed; out-of-plane bending only."""
    lines = [f"BEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2} 0. 1. 0." for k in range(1, n + 1)]
    lines += [f"HINGE {n + 1} {2 * n + 3} 2 0. 0. 1.", f"FIX {2 * n + 3}", "FIX 1", f"INPUTE {n + 1} 1"]
    lines += [f"X {2 * k + 1} {k / n!r} 0. 0." for k in range(1, n + 1)]
    lines += [*(f"DYNE {k} 3 4" for k in range(1, n + 1)), "END", "HALT"]
    lines += [f"EM {k} 1." for k in range(1, n + 1)] + [f"ESTIFF {k} 0. 1. 1. 1." for k in range(1, n + 1)]
    return "\n".join([*lines, f"INPUTE {n + 1} 1 0. {speed!r}", "END", "END", ""])


def test_flap_of_a_rotating_beam():
    exact = rotating_beam(5.0)[0]
    errors = [abs(frequencies(flap(n, 5.0))[0] / exact - 1) for n in (4, 8, 16)]
    assert errors[-1] < 1e-3
    assert np.all(orders(errors) > 1.8), (errors, orders(errors))


DISC, DIAMETRAL, SPIN = 0.7, 0.05, 0.1  # mass, diametral inertia, inertia of the spinning rotor


def overhung(n: int, speed: float, mass: float) -> str:
    """Shaft along x, clamped, with a rotor at the end, l = EI = 1."""
    lines = [f"BEAM {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2} 0. 1. 0." for k in range(1, n + 1)]
    lines += ["FIX 1", "FIX 2", *(f"X {2 * k + 1} {k / n!r} 0. 0." for k in range(1, n + 1))]
    lines += [*(f"DYNE {k} 3 4 5 6" for k in range(1, n + 1)), "END", "HALT"]
    lines += [f"EM {k} {mass!r}" for k in range(1, n + 1)] if mass else []
    lines += [f"ESTIFF {k} 0. 1. 1. 1." for k in range(1, n + 1)]
    tip, rotation = 2 * n + 1, 2 * n + 2
    lines += [f"XM {tip} {DISC}", f"XM {rotation} {DIAMETRAL} 0. 0. {DIAMETRAL} 0. {DIAMETRAL}"]
    return "\n".join([*lines, f"XGYRO {rotation} {speed!r} 0. 0. {SPIN}", "END", "END", ""])


def test_whirl_of_an_overhung_rotor_on_a_massless_shaft():
    """(12 - M w^2)(4 - Id w^2 + Ip Omega w) = 36, forward w > 0 and backward w < 0: one beam is exact."""
    for speed in (0.0, 10.0, 40.0):
        p = np.polymul([-DISC, 0, 12], [-DIAMETRAL, SPIN * speed, 4]) - np.array([0, 0, 0, 0, 36])
        truth = np.sort(np.abs(np.roots(p).real))
        assert np.allclose(frequencies(overhung(1, speed, 0.0)), truth, rtol=1e-9)


def test_whirl_of_an_overhung_rotor_with_a_heavy_shaft():
    """EI w'''' = m w^2 w with the rotor in the boundary conditions at the tip; order 4."""
    from scipy.optimize import brentq

    speed = 20.0

    def determinant(w: float) -> float:
        b = np.sqrt(abs(w))
        ch, sh, c, s = np.cosh(b), np.sinh(b), np.cos(b), np.sin(b)
        turn = DIAMETRAL * w * w - SPIN * speed * w
        shear = [b**3 * (sh - s) + DISC * w * w * (ch - c), b**3 * (ch + c) + DISC * w * w * (sh - s)]
        moment = [b**2 * (ch + c) - turn * b * (sh + s), b**2 * (sh + s) - turn * b * (ch - c)]
        return shear[0] * moment[1] - shear[1] * moment[0]

    def roots(sign: float) -> list[float]:
        grid = np.linspace(0.05, 12.0, 400) * sign
        values = [determinant(w) for w in grid]
        pairs = zip(grid, grid[1:], values, values[1:], strict=False)
        return [abs(brentq(determinant, a, b, xtol=1e-13)) for a, b, u, v in pairs if u * v < 0]

    forward, backward = roots(1.0)[0], roots(-1.0)[0]
    for exact in (backward, forward):
        errors = [min(abs(frequencies(overhung(n, speed, 1.0)) / exact - 1)) for n in (2, 4, 8)]
        assert np.all(np.abs(orders(errors) - 4.0) < 0.3), (errors, orders(errors))


def test_repeated_frequencies_keep_independent_vectors():
    """A round shaft: every bending frequency twice, with a full set of state vectors."""
    frame = spacar.run(7, spacar.parse_deck(overhung(3, 0.0, 1.0), mode=7)).frames[0]
    w = np.hypot(*frame.matrices["eigval"].T)
    assert np.allclose(w[0::4], w[2::4], rtol=1e-12)
    vectors = frame.matrices["eigvre"] + 1j * frame.matrices["eigvim"]
    assert np.linalg.matrix_rank(vectors, tol=1e-6) == len(w)


def test_free_beam_and_unstable_equilibrium():
    """Three rigid motions, then the free-free frequencies; a negative stiffness has a real pair."""
    w = frequencies(cantilever(16, "DYNX 1\nDYNX 2"))
    assert np.all(w[:3] < 1e-5)
    assert np.allclose(w[3:5], np.array([4.730040744862704, 7.853204624095838]) ** 2, rtol=1e-4)
    modes = undamped_modes(np.diag([4.0, -9.0]), np.eye(2), Report())
    assert np.allclose(np.sort_complex(modes.values), np.sort_complex([2j, -2j, 3, -3]))


def test_gyroscopic_and_damped_systems_in_modal_coordinates():
    """Against the plain state matrix of a well conditioned random system."""
    rng = np.random.default_rng(0)
    A, B, C = rng.normal(size=(3, 6, 6))
    M, K = A @ A.T + 6 * np.eye(6), B @ B.T
    modes = damped_modes(K, C, M, Report())
    state = np.block([[np.zeros((6, 6)), np.eye(6)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    assert np.allclose(np.sort_complex(modes.values), np.sort_complex(np.linalg.eigvals(state)), rtol=1e-9)
    assert np.max(np.abs(state @ modes.vectors - modes.vectors * modes.values)) < 1e-11
    assert np.allclose(np.linalg.norm(modes.vectors, axis=0), 1.0)


LOADED = "XF 61 -1. 0.3\nGRAVITY 0. -0.5\nITERSTEP 20 4 1e-11"


def test_half_a_pair_keeps_its_place():
    """A root that creeps has one real eigenvalue, so that eight of them end with half a pair: nan, as all steps of a
    file have the same number. The dense matrices give the others."""
    text = cantilever(110, more="EDAMP 1 0. 100.").replace("DYNE 1 2 3", "DYNE 1 3")
    deck = spacar.parse_deck(text, mode=7)
    found, exact = (spacar.run(7, deck, modes=k)["eigval"][0] @ [1, 1j] for k in (4, 0))
    known = found[np.isfinite(found)]
    assert (len(found), len(known)) == (8, 7)
    np.testing.assert_allclose(np.sort(np.abs(known)), np.sort(np.abs(exact))[:7], rtol=1e-8)


@pytest.mark.parametrize("case", ["planar", "damped", "spatial", "free"])
def test_lowest_modes_of_large_systems(case, monkeypatch):
    """The sparse path finds the same modes as the dense one, double ones and rigid motions included."""
    damper = "\n".join(f"EDAMP {k} 0. 1e-4" for k in range(1, 31))
    text = {
        "planar": cantilever(30, more=LOADED),
        "damped": cantilever(30, more=f"{LOADED}\n{damper}"),
        "spatial": overhung(12, 0.0, 1.0).replace("XGYRO 26 0.0 0. 0. 0.1\n", ""),
        "free": cantilever(30, "DYNX 1\nDYNX 2"),
    }[case]
    deck = spacar.parse_deck(text, mode=7)
    dense = spacar.run(7, deck)
    monkeypatch.setattr(form, "LARGE", 10)
    sparse = spacar.run(7, deck)
    assert any("only the 20 lowest modes" in line for line in sparse.report)
    truth, found = (r["eigval"][0] @ [1, 1j] for r in (dense, sparse))
    truth = truth[len(truth) - len(found) :]
    size = np.abs(truth)
    rigid = size < 1e-4
    # both solvers leave 1e-9 relative; zero eigenvalues are sqrt(eps)
    assert np.all(np.abs(np.abs(found) - size)[~rigid] <= 1e-7 * size[~rigid])
    assert np.all(np.abs(found[rigid]) < 1e-3)
    assert sparse["eigvre"].shape[1:] == (2 * dense.mechanism.numbering.nddof, len(found))
