"""Newton's iteration of a level at rest and the proof of stability in one call of C each (compiled/equilibrium.c,
definite.c).

The equations, the criteria and the constants are those of `StationaryEquations`, `newton` and `DefiniteStiffness`; both
ways give the same states to rounding (tests/stationary/test_equilibrium.py). The engine takes what most models are:
holonomic, at rest, no user function, no moments, no tubes, all elements in C, and a system that is dense or has a
narrow band. It answers None where something is unusual: a singular matrix, a gradient of gravity that is not symmetric.
"""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.forces import AppliedForces
from spacar.kinematics.kinematics import LARGEST_JUMP
from spacar.linear_systems import BAND_LIMIT, DENSE_LIMIT
from spacar.stationary.contract import NO_DIGITS, SINGULAR, SPREAD, Astray
from spacar.stationary.definite import SAFE, WEIGHT, WIDEST, largest_stiffness, stiffness_of
from spacar.stationary.flexibility import is_tube
from spacar.stationary.loading import LoadLevel
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
from spacar.stationary.stationary_equations import FLOOR, Iterate, StationaryEquations

FOUND, ANOTHER_WAY, NOT_A_NUMBER, TOO_LARGE, GROWING, NO_END = range(6)  # as in equilibrium.c
POINTER, NUMBER, WHOLE = ctypes.c_void_p, ctypes.c_double, ctypes.c_int64
DOUBLES = INTEGERS = POINTER
Numbers = list[tuple[Any, str | int, Array]]  # a structure or array of pointers in C, its field, the numbers for it


class CGroup(ctypes.Structure):
    """`Group` of equilibrium.c."""

    _fields_ = [
        ("elements", POINTER), ("x", INTEGERS), ("e", INTEGERS), ("V", DOUBLES), ("S", DOUBLES), ("held", DOUBLES),
        ("curved", WHOLE), ("heavy", WHOLE),
    ]  # fmt: skip


class CEquilibrium(ctypes.Structure):
    """`Equilibrium` of equilibrium.c."""

    _fields_ = [
        ("groups", POINTER),
        *((name, INTEGERS) for name in ("v_rows", "v_columns", "place", "flexible_rows", "flexible_columns", "rigid")),
        *((name, DOUBLES) for name in (
            "flexible", "rigid_diagonal", "coupled", "loose", "passive", "scale", "e_scale", "least",
        )),
        *((name, DOUBLES * 2) for name in ("force", "preload", "gravity")),
        ("x_start", DOUBLES), ("x_step", DOUBLES * 2), ("e_step", DOUBLES * 2), ("held", DOUBLES),
        ("near", DOUBLES), ("e", DOUBLES), ("V", DOUBLES),
        *((name, WHOLE) for name in (
            "nx", "ne", "nf", "n_groups", "n_v", "n_flexible", "n_rigid", "x_input", "n_x_input", "e_input",
            "n_e_input", "heavy", "widest", "dense",
        )),
        ("size", NUMBER), ("parts", NUMBER * 2), ("hold", NUMBER),
        *((name, NUMBER) for name in (
            "floor", "singular", "no_digits", "spread", "first_ratio", "later_ratio", "jump", "symmetric",
            "guess_forces", "guess_lengths", "weight", "safe", "elastic",
        )),
        ("widest_definite", WHOLE),
        *((name, NUMBER) for name in ("forces", "lengths", "correction", "tolerance")),
        *((name, DOUBLES) for name in ("x", "sigma", "out", "sizes")),
        *((name, WHOLE) for name in ("limit", "iterations", "quiet")),
        *((name, NUMBER) for name in ("work_force", "work", "work_size", "gap", "noise", "sign")),
        ("own", POINTER),
    ]  # fmt: skip


