"""What is evaluated and where an evaluator stands, both values that never change; applied forces and stresses.

f = XF + moments + gravity + user forces;  sigma = S e + S_d ed + sigma0 + user stresses on the active rows (dynamic,
kinematic, calculable deformations). A constant global moment M on a spatial orientation node has the dual forces
f_lambda = 2 Lambda_bar(lambda)^T M = 2 (-l.M, lambda0 M - l x M) (files.md section 5), which follow the orientation.
Gravity on a family is minus the inertia force of the acceleration -g at its position coordinates.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array, Index
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism.layout import Batch
from spacar.mechanism.mechanism import NO_ENTRIES, Drive, Loads, Mechanism, UserForces

Entries = tuple[Index, Index, Array]  # rows, columns, values (n,), or (n, cases)


@dataclass(frozen=True)
class StressLaw:
    """sigma = S e + S_d ed + preload on the rows `first` and following; the rows before get zero."""

    first: int
    ne: int
    stiffness: Entries
    damping: Entries
    preload: Array

    @classmethod
    def of(cls, mechanism: Mechanism, loads: Loads, first: int | None = None) -> StressLaw:
        """Law of a mechanism; `first` overrides the first active row (mode 3 treats input rows as dynamic)."""
        n = mechanism.numbering
        first = n.e_class["input"].stop if first is None else first
        preload = loads.preload.copy()
        preload[:first] = 0.0
        stiffness, damping = active_entries(mechanism.stiffness, first), active_entries(mechanism.damping, first)
        return cls(first, n.ne, stiffness, damping, preload)

    @cached_property
    def passive(self) -> bool:
        """No element carries a constitutive stress."""
        return not (len(self.stiffness[0]) or len(self.damping[0]) or np.count_nonzero(self.preload))

    def __call__(self, e: Array, ed: Array) -> Array:
        sigma = self.preload.copy()
        for (rows, columns, values), of in ((self.stiffness, e), (self.damping, ed)):
            sigma += np.bincount(rows, values * of[columns], self.ne)
        return sigma


def active_entries(entries: Entries, first: int) -> Entries:
    """Those whose row and column are not before the first active deformation; values (n,) or (n, cases)."""
    rows, columns, values = entries
    keep = (rows >= first) & (columns >= first)
    return rows[keep], columns[keep], values[keep]


class AppliedForces:
    """f without the gravity on configuration-dependent families, which `inertia` subtracts together with h."""

    def __init__(self, mechanism: Mechanism, loads: Loads, sweep: ElementSweep) -> None:
        self.loads = loads
        self.field = gravity_field(mechanism, loads)
        self.heavy = bool(self.field.any())
        self.constant_gravity = constant_gravity(self.field, sweep.constant_masses() if self.heavy else ())
        self.constant = loads.force + self.constant_gravity
        self.user = mechanism.user_signal

    def __call__(self, x: Array, user: UserForces | None) -> Array:
        """Applied forces except gravity on moving families, (nx,)."""
        f = self.constant + self.moments(x)
        if user is not None:
            f += user.force
        return f

    def moments(self, x: Array) -> Array:
        """Dual forces of the constant global moments, (nx,)."""
        rows = self.loads.moment_rows
        if not rows.size:
            return np.zeros(len(self.constant))
        dual = (moment_gradient(self.loads.moment) * x[rows]).sum(axis=1)
        return np.bincount(rows.ravel(), dual.ravel(), len(self.constant))

    def inertia(self, sweep: ElementSweep, v: Array) -> Array:
        """h minus gravity of the configuration-dependent families, (nx,)."""
        return sweep.inertia_force(v, -self.field if self.heavy else None)

    def gravity(self, sweep: ElementSweep) -> Array:
        """Gravity forces of all families, M g, (nx,)."""
        return sweep.mass_times(self.field) if self.heavy else np.zeros(len(self.constant))


def moment_gradient(moments: Array) -> Array:
    """df_lambda/dlambda = 2 [0, -M^T; M, M~] of constant global moments (n, 3), (4, 4, n); f is linear in lambda."""
    from spacar.elements.rotations.rotation import global_dual  # spatial only: planar models do not load it

    return 2.0 * global_dual(moments.T)


def moment_entries(rows: Index, moments: Array) -> Entries:
    """Rows, columns and values (16 n,) of df/dx of constant global moments (n, 3) at the Euler parameters `rows` (4, n)
    of x: these forces are linear in x."""
    if not rows.size:
        return NO_ENTRIES
    block = moment_gradient(moments)
    i, j = (np.broadcast_to(r, block.shape).ravel() for r in (rows[:, None, :], rows[None, :, :]))
    return i, j, block.ravel()


def constant_gravity(field: Array, masses: Iterable[tuple[Batch, Array]]) -> Array:
    """M g of the field g (nx,) and of mass matrices (n_coordinates, n_coordinates, n) that never change, (nx,)."""
    force = np.zeros(len(field))
    for b, M in masses:
        np.add.at(force, b.x, (M * field[b.x][None]).sum(axis=1))
    return force


def gravity_field(mechanism: Mechanism, loads: Loads) -> Array:
    """g at every position coordinate, zero elsewhere, (nx,) [m/s^2]."""
    field = np.zeros(mechanism.numbering.nx)
    field.put(mechanism.numbering.positions, loads.gravity)  # again and again: of every node
    return field


# Which accepted steps are looked at closer, where many are made at a time (LOOK_NEVER ... of stepper.c)
NEVER, AT_DETERMINANTS, AT_VELOCITIES, ALWAYS = range(4)
SHARE = 0.1  # of a velocity: change that needs no explanation, more than the trapezoidal rule errs (forward.continuity)
NOISE = 1e-6  # of the largest scaled velocity: what is slower says nothing
STILL = 64.0 * EPS  # way in a step, in model lengths or rad, that is lost in the position


@dataclass(frozen=True)
class LoadedMechanism:
    """A mechanism under loads and prescribed motion. `own_law`: another stress law of its active deformations than that
    of mechanism and loads."""

    mechanism: Mechanism
    loads: Loads
    drive: Drive
    own_law: StressLaw | None = None

    @classmethod
    def of(cls, mechanism: Mechanism, loads: Loads | None = None, drive: Drive | None = None) -> LoadedMechanism:
        """`loads` and `drive` replace those of the mechanism."""
        return cls(mechanism, loads or mechanism.loads, drive or mechanism.drive)

    @cached_property
    def law(self) -> StressLaw:
        return self.own_law or StressLaw.of(self.mechanism, self.loads)


@dataclass(frozen=True, slots=True)
class Placement:
    """The configuration and the velocity of the last evaluated state: from here another evaluator can go on.

    x, xd (nx,); e (ne,) deformations, which also say on what branch the angles are. The arrays may be those of the
    evaluator: they hold until its next evaluation.
    """

    x: Array
    xd: Array
    e: Array


@dataclass(frozen=True, slots=True)
class Moving:
    """The last evaluated state with its accelerations: t; x, xd, xdd (nx,) or (nx, cases); e (ne,). It stays valid."""

    t: float
    x: Array
    xd: Array
    xdd: Array
    e: Array


@dataclass(frozen=True, slots=True)
class Accepted:
    """An accepted step: state y, what moves there, sign and logarithm of the determinant of V[E, U]."""

    y: Array
    at: Moving
    sign: float
    size: float


def unexplained(a: Moving, b: Moving, scale: Array) -> NDArray[np.bool_]:
    """Coordinates whose velocities change from a to b by more than their accelerations explain, as xd.

    `scale` (nx,), or (nx, 1) for cases side by side. See `spacar.forward.continuity`.
    """
    h = b.t - a.t
    v, acceleration = np.maximum(np.abs(a.xd), np.abs(b.xd)), np.maximum(np.abs(a.xdd), np.abs(b.xdd))
    change = np.abs(b.xd - a.xd - (0.5 * h) * (a.xdd + b.xdd))
    fastest = (v / scale).max(axis=0, initial=0.0)
    moves = fastest * abs(h) > STILL
    return np.asarray(moves & (change > abs(h) * acceleration + SHARE * v + fastest * scale * NOISE))


class DeformationInertia:
    """The inertia V^T M_e V of MEE as entries of an nx x nx matrix."""

    def __init__(self, mechanism: Mechanism, sweep: ElementSweep) -> None:
        i, j, value = self.table = mechanism.deformation_inertia
        self.present = bool(len(i))
        self.sweep = sweep
        pairs = [NO_ENTRIES]
        for r, c, w in zip(i, j, value, strict=True):
            a, b = np.flatnonzero(sweep.v_rows == r), np.flatnonzero(sweep.v_rows == c)
            pairs.append((np.repeat(a, len(b)), np.tile(b, len(a)), np.full(len(a) * len(b), w)))
        self.a, self.b, self.value = (np.concatenate(p) for p in zip(*pairs, strict=True))
        self.rows, self.columns = sweep.v_columns[self.a], sweep.v_columns[self.b]

    def entries(self) -> Array:
        """Values of V^T M_e V in the order of `rows`, `columns`."""
        v = self.sweep.v_entries
        return np.asarray(self.value * v[self.a] * v[self.b])

    def stress(self, edd: Array) -> Array:
        """M_e edd, (ne,)."""
        i, j, value = self.table
        return np.bincount(i, value * edd[j], len(edd))
