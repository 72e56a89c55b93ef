"""Unknowns inside elements as rows of their own in the buckling problem (theory-beam-order4.md section 2.6).

An element may have an unknown a that its deformations do not show (the twist gradient of beams in the angle measure),
with the strain energy k a^2/2 + a c.dx, c proportional to the stresses. It is eliminated in the tangent of a state,
-c c^T/k, as a part of G0; that is quadratic in the load, while load multipliers need terms that are linear in it:

    [ K0  0 ]          [ G0 + sum c c^T/k   c ]
    [ 0   k ] + lambda [ c^T                0 ],        sum c c^T/k only where the element has eliminated a

For lambda = 1 the elimination of a gives the tangent K0 + G0 again (where a is eliminated).
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.linearization.matrices import Linearization


def internal_unknowns(dynamics: Dynamics, sigma: Array) -> tuple[Array, Array, Array]:
    """Couplings (nx, m), stiffnesses (m,) and which are eliminated (m,), of all elements that have such an unknown."""
    sweep = dynamics.sweep
    found: list[tuple[Array, Array, Array]] = [(np.zeros((sweep.nx, 0)), np.zeros(0), np.zeros(0, bool))]
    for b in sweep.curved:
        internal = b.family.internal(sweep.configuration[b.index], sigma[b.e])
        if internal is None:
            continue
        has = np.flatnonzero(np.isfinite(internal.stiffness) & internal.coupling.any(0))
        coupling = np.zeros((sweep.nx, len(has)))
        np.add.at(coupling, (b.x[:, has], np.arange(len(has))), internal.coupling[:, has])
        found.append((coupling, internal.stiffness[has], internal.eliminated[has]))
    couplings, stiffnesses, eliminated = zip(*found, strict=True)
    return np.concatenate(couplings, axis=1), np.concatenate(stiffnesses), np.concatenate(eliminated)


def buckling_matrices(dynamics: Dynamics, L: Linearization, dynamic: Index) -> tuple[Array, Array]:
    """K0 and G0 of the dynamic degrees of freedom, then of the unknowns inside elements."""
    block = np.ix_(dynamic, dynamic)
    coupling, k, eliminated = internal_unknowns(dynamics, L.sigma)
    c = L.W[:, dynamic].T @ coupling
    n, m = c.shape
    G0 = np.zeros((n + m, n + m))
    G0[:n, :n] = L.g0[block] + (c * (eliminated / k)) @ c.T
    G0[:n, n:], G0[n:, :n] = c, c.T
    return np.block([[L.k0[block], np.zeros((n, m))], [np.zeros((m, n)), np.diag(k)]]), G0