class Equilibrium:
    """The equations of one mechanism in C. They share `near`, `e` and V with its sweep, whose configurations they leave
    as they were.

    Raises NotCompiled where the engine does not take the mechanism.
    """

    def __init__(self, equations: StationaryEquations) -> None:
        from spacar.compiled.library import element_functions

        d = equations.d
        m, n, sweep, C = d.mechanism, d.numbering, d.sweep, equations.flexibility
        if not takes(d):
            raise NotCompiled
        self._call = element_functions()
        self.nx, self.ne, self.nf = n.nx, n.ne, equations.nf
        self.c = c = CEquilibrium()
        place = np.full(n.nx, -1)
        place[equations.F] = np.arange(self.nf)
        numbers: Numbers = [
            (c, "v_rows", sweep.v_rows), (c, "v_columns", sweep.v_columns), (c, "place", place),
            (c, "flexible_rows", C.rows), (c, "flexible_columns", C.columns), (c, "rigid", C.rigid),
            (c, "flexible", C.values), (c, "rigid_diagonal", C.rigid_diagonal), (c, "coupled", C.coupled),
            (c, "loose", equations.loose), (c, "passive", equations.passive.astype(float)),
            (c, "scale", equations.scale), (c, "e_scale", equations.e_scale), (c, "least", equations.least),
        ]  # fmt: skip
        loads = [m.loads] if m.additional is None else [m.loads, m.additional]
        applied = [AppliedForces(m, part, sweep) for part in loads]
        heavy = {b.index for b in sweep.moving} if any(forces.heavy for forces in applied) else set()
        self.heavy = bool(heavy)  # is there gravity that depends on the configuration?
        self._put_loads(d, applied, equations, numbers)
        curved = {b.index for b in sweep.curved}
        groups = [b for b in m.batches if b.family.n_deformations or b.index in heavy]
        self._groups = (CGroup * len(groups))()
        entries, gradients = sweep.entries.ctypes.data, {key: part.start for key, part, _ in sweep.layout.V}
        for group, b in zip(self._groups, groups, strict=True):
            family: Any = b.family
            group.elements = ctypes.addressof(family.elements)
            numbers += (group, "x", b.x), (group, "e", b.e)
            if b.family.n_deformations:
                group.V = entries + 8 * gradients[b.index]
                S, held = stiffness_of(C, b, m.deformation_scale)
                numbers.append((group, "held", held))
                if S is not None:
                    numbers.append((group, "S", S))
            group.curved, group.heavy = b.index in curved, b.index in heavy
        sizes = n.nx, n.ne, n.nx + n.ne + 2 * (self.nf + n.ne), max(m.settings.max_iterations, 1)
        self._x, self._sigma, self._out, self._sizes = _parts(np.zeros(sum(sizes)), sizes)
        self._keep = [_put(numbers, np.int64), _put(numbers, np.float64)]
        at = self._x.ctypes.data
        c.x, c.sigma, c.out, c.sizes = (at + 8 * sum(sizes[:k]) for k in range(4))
        c.near, c.e, c.V = sweep.near.ctypes.data, sweep.e.ctypes.data, entries
        c.groups, c.n_groups = ctypes.addressof(self._groups), len(groups)
        c.n_v, c.n_flexible, c.n_rigid = len(sweep.v_rows), len(C.rows), len(C.rigid)
        c.nx, c.ne, c.nf, c.size, c.heavy = n.nx, n.ne, self.nf, C.size, self.heavy
        c.widest, c.dense, c.widest_definite = BAND_LIMIT, DENSE_LIMIT, WIDEST
        c.floor, c.singular, c.no_digits, c.spread = FLOOR, SINGULAR, NO_DIGITS, SPREAD
        c.first_ratio, c.later_ratio, c.jump, c.symmetric = FIRST_RATIO, LATER_RATIO, LARGEST_JUMP, SYMMETRIC
        c.guess_forces, c.guess_lengths, c.weight, c.safe = FORCES, LENGTHS, WEIGHT, SAFE
        c.elastic = largest_stiffness(C, m.deformation_scale)
        self.address = ctypes.c_void_p(ctypes.addressof(c))
        weakref.finalize(self, _end, self._call.equilibrium_end, c)
        if self._call.equilibrium_begin(self.address):
            raise NotCompiled

    def _put_loads(
        self, d: Dynamics, applied: list[AppliedForces], equations: StationaryEquations, numbers: Numbers
    ) -> None:
        """Both parts of the loading, of which a level takes fractions."""
        c, m, n = self.c, d.mechanism, d.numbering
        nothing_x, nothing_e = np.zeros(n.nx), np.zeros(n.ne)
        xs, es = n.x_class["input"], n.e_class["input"]
        c.x_input, c.n_x_input, c.e_input, c.n_e_input = xs.start, xs.stop - xs.start, es.start, es.stop - es.start
        x_start, more = m.x0[xs], m.additional_drive
        numbers.append((c, "x_start", x_start))
        x_steps, e_steps = [nothing_x, nothing_x], [nothing_e, nothing_e]
        if len(n.rheonomic):
            start = m.drive.at(0.0)
            x_steps[0], e_steps[0] = start.x - x_start, start.e
        if more is not None:
            x_steps[1], e_steps[1] = more.x, more.e
        force, gravity, preload, x_step, e_step = c.force, c.gravity, c.preload, c.x_step, c.e_step
        for k in (0, 1):
            part = applied[k] if k < len(applied) else None
            numbers += (
                (force, k, nothing_x if part is None else part.constant),
                (gravity, k, nothing_x if part is None else part.field),
                (preload, k, nothing_e if part is None else part.loads.preload * equations.active),
                (x_step, k, x_steps[k]), (e_step, k, e_steps[k]),
            )  # fmt: skip

    def load(self, level: LoadLevel, held: Array | None, hold: float) -> None:
        """Take the loads of a level; the force `held` (nx,) times `hold` is held back."""
        c = self.c
        c.parts[0], c.parts[1], c.hold = level.initial, level.additional, hold
        if held is not None and not c.held:
            self._keep.append(held)
            c.held = held.ctypes.data

    def newton(self, x: Array, sigma: Array, demand: Demand) -> Converged | None:
        """As `spacar.stationary.newton.newton`. Raises Astray."""
        c = self.c
        self._from(x, sigma)
        self._ask_for(demand)
        status = self._call.equilibrium_newton(self.address)
        if status == FOUND:
            return Converged(self._iterate(), c.iterations, c.noise, regular=c.iterations > 0)
        if status == ANOTHER_WAY:
            return None
        raise self._astray(status)

    def _ask_for(self, demand: Demand) -> None:
        c = self.c
        c.forces, c.lengths = demand.forces, demand.lengths
        c.correction, c.tolerance = demand.correction, demand.tolerance
        c.limit = min(demand.limit, len(self._sizes))

    def walk(self, passed: ctypes.Structure, demand: Demand) -> None:
        """As `spacar.stationary.passed_levels` describes; other loads are taken."""
        self._ask_for(demand)
        self._call.equilibrium_walk(self.address, ctypes.addressof(passed))

    def _astray(self, status: int) -> Astray:
        sizes = self._sizes[: self.c.iterations].tolist()
        if status == TOO_LARGE:
            return too_large(sizes[-1])
        if status == GROWING:
            return growing(sizes)
        return no_convergence(self.c.limit) if status == NO_END else not_finite()

    def point(self, x: Array, sigma: Array) -> Iterate:
        """As `StationaryEquations.point`."""
        self._from(x, sigma)
        self._call.equilibrium_point(self.address)
        return self._iterate()

    def sign(self, p: Iterate) -> float | None:
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

    def linearize(self, x: Array, sigma: Array, into: ctypes.Structure) -> bool:
        """What `spacar.stationary.about_rest` describes, at x (nx,), sigma (ne,). False where Python has to do it."""
        self._from(x, sigma)
        return self._call.equilibrium_linearize(self.address, ctypes.addressof(into)) == FOUND

    def _from(self, x: Array, sigma: Array) -> None:
        self._x[:], self._sigma[:] = x, sigma

    def _iterate(self) -> Iterate:
        c, out, a, b = self.c, self._out.copy(), self.nx, self.nx + self.ne
        n = self.nf + self.ne
        return Iterate(
            out[:a], out[a:b], out[b : b + n], out[b + n :], c.work_force, c.work, c.work_size, c.gap, bool(c.quiet),
            0.0, None, None,
        )  # fmt: skip


