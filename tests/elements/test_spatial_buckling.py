"""Models of several beams put together by hand: lateral buckling, the large bend by an end moment.

They see what no derivative check can: the second order terms against printed loads.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from derivatives import evaluate, group, written

from spacar.elements.spatial.beam import SpatialBeam

GIT, EIZ = 2.0, 1.0


def cantilever(n: int, git: Any, nonlinear: bool = True) -> tuple[SpatialBeam, Any, Any]:
    """n beams along x from 0 to 1, y' = y; gather indices (14, n) into nodal blocks of 7 coordinates."""
    x0 = np.zeros((14, n))
    x0[[3, 10]] = 1.0
    x0[0], x0[7] = np.arange(n) / n, np.arange(1, n + 1) / n
    estiff = np.column_stack((np.zeros(n), np.broadcast_to(git, n), np.zeros(n), np.full(n, EIZ)))
    kwargs = {"geometry": [(0.0, 1, 0)] * n, "estiff": estiff, "nonlinear": np.full(n, nonlinear)}
    index = 7 * np.arange(n) + np.arange(14)[:, None]
    return SpatialBeam(group("BEAM", x0, **kwargs)), x0, index


def lateral_load(n: int, git: Any, nonlinear: bool = True) -> float:
    """Smallest positive tip force in z at which the cantilever with rigid e1, e3, e4 buckles sideways."""
    beams, x0, index = cantilever(n, git, nonlinear)
    c, _, V = evaluate(beams, x0)
    size = 7 * (n + 1)
    rows = np.zeros((6 * n, size))
    for k in range(n):
        rows[6 * k : 6 * k + 6, index[:, k]] = V[:, :, k]
    norm = np.zeros((n, size))
    norm[np.arange(n), 7 * np.arange(1, n + 1) + 3] = 2.0
    free = np.arange(7, size)
    modes = np.arange(6 * n).reshape(n, 6)
    rigid, flexible = modes[:, [0, 2, 3]].ravel(), modes[:, [1, 4, 5]].ravel()
    bound = np.vstack((rows[rigid], norm))[:, free]
    force = np.zeros(size)
    force[7 * n + 2] = 1.0
    reaction, residual = np.linalg.lstsq(bound.T, force[free], rcond=None)[:2]
    assert residual.size == 0 or residual < 1e-20  # the load is carried without bending sideways
    sigma = np.zeros((n, 6))
    sigma.ravel()[rigid] = reaction[: len(rigid)]
    G_local = written(beams.geometric_stiffness, (14, 14, n), float, c, sigma.T.copy())
    S = beams.stiffness()[0]
    G, K = np.zeros((size, size)), np.zeros((size, size))
    for k in range(n):
        at = np.ix_(index[:, k], index[:, k])
        G[at] += G_local[:, :, k]
        K[at] += V[:, :, k].T @ S[:, :, k] @ V[:, :, k]
    for k in range(n):
        lam = slice(7 * k + 10, 7 * k + 14)
        G[lam, lam] += 2.0 * reaction[len(rigid) + k] * np.eye(4)
    null = np.linalg.svd(bound)[2][len(bound) :].T
    assert null.shape[1] == len(flexible)
    K, G = (null.T @ A[np.ix_(free, free)] @ null for A in (K, G))
    inverse = np.linalg.eigvals(np.linalg.solve(K, -G)).real
    return float(1.0 / inverse.max())


@pytest.mark.parametrize(
    ("n", "load"), [(2, 6.06701), (4, 5.76187), (8, 5.69659), (16, 5.68017), (32, 5.67605)]
)
def test_lateral_buckling(n: int, load: float) -> None:
    """Manual (n = 4): 5.7619; theory-spatial.md section 14, six digits; the exact load is 5.6747."""
    assert lateral_load(n, GIT) == pytest.approx(load, abs=6e-6)


def test_lateral_buckling_of_a_stiffened_beam() -> None:
    """Manual: 6.1694 with GIt = 2.39034 in the first of four elements."""
    assert lateral_load(4, [2.39034, 2, 2, 2]) == pytest.approx(6.1694, abs=6e-5)


def test_lateral_buckling_without_second_order_terms() -> None:
    """LDEFORM: 5.93576, the value of theory-spatial.md without the bending-torsion terms."""
    assert lateral_load(4, GIT, nonlinear=False) == pytest.approx(5.93576, abs=6e-6)


def test_pure_bending_obeys_the_sine_law() -> None:
    """One element bent to a circle arc by theta: M l0/EI = sin theta, no force at the end."""
    beams, x0, _ = cantilever(1, GIT, nonlinear=False)
    theta = 0.6
    x = x0.copy()
    x[7:10, 0] = np.cos(theta / 2), np.sin(theta / 2), 0.0  # chord of length l0 at half the angle
    x[[10, 13], 0] = np.cos(theta / 2), np.sin(theta / 2)
    _, e, V = evaluate(beams, x)
    sigma = beams.stiffness()[0][:, :, 0] @ e[:, 0]
    np.testing.assert_allclose(e[:, 0], [0, 0, 0, 0, np.sin(theta / 2), np.sin(theta / 2)], atol=1e-15)
    dual = V[:, 10:, 0].T @ sigma
    turning = np.array([-np.sin(theta / 2), 0, 0, np.cos(theta / 2)])  # 2 dlambda/dtheta
    assert 0.5 * dual @ turning == pytest.approx(EIZ * np.sin(theta), rel=1e-14)
    np.testing.assert_allclose(V[:, 7:10, 0].T @ sigma, 0.0, atol=1e-14)
