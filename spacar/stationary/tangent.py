"""The static tangent without dense matrices (theory-system.md 6.2), in mixed form.

    [ K_g  V^T ] [ dx_F  ]   [ (f - h - V_A^T sigma_A)_F ]
    [ V    -C  ] [ sigma ] = [ 0                          ],     K_g = Hs(sigma) + d(h - f)/dx

F: coordinates that are not prescribed. C is the flexibility of the elements: zero for fixed and input deformations
(then sigma is a multiplier as in (18)), the inverse of the element stiffness S for the elastic ones; deformations
without stiffness have sigma = 0. The elimination of sigma gives K_x = V_A^T S V_A + K_g of (18), whose rounding
errors grow with the fourth power of the number of beams in a chain; here they grow with the second.

All blocks are element-local; the pattern, its ordering and S are made once per model, an iteration only fills values.
The same parts, weighted, are the pencils of vibration (K_x + s^2 M + s C_d) and of buckling (K_x without K_g).
Only for systems at rest, holonomic, without user functions and MEE.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import moment_gradient
from spacar.linear_systems import LinearSystem, assemble
from spacar.linear_systems.linear_system import compressed, compressed_sum
from spacar.linear_systems.reciprocal_condition import entry_rounding
from spacar.linearization.coefficients import geometric_blocks
from spacar.mechanism.mechanism import Batch
from spacar.stationary.flexibility import Flexibility, squares
from spacar.stationary.loading import is_tube
from spacar.stationary.stationary_equations import require_digits

NONE = np.zeros(0)
STATIC = {"geometric": 1.0, "load": 1.0, "moment": 1.0}


@dataclass(frozen=True)
class TangentTerm:
    """Entries of one term of the matrix, restricted to F, and how to get their values.

    place (nx,)  where coordinates are among F;  pattern, every  rows and columns, and values, of all entries
    """

    place: Index
    pattern: Callable[[], tuple[Index, Index]]
    every: Callable[[], Array]

    @cached_property
    def _restricted(self) -> tuple[Any, Any, Any, bool]:
        place = self.place.astype(np.int32)  # there are many
        a, b = (place[part] for part in self.pattern())
        keep = np.flatnonzero((a >= 0) & (b >= 0))
        return keep.astype(np.int32), a[keep], b[keep], len(keep) == len(a)

    @property
    def rows(self) -> Index:
        return self._restricted[1]

    @property
    def columns(self) -> Index:
        return self._restricted[2]

    def values(self) -> Array:
        """Values at the present configuration, in the order of rows and columns."""
        keep, _, _, whole = self._restricted
        if not len(keep):
            return np.zeros(0)
        return self.every() if whole else self.every().take(keep)


class SparseTangent:
    """The parts of the tangent of one Dynamics, and the system that factors weighted sums of them.

    `free` (nf,): the coordinates F, if not those that are calculable or dynamic.
    """

    def __init__(self, dynamics: Dynamics, flexibility: Flexibility, free: Index | None = None) -> None:
        self.dynamics = dynamics
        n, sweep = dynamics.numbering, dynamics.sweep
        moving = [np.arange(n.x_class[c].start, n.x_class[c].stop) for c in ("calculable", "dynamic")]
        self.F = np.concatenate(moving) if free is None else free
        self.nf = len(self.F)
        self.place = np.full(n.nx, -1)
        self.place[self.F] = np.arange(self.nf)
        self.sigma = np.zeros(n.ne)
        self.flexibility = flexibility
        self.elastic, self.active = self.flexibility.elastic, self.flexibility.active
        m = dynamics.mechanism
        # Gravity may come with the additional loading only.
        heavy = any(loads is not None and loads.gravity.any() for loads in (m.loads, m.additional, dynamics.loads))
        loaded = [b for b in sweep.moving if heavy or is_tube(b)]
        # rows of lambda with moments, those of the additional loading behind the others, (4, n)
        moment_rows = np.concatenate([p.moment_rows for p in (m.loads, m.additional) if p is not None], axis=1)
        self.parts = {
            "geometric": TangentTerm(self.place, lambda: squares([b.x for b in sweep.curved]), self._geometric),
            "load": TangentTerm(self.place, lambda: squares([b.x for b in loaded]), lambda: self._inertia(loaded, 0)),
            "moment": TangentTerm(
                self.place, lambda: squares([moment_rows]), lambda: self._moments(moment_rows.shape[1])
            ),
            "mass": TangentTerm(self.place, lambda: (sweep.m_rows, sweep.m_columns), lambda: sweep.m_entries),
            "flow": TangentTerm(self.place, lambda: squares([b.x for b in loaded]), lambda: self._inertia(loaded, 1)),
        }
        self.ne = n.ne
        self.last_step = False  # no Newton's iteration follows: one system has factors at a time
        self._patterns: dict[tuple[str, ...], tuple[Any, Any]] = {}
        self._systems: dict[tuple[str, ...], LinearSystem] = {}
        # What does not depend on the configuration: factors of the entries of V, the entries of -C, the size.
        self._constant: dict[tuple[float, float], tuple[Array, Array, float]] = {}

    @cached_property
    def _v(self) -> Index:
        """Which entries of V are in columns of F."""
        return np.flatnonzero(self.place[self.dynamics.sweep.v_columns] >= 0)

    @property
    def damped(self) -> bool:
        """Does any active deformation or the flow in a tube give forces proportional to rates?"""
        viscous = any((b.family.stiffness()[1] * self.active[b.index]).any() for b in self.elastic)
        return viscous or bool(self.parts["flow"].values().any())

    def factor(self, weights: dict[str, float], stiffness: float = 1.0, damping: float = 0.0) -> LinearSystem:
        """Factored matrix of the weighted parts and of the element matrices stiffness x S + damping x S_d.

        Raises SingularMatrixError, also when displacements under a load of the size of the stiffness exceed SINGULAR
        and rounding of the entries changes them by NO_DIGITS.
        """
        names = tuple(weights)
        if self.last_step:
            self.forget_factors(names)
        entries, size = self.entries(weights, stiffness, damping)
        system = self.system(names)
        system.factor(entries)
        probe = np.zeros(self.nf + self.ne)
        probe[: self.nf] = size  # a load of the size of the stiffness on all coordinates
        z = system.solve(probe)
        require_digits(system.solve, lambda z: entry_rounding(len(z), *self.pattern(names), entries, z), z, self.nf)
        return system

    def pattern(self, names: tuple[str, ...]) -> tuple[Index, Index]:
        """Rows and columns of the entries, unknowns x_F first, then sigma / size; 32 bits, as there are many."""
        if names not in self._patterns:
            i, j = self.nf + self.dynamics.sweep.v_rows[self._v], self.place[self.dynamics.sweep.v_columns[self._v]]
            a, b = self.nf + self.flexibility.rows, self.nf + self.flexibility.columns
            c = self.nf + self.flexibility.rigid
            rows = [self.parts[k].rows for k in names] + [i, j, a, c]
            columns = [self.parts[k].columns for k in names] + [j, i, b, c]
            self._patterns[names] = np.concatenate(rows, dtype=np.int32), np.concatenate(columns, dtype=np.int32)
        return self._patterns[names]

    def system(self, names: tuple[str, ...] = tuple(STATIC)) -> LinearSystem:
        """Of these parts, for their `entries`; of those of the static problem, if nothing is said."""
        if names not in self._systems:
            kind = next((s.kind for s in self._systems.values()), None)  # one kind for all
            system = self._systems[names] = assemble(self.nf + self.ne, *self.pattern(names), kind, self.nf)
            if system.kind == "condensed":
                del self._patterns[names]  # large, and seldom asked for again
        return self._systems[names]

    def forget_factors(self, names: tuple[str, ...] = ("none",)) -> None:
        """Of all systems but the one of these parts."""
        for other in [other for other in self._systems if other != names]:
            if other != tuple(STATIC):  # of which the storage is asked for
                del self._systems[other]
                self._patterns.pop(other, None)
            else:
                self._systems[other].forget()

    def entries(self, weights: dict[str, float], stiffness: float = 1.0, damping: float = 0.0) -> tuple[Array, float]:
        """Entries at the present configuration, and the typical stiffness by which the rows of e are multiplied."""
        if (stiffness, damping) not in self._constant:
            f = self.flexibility
            natural = (stiffness, damping) == (1.0, 0.0)
            C, coupled, size = (f.values, f.coupled, f.size) if natural else f.inverse(stiffness, damping)
            factor = size * coupled[self.dynamics.sweep.v_rows[self._v]]
            self._constant[stiffness, damping] = factor, -size * np.concatenate((C, f.rigid_diagonal)), size
        factor, diagonal, size = self._constant[stiffness, damping]
        v = factor * self.dynamics.sweep.v_entries.take(self._v)
        parts = [(part, w) for k, w in weights.items() if len((part := self.parts[k]).rows)]
        values = [part.values() if w == 1.0 else w * part.values() for part, w in parts]
        return np.concatenate([*values, v, v, diagonal]), size

    @property
    def storage(self) -> str:
        """How its matrices are stored and factored."""
        return self.system().storage

    def displacement(self, system: LinearSystem, force: Array, refined: bool = False) -> Array:
        """Coordinates (nx,) or (nx, k) that the force (nx,) or (nx, k) on F produces, the constraint rows kept.

        `refined`: to all digits that the entries give, also in band storage; the force is (nx, k).
        """
        x = np.zeros_like(force)
        x[self.F] = system.displacement(force[self.F], refined)
        return x

    def static_matrix(self) -> Any:
        """The mixed matrix of the static problem, in compressed columns."""
        from spacar.linear_systems.condensed import CondensedSystem
        from spacar.linear_systems.sparse import SparseSystem

        system = self.system()
        if not isinstance(system, SparseSystem | CondensedSystem):
            system = SparseSystem(system.n, *self.pattern(tuple(STATIC)))
        return system.assembled(self.entries(STATIC)[0])

    def mass_matrix(self) -> Any:
        """The mass matrix, of the same order."""
        from spacar.linear_systems.sparse import SparseSystem

        mass = self.parts["mass"]
        return SparseSystem(self.nf + self.ne, mass.rows, mass.columns).assembled(mass.values())

    def assembled(self, names: tuple[str, ...]) -> Any:
        """Sum of parts (nx, nx) in compressed rows, rows and columns F only."""
        parts = [self.parts[k] for k in names]
        entries = [(self.F[part.rows], self.F[part.columns], part.values()) for part in parts]
        return compressed_sum(entries, (len(self.place), len(self.place)))

    def viscous(self) -> Any:
        """V^T S_d V (nx, nx) in compressed rows."""
        s = self.dynamics.sweep
        V = compressed(s.v_rows, s.v_columns, s.v_entries, (self.ne, len(self.place)))
        S = [(b.family.stiffness()[1] * (a := self.active[b.index])[:, None] * a).ravel() for b in self.elastic]
        rows, columns = self.flexibility.rows, self.flexibility.columns
        return V.T @ compressed(rows, columns, np.concatenate([NONE, *S]), (self.ne, self.ne)) @ V

    # -- values of the parts ------------------------------------------------------------------------------------
    def _geometric(self) -> Array:
        found = geometric_blocks(self.dynamics.sweep, self.sigma)
        return np.concatenate([NONE, *(block.ravel() for _, block in found)])

    def _inertia(self, batches: list[Batch], which: int) -> Array:
        """d(h - gravity)/dx (0) or dh/dv (1) at rest."""
        sweep, zero = self.dynamics.sweep, np.zeros(self.dynamics.numbering.nx)
        a = -self.dynamics.forces.field
        found = [b.family.inertia_gradient(sweep.configured(b), zero[b.x], a[b.x])[which] for b in batches]
        return np.concatenate([NONE, *(block.ravel() for block in found)])

    def _moments(self, n: int) -> Array:
        loads = self.dynamics.forces.loads
        moments = np.zeros((n, 3))  # the additional ones come later and are zero until then
        moments[: len(loads.moment)] = loads.moment
        return -moment_gradient(moments).ravel()
