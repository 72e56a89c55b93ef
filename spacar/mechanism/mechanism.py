"""The mechanism: an immutable bundle of arrays that every analysis reads, built from a Deck by `build`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array as Array
from spacar.arrays import Index as Index
from spacar.deck import ELEMENT_TYPES, Deck
from spacar.mechanism.layout import Batch, Layout
from spacar.mechanism.numbering import Numbering

NO_ENTRIES = np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)  # rows, columns, values
for _part in NO_ENTRIES:
    _part.setflags(write=False)


@dataclass(frozen=True)
class Loads:
    """Constant loads.

    force (nx,) dual to x [N, N m]; moment (n, 3) global moments [N m] on the lambda rows moment_rows (4, n);
    gravity (2 or 3,) [m/s^2]; preload (ne,) sigma0; flow: mass flow per tube element number [kg/s].
    """

    force: Array
    moment: Array
    moment_rows: Index
    gravity: Array
    preload: Array
    flow: dict[int, float] = field(default_factory=dict)

    @property
    def present(self) -> bool:
        """Is any of them not zero?"""
        return bool(self.flow) or any(a.any() for a in (self.force, self.moment, self.gravity, self.preload))

    def scaled(self, factor: float) -> Loads:
        return Loads(
            self.force * factor, self.moment * factor, self.moment_rows, self.gravity * factor, self.preload * factor,
            {k: v * factor for k, v in self.flow.items()},
        )  # fmt: skip

    def plus(self, other: Loads) -> Loads:
        """The sum of two sets of loads of the same mechanism."""
        return Loads(
            self.force + other.force, np.concatenate((self.moment, other.moment)),
            np.concatenate((self.moment_rows, other.moment_rows), axis=1), self.gravity + other.gravity,
            self.preload + other.preload,
            {k: self.flow.get(k, 0.0) + other.flow.get(k, 0.0) for k in {*self.flow, *other.flow}},
        )  # fmt: skip


class DriveState(NamedTuple):
    """Values, rates and accelerations of the prescribed coordinates (n_xr) and deformations (n_er)."""

    x: Array
    xd: Array
    xdd: Array
    e: Array
    ed: Array
    edd: Array


class Drive(Protocol):
    """Prescribed motion of the input coordinates and deformations as functions of time."""

    @property
    def breaks(self) -> tuple[float, ...]:
        """Times where derivatives jump."""

    def at(self, t: float) -> DriveState: ...


class Polynomial(NamedTuple):
    """start + rate t + acceleration t^2/2 of every input coordinate and deformation (input-language.md section 5.4)."""

    x: Array  # (n_xr, 3): start, rate, acceleration
    e: Array  # (n_er, 3)
    breaks: tuple[float, ...] = ()

    def at(self, t: float) -> DriveState:
        x, e = self.x.T, self.e.T
        return DriveState(
            x[0] + t * (x[1] + 0.5 * t * x[2]), x[1] + t * x[2], x[2],
            e[0] + t * (e[1] + 0.5 * t * e[2]), e[1] + t * e[2], e[2],
        )  # fmt: skip


@dataclass(frozen=True)
class UserForces:
    """What USERSIG returned: stresses added to active rows, forces added to f, and their given stiffness and damping.

    sigma (ne,), force (nx,), and diagonals k, d of both: positive k is +d sigma/de and -d f/dx. `lost`: a sentence for
    the report for every row of sigma that cannot act.
    """

    sigma: Array
    force: Array
    sigma_k: Array
    sigma_d: Array
    force_k: Array
    force_d: Array
    lost: dict[int, str] = field(default_factory=dict)

    def scaled(self, part: float) -> UserForces:
        """A part of all stresses and forces."""
        if part == 1.0:
            return self
        return replace(self, **{name: part * values for name, values in vars(self).items() if name != "lost"})


Rows = list[tuple[int, Sequence[float]]]  # place in e or x, and a row of 3 or 5 numbers that a user function returned
UserSignal = Callable[[float, Array, Array, Array, Array], UserForces]  # t, e, ed, x, xd


WITH_ADDITIONAL = (2, 3)  # ITERSTEP types: the initial loading, then the additional one


@dataclass(frozen=True)
class SolverSettings:
    """Numbers of TIMESTEP, INTEGRAT, ERROR, ITERSTEP, OUTLEVEL and MODES with their defaults."""

    duration: float | None = None
    n_steps: int = 0
    integrator: int = -1  # the method chooses itself
    step: float | None = None
    atol: float = 1e-5
    rtol: float = 1e-4
    max_iterations: int = 10
    load_steps: int = 4
    tolerance: float = 5e-7
    store_every: int = 1
    stationary_type: int = 0
    initial_steps: int = 0
    follow_path: int = 0  # 1: beyond limit points of the loading
    log_level: int = 0
    sbd_level: int | None = None  # None: the default of the mode
    modes: int | None = None  # lowest modes of vibration and buckling that are wanted; 0: all; None: by the size
    compiled: bool = True  # equations in C where that is possible (spacar.compiled); of the run, not of the deck
    beams: str = ""  # "angle" or "sine": measure of all beams and tubes instead of ADEFORM; an option of the run

    @property
    def stored_levels(self) -> int:
        """How many load levels of a stationary solution become frames."""
        if self.stationary_type not in WITH_ADDITIONAL:
            return 1
        return 1 + -(-max(self.load_steps, 1) // max(self.store_every, 1))


class Start(NamedTuple):
    """Start values of the degrees of freedom that are not prescribed, in the order of the file.

    x_value, x_rate for x dynamic; e_value, e_rate for e dynamic; x_kinematic, e_kinematic values of kinematic
    configuration coordinates (e_kinematic nan where the value of the reference configuration holds).
    """

    x_value: Array
    x_rate: Array
    e_value: Array
    e_rate: Array
    x_kinematic: Array
    e_kinematic: Array

    @property
    def is_complete(self) -> bool:
        """Whether every kinematic deformation has its value."""
        return not len(self.e_kinematic) or not np.isnan(self.e_kinematic).any()

    def state(self, e_kinematic: Array) -> Array:
        """The start state with these kinematic deformations, in the order of `spacar.dynamics.motion_equations`."""
        return np.concatenate((self.x_value, self.e_value, self.x_kinematic, e_kinematic, self.x_rate, self.e_rate))


@dataclass(frozen=True)
class Mechanism:
    """Everything an analysis needs, without the text it came from (kept in `deck` for the log)."""

    deck: Deck
    numbering: Numbering
    x0: Array  # (nx,) reference configuration
    batches: tuple[Batch, ...]
    loads: Loads
    additional: Loads | None  # DEL... increments
    additional_drive: DriveState | None  # DELINPX, DELINPE: total increments of the start values (rates unused)
    drive: Drive
    start: Start
    user_signal: UserSignal | None
    deformation_inertia: tuple[Index, Index, Array]  # MEE: rows, columns, values (both triangles)
    stiffness: tuple[Index, Index, Array]  # S of active rows as rows, columns, values of e
    damping: tuple[Index, Index, Array]
    settings: SolverSettings
    length: float  # largest distance between two nodes of the reference configuration [m]; 1 without positions

    def __post_init__(self) -> None:
        if [b.index for b in self.batches] != list(range(len(self.batches))):
            numbered = tuple(b._replace(index=k) for k, b in enumerate(self.batches))
            object.__setattr__(self, "batches", numbered)

    @cached_property
    def layout(self) -> Layout:
        return Layout(self.batches)

    @cached_property
    def scale(self) -> Array:
        """(nx,) typical size of every coordinate: `length` for positions, 1 for angles and Euler parameters, 1/length
        for twist rates."""
        n = self.numbering
        scale = np.ones(n.nx)
        scale[n.positions] = self.length
        if n.warped:
            scale[[n.x_index(node.number, 1) for node in n.nodes if node.kind == "warping"]] = 1.0 / self.length
        return scale

    @cached_property
    def is_length(self) -> NDArray[np.bool_]:
        """(ne,) whether a deformation is measured in metres."""
        found = np.zeros(self.numbering.ne, bool)
        for batch in self.batches:
            if batch.family.keyword in ELEMENT_TYPES:  # node inertia and normalizations are not
                modes = ELEMENT_TYPES[batch.family.keyword].modes
                found[batch.e[[k for k, (_, unit) in enumerate(modes) if unit == "m"]]] = True
        return found

    @cached_property
    def deformation_scale(self) -> Array:
        """(ne,) typical size of every deformation: `length` for those in metres, 1 for rotations and normalizations."""
        return np.where(self.is_length, self.length, 1.0)

    @cached_property
    def distance(self) -> float:
        """Largest coordinate of the reference configuration in its size, at least 1: more is far from the origin."""
        return max(1.0, float(np.abs(self.x0 / self.scale).max()))
