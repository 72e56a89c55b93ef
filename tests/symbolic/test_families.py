"""Frequencies of one beam by the families of shapes, against roots of the closed frequency equations.

Bending of a uniform beam, ω = k² √(EI/ρ)/L²: free-free and clamped-clamped cos k cosh k = 1; clamped with a guided end
tan k + tanh k = 0; hinged at both ends k = nπ. Ritz frequencies lie above the exact ones and converge to them.
"""

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

pytest.importorskip("sympy")

from spacar.symbolic import MultibodySystem, beam_shapes

UNIT = {"L": 1.0, "rho": 1.0, "EI": 1.0}


def free_root(n: int) -> float:
    at = (n + 0.5) * np.pi
    return float(brentq(lambda k: np.cos(k) - 1 / np.cosh(k), at - 0.5, at + 0.5, xtol=1e-14))


def guided_root(n: int) -> float:
    at = (n - 0.25) * np.pi
    return float(brentq(lambda k: np.tan(k) + np.tanh(k), at - 0.5, at + 0.5, xtol=1e-14))


EXACT = {
    "pinned": [(n * np.pi) ** 2 for n in (1, 2)],
    "guided": [guided_root(n) ** 2 for n in (1, 2)],
    "free": [free_root(n) ** 2 for n in (1, 2)],
}
ERROR = {3: 1e-2, 5: 1e-5}  # of the first: Ritz with two and three even shapes; far above rounding
ESSENTIAL = {"pinned": ((0, 0), (0, 1)), "guided": ((0, 0), (1, 0), (1, 1)), "free": ()}  # (derivative, place)


def ritz(family: str, number: int) -> np.ndarray:
    """Frequencies in the space of polynomials that a family spans, by numbers: Legendre basis, null space, Gauss."""
    at, weight = legendre.leggauss(number + 4)
    n = number + {"pinned": 2, "guided": 3, "free": 2}[family]
    basis = [legendre.Legendre.basis(k, domain=(0, 1)) for k in range(n)]
    rows = [[p.deriv(d)(x) if d else p(x) for p in basis] for d, x in ESSENTIAL[family]]
    if family == "free":
        rows = list(np.eye(n)[:2])  # orthogonal to 1 and x
    T = null_space(np.array(rows))
    x, w = (at + 1) / 2, weight / 2
    P, Q = (np.array([p.deriv(d)(x) if d else p(x) for p in basis]) for d in (0, 2))
    K, M = (T.T @ (A * w @ A.T) @ T for A in (Q, P))
    return np.sqrt(eigh(K, M, eigvals_only=True))


@pytest.mark.parametrize(("number", "family", "strategy"), [
    pytest.param(number, family, strategy, marks=[pytest.mark.slow] * (number == 5 and strategy == "held"))
    for number in (3, 5) for family in ("pinned", "guided", "free") for strategy in ("held", "recursive")
])  # fmt: skip
def test_frequencies_of_a_family(family, strategy, number):
    S = MultibodySystem()
    L, rho, EI = S.parameters("L rho EI")
    S.beam("beam", S.N, S.O, L, rho, EI=EI, field=getattr(beam_shapes, family)(number), foreshortening=False)
    w = np.sort(np.abs(S.derive(strategy).linearize(UNIT).eigenvalues().imag))[::2]
    # rounding of stiffnesses moves the lowest by eps (highest / lowest)²; both sides, and a factor for n terms
    rounding = 10 * number * np.finfo(float).eps * (w[-1] / w[0]) ** 2
    assert w == pytest.approx(ritz(family, number), rel=rounding)
    excess = w[:2] / EXACT[family] - 1
    assert np.all(excess > -rounding)  # Ritz: from above
    assert excess[0] < ERROR[number]