class NotCompiled(Exception):
    """The engine does not take this mechanism."""


def takes(d: Dynamics) -> bool:
    """Does the engine take a mechanism at rest without user functions?"""
    m = d.mechanism
    if m.x0.dtype != float or m.x0.ndim > 1:  # complex steps, cases side by side
        return False
    parts = [m.loads] if m.additional is None else [m.loads, m.additional]
    if any(loads.moment_rows.size or loads.flow for loads in parts) or any(map(is_tube, d.sweep.moving)):
        return False
    return all(b.family.compiled for b in (*d.sweep.strained, *d.sweep.moving))


def _put(numbers: Numbers, kind: Any) -> Array:
    """Those of a kind one after the other in an array, and the fields of C point there."""
    mine = [(owner, name, v.ravel()) for owner, name, v in numbers if (v.dtype == np.int64) == (kind is np.int64)]
    room = np.concatenate([values for _, _, values in mine], dtype=kind)
    at = room.ctypes.data
    for owner, name, values in mine:
        if isinstance(name, str):
            setattr(owner, name, at)
        else:
            owner[name] = at
        at += 8 * len(values)
    return room


def _parts(room: Array, sizes: Sequence[int]) -> list[Array]:
    """The parts of an array, one after the other."""
    ends = [sum(sizes[: k + 1]) for k in range(len(sizes))]
    return [room[end - size : end] for size, end in zip(sizes, ends, strict=True)]


def _end(end: Any, c: CEquilibrium) -> None:
    end(ctypes.addressof(c))
