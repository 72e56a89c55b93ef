"""Newton's iteration of a level at rest and the proof of stability in one call of C each (compiled/equilibrium.c,
rest_equations.c, rest_newton.c, definite.c).

The equations, the criteria and the constants are those of `StationaryEquations`, `newton` and `DefiniteStiffness`; both
ways give the same states to rounding (tests/stationary/test_equilibrium.py). The engine takes what most models are:
holonomic, at rest, no user function, no moments, no tubes, all elements in C, and a system that is dense or has a
narrow band. Where something is unusual (a singular matrix, a gradient of gravity that is not symmetric) the equations
of NumPy are asked, whose elements share deformations and V with C.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.loaded_mechanism import constant_gravity, gravity_field
from spacar.kinematics.kinematics import LARGEST_JUMP
from spacar.linear_systems import DENSE_LIMIT, widest_band
from spacar.mechanism.layout import Batch
from spacar.mechanism.mechanism import Mechanism
from spacar.stationary.definite import SAFE, WEIGHT
from spacar.stationary.level_evaluator import ArrayEquilibrium, LevelEvaluator, StaticEquilibrium
from spacar.stationary.loading import LoadLevel, is_tube
from spacar.stationary.newton import (
    FIRST_RATIO,
    FORCES,
    LATER_RATIO,
    LENGTHS,
    Converged,
    Demand,
    growing,
    no_convergence,
    not_finite,
    too_large,
)
from spacar.stationary.resting_tangent import SYMMETRIC
from spacar.stationary.stability import CRITICAL, STABLE, Stability
from spacar.stationary.stationary_equations import FLOOR, NO_DIGITS, SINGULAR, SPREAD, Iterate


class CompiledEquilibrium:
    """`StaticEquilibrium` in C, for `levels` of which nothing moves.

    Raises NotCompiled where something does, the band is wide, or a stiffness is singular.
    """

    def __init__(self, levels: LevelEvaluator) -> None:
        from spacar.compiled.interface import constants, structure
        from spacar.compiled.library import address_of, element_functions

        if not levels.plain:
            raise NotCompiled
        self.levels, self.general = levels, ArrayEquilibrium(levels)
        self.mechanism, self.arrays = levels.mechanism, levels.arrays
        m = self.mechanism
        self._call, n = element_functions(), m.numbering
        self._factored_in_c = False
        self._statuses = constants("FOUND", "TOO_LARGE", "GROWING", "NO_END", "NOT_A_NUMBER")
        xs, es = n.x_class["input"], n.e_class["input"]
        first, count = n.x_class["calculable"].start, xs.stop - xs.start
        self.nx, self.ne, self.nf = n.nx, n.ne, n.nx - first - count
        limit = max(m.settings.max_iterations, 1)
        loads, weighs = self._loads()
        self.heavy = weighs and bool(m.layout.moving)
        least = np.ones(n.nx)
        least[n.positions] = 0.0
        sizes = n.nx, n.ne, n.nx + n.ne + 2 * (self.nf + n.ne), limit
        own = self._x, self._sigma, self._out, self._sizes = [np.empty(size) for size in sizes]
        self._keep: list[Any] = [m.x0, m.scale, m.deformation_scale, least, loads]
        groups = self._groups()
        self._held: Array | None = None
        self.c = c = structure("Equilibrium")(
            ctypes.addressof(groups), *map(address_of, self._keep[:5]), None, address_of(self.arrays.branch),
            address_of(self.arrays.e), n.nx, n.ne, self.nf, len(groups), first, xs.start, count, es.start,
            es.stop - es.start, self.heavy, int(widest_band(self.nf + self.ne, True)), DENSE_LIMIT,
        )  # fmt: skip
        c.x, c.sigma, c.out, c.sizes = map(address_of, own)
        c.floor, c.singular, c.no_digits, c.spread = FLOOR, SINGULAR, NO_DIGITS, SPREAD
        c.first_ratio, c.later_ratio, c.jump, c.symmetric = FIRST_RATIO, LATER_RATIO, LARGEST_JUMP, SYMMETRIC
        c.guess_forces, c.guess_lengths, c.weight, c.safe = FORCES, LENGTHS, WEIGHT, SAFE
        self.address = ctypes.c_void_p(ctypes.addressof(c))
        if self._call.equilibrium_begin(self.address):
            raise NotCompiled

    def __del__(self) -> None:
        address = getattr(self, "address", None)
        if address is not None:
            self._call.equilibrium_end(address)

    def load(self, level: LoadLevel) -> None:
        self.levels.load(level)
        c, held, acting = self.c, self.levels.fading_force, self.levels.acting
        c.parts[0], c.parts[1], c.hold = acting.initial, acting.additional, self.levels.fading_part
        if held is not self._held:
            self._held = held
            c.held = None if held is None else held.ctypes.data

    def newton(self, x: Array, sigma: Array, demand: Demand) -> Converged:
        self.levels.evaluated = x
        found = self.tried(x, sigma, demand)
        self._factored_in_c = found is not None
        if found is None:
            return self.general.newton(x, sigma, demand)
        self.levels.evaluated = found.point.x
        return found

    def tried(self, x: Array, sigma: Array, demand: Demand) -> Converged | None:
        """As `newton`; None where C does not find the state. Raises Astray."""
        c = self.c
        self._from(x, sigma)
        c.forces, c.lengths, c.correction, c.tolerance = demand.sizes
        c.limit = min(demand.limit, len(self._sizes))
        status = self._call.equilibrium_newton(self.address)
        sizes = self._sizes[: c.iterations].tolist()
        found, large, grown, endless, undefined = self._statuses
        if status == found:
            return Converged(self._iterate(), c.iterations, c.noise, regular=c.iterations > 0)
        if status == large:
            raise too_large(sizes[-1])
        if status == grown:
            raise growing(sizes)
        if status in (endless, undefined):
            raise no_convergence(c.limit) if status == endless else not_finite()
        return None

    def point(self, x: Array, sigma: Array) -> Iterate:
        self.levels.evaluated = x
        self._from(x, sigma)
        self._call.equilibrium_point(self.address)
        return self._iterate()

    def set_state(self, p: Iterate) -> None:
        self.levels.evaluated = p.x
        self._factored_in_c = self.factored_sign(p) is not None
        if not self._factored_in_c:
            self.general.set_state(p)

    def stability(self, p: Iterate, noise: float, regular: bool, before: Stability | None) -> Stability | None:
        hopeful = noise <= CRITICAL and (before is None or before.negative == 0) and self.mechanism.numbering.nddof
        if hopeful and self.is_definite(p) and (regular or self.factored_sign(p) is not None):
            return STABLE
        return self.general.stability(p, noise, regular, before)

    def sign(self, p: Iterate, factored: bool) -> float:
        if factored and self._factored_in_c:
            return self.last_sign()
        sign = None if factored else self.factored_sign(p)
        return self.general.sign(p, factored) if sign is None else sign

    def factored_sign(self, p: Iterate) -> float | None:
        """The sign of the determinant of the tangent stiffness at a point; None where the matrix may be singular."""
        self._from(p.x, p.sigma)
        if self._call.equilibrium_factor(self.address):
            return None
        return self.c.sign * (-1.0) ** self.ne

    def last_sign(self) -> float:
        """The same of the last matrix that was factored."""
        return float(self._call.equilibrium_sign(self.address)) * (-1.0) ** self.ne

    def is_definite(self, p: Iterate) -> bool:
        """Is it proved that the tangent stiffness at a point has no negative eigenvalue?"""
        self._from(p.x, p.sigma)
        return bool(self._call.equilibrium_definite(self.address))

    def _from(self, x: Array, sigma: Array) -> None:
        self._x[:], self._sigma[:] = x, sigma

    def _iterate(self) -> Iterate:
        c, out, a, b = self.c, self._out.copy(), self.nx, self.nx + self.ne
        n = self.nf + self.ne
        return Iterate(
            out[:a], out[a:b], out[b : b + n], out[b + n :], c.work_force, c.work, c.work_size, c.gap, bool(c.quiet),
            0.0, None, None,
        )  # fmt: skip

    # -- what C is given ------------------------------------------------------------------------------------------
    def _loads(self) -> tuple[Array, bool]:
        """Both parts of the loading, of which a level takes fractions: forces (nx,), gravity (nx,), stresses (ne,),
        steps of the prescribed coordinates and deformations. And is there any gravity?"""
        m, n = self.mechanism, self.mechanism.numbering
        xs, es, more = n.x_class["input"], n.e_class["input"], m.additional_drive
        a, b, c = n.nx, 2 * n.nx, 2 * n.nx + n.ne
        d = c + xs.stop - xs.start
        table, weighs = np.zeros((2, d + es.stop - es.start)), False
        for row, loads in zip(table, (m.loads, m.additional), strict=True):
            if loads is None:
                continue
            row[:a], row[b:c] = loads.force, loads.preload
            if loads.gravity.any():
                row[a:b] = field = gravity_field(m, loads)
                row[:a] += constant_gravity(field, self._constant_masses())
                weighs = weighs or bool(field.any())
        if d > c or len(table[0]) > d:
            start = m.drive.at(0.0)
            table[0, c:d], table[0, d:] = start.x - m.x0[xs], start.e
            if more is not None:
                table[1, c:d], table[1, d:] = more.x, more.e
        return table, weighs

    def _groups(self) -> Any:
        """What C needs of the batches in the equations: those that have mass only come last."""
        from spacar.compiled.interface import structure
        from spacar.compiled.library import address_of

        layout, heavy, keep = self.mechanism.layout, self.heavy, self._keep
        moving, curved = {b.index for b in layout.moving}, {b.index for b in layout.curved}
        batches = [*layout.strained, *(b for b in layout.moving if heavy and not b.family.n_deformations)]
        groups = (structure("Group") * len(batches))()
        keep.append(groups)
        gradient = address_of(self.arrays.entries)
        for group, b in zip(groups, batches, strict=True):
            family: Any = b.family
            x, e = np.ascontiguousarray(b.x), np.ascontiguousarray(b.e)
            keep += family, x, e
            group.elements, group.x, group.e = ctypes.addressof(family.elements), address_of(x), address_of(e)
            group.curved, group.heavy = b.index in curved, heavy and b.index in moving
            if family.n_deformations:
                group.V = gradient
                gradient += 8 * len(b.e) * b.x.size
                S = np.array(family.stiffness()[0], order="C")  # that of the family is read-only
                if S.any():
                    keep.append(S)
                    group.S = address_of(S)
        return groups

    def _constant_masses(self) -> list[tuple[Batch, Array]]:
        """Mass matrices that never change, (n_coordinates, n_coordinates, n) of each batch that has one."""
        found = []
        for b in self.mechanism.layout.massive:
            if b.family.constant_mass:
                M = np.zeros((len(b.x), *b.x.shape))
                b.family.mass(None, M)
                found.append((b, M))
        return found


class NotCompiled(Exception):
    """The engine does not take this mechanism."""


def takes(m: Mechanism) -> bool:
    """Does the engine take a mechanism, if nothing moves?"""
    if m.x0.dtype != float or m.x0.ndim > 1:  # complex steps, cases side by side
        return False
    if not m.numbering.holonomic or m.user_signal is not None or not m.layout.strained:
        return False
    parts = [m.loads] if m.additional is None else [m.loads, m.additional]
    if any(loads.moment_rows.size or loads.flow for loads in parts) or any(map(is_tube, m.layout.moving)):
        return False
    return all(b.family.compiled for b in (*m.layout.strained, *m.layout.moving))


def level_equilibrium(mechanism: Mechanism) -> StaticEquilibrium:
    """In C where the mechanism has compiled elements and C has all that acts on it."""
    levels = LevelEvaluator(mechanism)
    if takes(mechanism):
        try:
            return CompiledEquilibrium(levels)
        except NotCompiled:
            pass
    return ArrayEquilibrium(levels)
