"""Length l and direction angle beta of the chord p-q: what all planar two-node elements share.

Source: theory-planar.md section 1, (1), (2); with z = d_x + i d_y they are the real and the imaginary part of
ln z = ln l + i beta and its derivatives. With d = x_q - x_p, l = |d|, u = d/l, nu = u turned by +90 degrees and
w = v_q - v_p:

    l' = u.w                               beta' = nu.w/l
    D^2 l = nu nu^T/l                      D^2 beta = -(u nu^T + nu u^T)/l^2
    H_l(v,v) = l beta'^2                   H_beta(v,v) = -2 l' beta'/l
    H1_l = beta' nu                        H1_beta = -(l' nu/l + beta' u)/l
    T_l = -(2 l' beta'/l) nu - beta'^2 u   T_beta = 2 [((l'/l)^2 - beta'^2) nu + (2 l' beta'/l) u]/l

A vector g (2, n) stands for the row (-g at x_p, g at x_q): the position of the chord does not matter.
"""

from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import GeometryError, Trouble

SHORT = 1e-6  # a chosen bound, of the start length: below this the direction of the chord is lost


def normal(u: Array) -> Array:
    """u (2, n) turned by +90 degrees."""
    return np.array((-u[1], u[0]))


def row(g: Array) -> Array:
    """The row (6, n) of the vector g (2, n) for the coordinates x_p, phi_p, x_q, phi_q."""
    out = np.zeros((6, *g.shape[1:]), g.dtype)
    out[0:2] = -g
    out[3:5] = g
    return out


def start_chord(x_p: Array, x_q: Array, keyword: str) -> tuple[Array, Array]:
    """Start length l0 (n,) and direction u0 (2, n); GeometryError where the nodes coincide.

    "Coincide" is measured against the largest position in the group, whose digits limit the difference.
    """
    d = x_q - x_p
    l0 = distance(d)
    shortest = 1e-12 * max(np.abs(x_p).max(), np.abs(x_q).max())
    if not l0.real.min() > shortest:
        k = int((l0.real <= shortest).argmax())
        raise GeometryError(
            k,
            f"{keyword} has length {l0[k]:.3g} m: both end nodes are at ({x_p[0, k]:.9g}, {x_p[1, k]:.9g}); "
            "give them different positions with X",
        )
    return l0, d / l0


def distance(d: Array) -> Array:
    """|d| (n,) of d (2, n), of complex steps its analytic continuation."""
    return np.asarray(np.sqrt(d[0] * d[0] + d[1] * d[1]) if np.iscomplexobj(d) else np.hypot(d[0], d[1]))


def frame(t: Array) -> Array:
    """(n, 9): rows x', y', z' of the planar frame with x' along t (2, n)."""
    rows = np.zeros((t.shape[1], 9), t.dtype)
    rows[:, 0:2], rows[:, 3:5], rows[:, 8] = t.T, normal(t).T, 1.0
    return rows


def short_troubles(l: Array, l0: Array) -> list[Trouble]:
    """Elements whose end nodes have met."""
    return [
        Trouble(
            int(k),
            f"has collapsed: its length {l[k]:.3g} m is less than {SHORT:g} of the undeformed {l0[k]:.6g} m: "
            "its direction is lost",
            True,
        )
        for k in np.flatnonzero(~(l > SHORT * l0))
    ]


def constant_mass_force(M: Array, v: Array, a: Array | None) -> Any:
    """M a (n_coordinates, n) of a mass matrix that does not depend on x; h = 0."""
    return np.zeros_like(v) if a is None else (M * a).sum(1)
