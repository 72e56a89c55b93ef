"""Unknowns inside elements as rows of their own in the buckling problem (theory-beam-order4.md section 2.6).

An element may have an unknown a that its deformations do not show (the twist gradient of beams in the angle measure),
with the strain energy k a^2/2 + a c.dx, c proportional to the stresses. It is eliminated in the tangent of a state,
-c c^T/k, as a part of G0; that is quadratic in the load, while load multipliers need terms that are linear in it:

    [ K0  0 ]          [ G0 + sum c c^T/k   c ]
    [ 0   k ] + lambda [ c^T                0 ],        sum c c^T/k only where the element has eliminated a

For lambda = 1 the elimination of a gives the tangent K0 + G0 again (where a is eliminated). For one extra load with the
stresses s1 beside the present ones, c = c0 + lambda c1:

    [ K + sum c0 c0^T/k   c0 ]          [ G1 + sum c1 c1^T/k   c1 ]
    [ c0^T                k  ] + lambda [ c1^T                 0  ],       sums as above, G1 the stiffness of s1 alone
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.elements.family import Family
from spacar.linearization.coefficients import geometric_rounding
from spacar.linearization.matrices import Linearization, selected


class ElementUnknowns(NamedTuple):
    """Unknowns of one batch: rows (n, m) of the coordinates of the m elements that have one, coupling (n, m), stiffness
    (m,), eliminated (m,)."""

    rows: Index
    coupling: Array
    stiffness: Array
    eliminated: NDArray[np.bool_]


def element_unknowns(dynamics: Dynamics, sigma: Array, other: Array | None = None) -> list[ElementUnknowns]:
    """Unknowns of all batches that have any, at the stresses sigma (ne,), also of elements in which only the stresses
    `other` (ne,) couple them."""
    found = []
    for b in dynamics.mechanism.layout.curved:
        family: Family = getattr(b.family, "general", b.family)
        if type(family).internal is Family.internal:
            continue  # no elements need to be evaluated to say so
        configuration = dynamics.sweep.configuration[b.index]
        internal = b.family.internal(configuration, sigma[b.e])
        if internal is None:
            continue
        coupled = internal.coupling.any(0)
        if other is not None:
            inner = b.family.internal(configuration, other[b.e])
            coupled = coupled | (inner is not None and inner.coupling.any(0))
        has = np.flatnonzero(np.isfinite(internal.stiffness) & coupled)
        found.append(
            ElementUnknowns(b.x[:, has], internal.coupling[:, has], internal.stiffness[has], internal.eliminated[has])
        )
    return found


def _joined(unknowns: list[ElementUnknowns], nx: int) -> tuple[Array, Array, Array]:
    """Couplings (nx, m), stiffnesses, which are eliminated (m,) of several batches."""
    parts: list[tuple[Array, Array, Array]] = [(np.zeros((nx, 0)), np.zeros(0), np.zeros(0, bool))]
    for u in unknowns:
        coupling = np.zeros((nx, len(u.stiffness)))
        np.add.at(coupling, (u.rows, np.arange(len(u.stiffness))), u.coupling)
        parts.append((coupling, u.stiffness, u.eliminated))
    couplings, stiffnesses, eliminated = zip(*parts, strict=True)
    return np.concatenate(couplings, axis=1), np.concatenate(stiffnesses), np.concatenate(eliminated)


def buckling_matrices(dynamics: Dynamics, L: Linearization, dynamic: Index) -> tuple[Array, Array]:
    """K0 and G0 of the dynamic degrees of freedom, then of the unknowns inside elements. A G0 of rounding is zero."""
    W, K0, G0 = L.W[:, dynamic], *(selected(A, dynamic, dynamic) for A in (L.k0, L.g0))
    unknowns = element_unknowns(dynamics, L.c.sigma)
    if (np.abs(G0) <= geometric_rounding(dynamics.sweep, L.c.sigma, dynamics.mechanism.scale, W)).all():
        G0 = np.zeros_like(G0)
    coupling, k, eliminated = _joined(unknowns, len(W))
    c, part = W.T @ coupling, eliminated / k
    return _bordered(K0, np.zeros_like(c), part, k), _bordered(G0, c, part, np.zeros(len(k)))


def extra_load_matrices(
    dynamics: Dynamics, L: Linearization, rows: Index, K: Array, G1: Array, s1: Array
) -> tuple[Array, Array]:
    """K of the present state and G1 of the extra stresses s1 (ne,), both (n, n) over the degrees of freedom `rows`,
    with the unknowns inside elements."""
    pairs, nx = ((L.c.sigma, s1), (s1, L.c.sigma)), dynamics.numbering.nx
    (c0, k, eliminated), (c1, _, _) = (_joined(element_unknowns(dynamics, *pair), nx) for pair in pairs)
    W, part = L.W[:, rows].T, eliminated / k
    return _bordered(K, W @ c0, part, k), _bordered(G1, W @ c1, part, np.zeros(len(k)))


def _bordered(A: Array, c: Array, part: Array, diagonal: Array) -> Array:
    """[A + c part c^T, c; c^T, diagonal], A itself without such unknowns."""
    if not len(diagonal):
        return A
    return np.block([[A + (c * part) @ c.T, c], [c.T, np.diag(diagonal)]])
