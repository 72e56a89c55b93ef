"""What `spacar.flexure` gives: arrays over the stroke, columns, extremes; pages and stresses from the rooms above."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.elements.rotations.rotation import rotate
from spacar.errors import UsageError
from spacar.modes import registered
from spacar.result import Result
from spacar.stroke.error_motions import ErrorMotions
from spacar.stroke.observed_node import ObservedNode
from spacar.stroke.station import Station
from spacar.stroke.stroke_move import StrokeMove

DIRECTION = {"ux": "x", "uy": "y", "uz": "z", "phi": "r", "phix": "rx", "phiy": "ry", "phiz": "rz"}
EXTRA = (("margin_extra", "locked", "extra"), ("margin_extra_free", "free", "extra_free"))
UNBALANCED = 0.01  # of the energy: when the work integral misses more, there is a warning
POINTS = 9  # places along every beam where stresses are computed


@dataclass(frozen=True)
class Column:
    """One quantity over the stroke: name, what it is, unit, values (k,)."""

    name: str
    title: str
    unit: str
    values: Array


@dataclass(frozen=True)
class Flexure:
    """Over k states of the stroke, m directions of the node (x, y, z, rx, ry, rz; planar x, y, r), in SI units.

    source        name of the model;  move  the drive and its range;  node  whose stiffness and motion it is
    metre         unit of length of the model in metres (shown);  zero  index of the undeflected state
    stroke        (k,) of the drive from the reference configuration [m, rad]
    force         (k,) of the actuator [N, N m];  drive_stiffness  (k,) its derivative by the stroke
    work          (k,) of the actuator from the undeflected state [J];  load_work  (k,) of all other loads
    stations      what was computed at every state;  errors  motion, pivot shift, pole;  result  for pictures, stresses
    extra         the load whose own multiplier was asked for, as given
    """

    source: str
    move: StrokeMove
    node: ObservedNode
    metre: float
    zero: int
    stroke: Array
    force: Array
    drive_stiffness: Array
    work: Array
    load_work: Array
    stations: tuple[Station, ...]
    errors: ErrorMotions
    result: Result
    extra: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.stroke)

    def __repr__(self) -> str:
        low, high = self.stroke[0], self.stroke[-1]
        text = f"Flexure of {self.source}: {self.move.text} from {low:.6g} to {high:.6g} {self.move.unit}"
        text += f", {len(self)} states, node {self.node.position}"
        return f"{text}; .table(), .stress, .plot(), .report('page.html')"

    @property
    def directions(self) -> tuple[str, ...]:
        """Names of the m directions."""
        return tuple(DIRECTION[name] for name in self.node.names)

    def compliance(self, locked: bool = True, body: bool = False) -> Array:
        """(k, m, m) displacements and small rotations of the node by unit forces and moments.

        locked  with the drive held, else free;  body  along axes that turn with the node instead of the global ones
        """
        C = self.of("locked" if locked else "free")
        if body:
            B = np.array([_body_axes(self.node, s.frame.x) for s in self.stations])
            C = B @ C @ B.transpose(0, 2, 1)
        return C

    def stiffness(self, locked: bool = True, body: bool = False) -> Array:
        """(k, m) force over displacement along each direction with nothing else held; infinite where nothing moves."""
        c = np.diagonal(self.compliance(locked, body), axis1=1, axis2=2)
        with np.errstate(divide="ignore"):
            return np.where(c == 0.0, np.inf, 1.0 / c)

    def remaining(self, body: bool = False) -> Array:
        """(k, m) support stiffness (drive locked) over that of the undeflected state; nan where it is infinite."""
        k = self.stiffness(body=body)
        with np.errstate(invalid="ignore"):
            return k / k[self.zero]

    @property
    def energy(self) -> Array:
        """(k,) strain energy [J]."""
        return self.of("energy")

    @property
    def missing_energy(self) -> Array:
        """(k,) strain energy since the undeflected state minus all work [J]: the error of the integrals."""
        return self.energy - self.energy[self.zero] - self.work - self.load_work

    @property
    def imbalance(self) -> float:
        """Largest missing energy over the largest of strain energy and work; 0 when there is none."""
        size = max(float(np.max(np.abs(v))) for v in (self.energy, self.work, self.load_work))
        return float(np.max(np.abs(self.missing_energy))) / size if size > 0.0 else 0.0

    @property
    def frequencies(self) -> Array:
        """(k, f) with the drive locked [Hz]; the first is the first unwanted one, negative: unstable."""
        return self.of("hertz")

    @property
    def free_frequencies(self) -> Array:
        """(k, f) with the drive free [Hz]."""
        return self.of("hertz_free")

    def of(self, name: str) -> Array:
        """(k, ...) a field of the stations, such as drive_hertz, unwanted_free [Hz], margin, margin_free, extra."""
        return np.array([getattr(s, name) for s in self.stations])

    @cached_property
    def stress(self) -> Any:
        """Stress resultants and stresses of all states, as `Result.stress`."""
        return self.result.stress(points=POINTS)

    @cached_property
    def largest_stress(self) -> tuple[Array, Array, Array]:
        """(k,) largest von Mises stress [N/m^2], element (0: none), place in it from 0 to 1; nan without sections."""
        try:
            mises = self.stress["mises"]
        except UsageError:  # no beams
            mises = np.full((len(self), 1, 1), np.nan)
        flat = mises.reshape(len(mises), -1)
        if not flat.shape[1] or not np.isfinite(flat).any(axis=1).all():
            none = np.full(len(self), np.nan)
            return none, np.zeros(len(self), np.int64), none
        places = np.nanargmax(flat, axis=1)
        element, point = np.unravel_index(places, mises.shape[1:])
        return flat[np.arange(len(flat)), places], self.stress.elements[element], self.stress.xi[point]

    @property
    def warnings(self) -> list[str]:
        """What a reader has to know, one sentence each."""
        found = [line.removeprefix("warning: ") for line in self.result.report if line.startswith("warning: ")]
        if self.imbalance > UNBALANCED:
            found.append(
                f"the integral of the work misses {100.0 * self.imbalance:.2g} % of the energy: the force changes"
                " within a step of the stroke; take more steps"
            )
        return found

    @property
    def support(self) -> list[int]:
        """Which of the m directions are supports: all but that of the drive, where the node is that of the drive."""
        move = self.move
        if move.deformation or move.number not in (self.node.position, self.node.orientation):
            return list(range(len(self.directions)))
        driven = move.text.lstrip("0123456789")
        return [i for i, d in enumerate(self.directions) if d != driven]

    def columns(self, body: bool = False) -> list[Column]:
        """All quantities with one value a state, in SI; `body`: stiffness along axes of the node."""
        move = self.move
        stress, element, place = self.largest_stress
        return [
            Column("stroke", f"stroke of {move.text}", move.unit, self.stroke),
            Column("force", "actuator force", move.force_unit, self.force),
            Column("drive_stiffness", "drive stiffness", move.stiffness_unit, self.drive_stiffness),
            Column("work", "work of the actuator", "J", self.work),
            Column("load_work", "work of the other loads", "J", self.load_work),
            Column("energy", "strain energy", "J", self.energy),
            *self.motion_columns(),
            *self._stiffness_columns(body),
            *(
                Column(f"{name}_{i}", f"frequency, {drive} {i}", "Hz", hertz)
                for name, drive, values in (("f", "locked", self.frequencies), ("ffree", "free", self.free_frequencies))
                for i, hertz in enumerate(values.T, 1)
            ),
            Column("f_drive", "frequency, free drive", "Hz", self.of("drive_hertz")),
            Column("f_unwanted_free", "frequency, first other of the free drive", "Hz", self.of("unwanted_free")),
            Column("margin", "load multiplier, drive locked", "", self.of("margin")),
            Column("margin_free", "load multiplier, drive free", "", self.of("margin_free")),
            *(
                Column(name, f"load multiplier, {' and '.join(self.extra)} alone, drive {drive}", "", self.of(field))
                for name, drive, field in EXTRA
                if self.extra
            ),
            Column("mises", "largest von Mises stress", "N/m^2", stress),
            Column("mises_element", "its element", "", element),
            Column("mises_place", "its place in it", "", place),
        ]

    def motion_columns(self) -> list[Column]:
        """Displacement and rotation, then the errors of a line (deviation) or of an axis (pivot shift, tilt, pole)."""
        e = self.errors
        planar = self.node.planar

        def of(name: str, title: str, unit: str, values: Array) -> list[Column]:
            axes = "xyz" if not planar else "xy" if unit == "m" else "z"
            return [Column(f"{name}_{a}", f"{title}, {a}", unit, values[:, "xyz".index(a)]) for a in axes]

        found = of("u", "displacement", "m", e.displacement) + of("rotation", "rotation", "rad", e.rotation)
        if not e.turning:
            return found + of("line", "deviation from the line", "m", e.line_error)
        tilt = [] if planar else of("tilt", "tilt of the axis", "rad", e.tilt)
        return [
            *found, Column("angle", "rotation about the axis", "rad", e.angle),
            *of("pivot", "pivot shift", "m", e.pivot_shift), *tilt, *of("pole", "pole", "m", e.pole),
        ]  # fmt: skip

    def _stiffness_columns(self, body: bool) -> list[Column]:
        units = ["N/m" if row.startswith("u") else "N m/rad" for row in self.node.names]
        kinds = (
            ("k", "support stiffness", units, self.stiffness(body=body)),
            ("kfree", "stiffness, drive free", units, self.stiffness(False, body)),
            ("remaining", "remaining support stiffness", [""] * len(units), self.remaining(body)),
        )
        return [
            Column(f"{name}_{d}", f"{title}, {d}", unit, v)
            for name, title, own, values in kinds
            for d, unit, v in zip(self.directions, own, values.T, strict=True)
        ]

    def table(self, body: bool = False) -> dict[str, Array]:
        """The columns by name, (k,) each; `body` as in `columns`."""
        return {c.name: c.values for c in self.columns(body)}

    def arrays(self) -> dict[str, Array]:
        """Everything with its shape, for a NumPy archive."""
        shaped = {
            "compliance": self.compliance(), "compliance_free": self.compliance(locked=False),
            "compliance_body": self.compliance(body=True), "compliance_free_body": self.compliance(False, True),
            **{name: value for name, value in vars(self.errors).items() if name not in ("angle", "turning")},
            "frequencies": self.frequencies, "free_frequencies": self.free_frequencies,
        }  # fmt: skip
        return shaped | {name: value for name, value in self.table().items() if name not in shaped}

    def plot(self, path: str | Path | None = None, **options: Any) -> Any:
        """A matplotlib figure over the stroke, also written to `path`; options as `spacar_drawing.flexure_plot`."""
        return registered("flexure_plot")(self, path, **options)

    def report(self, path: str | Path | None = None, **options: Any) -> str:
        """One self-contained HTML page, also written to `path`; options as `spacar_drawing.flexure_page`."""
        return str(registered("flexure_page")(self, path, **options))


def _body_axes(node: ObservedNode, x: Array) -> Array:
    """(m, m) from global axes to those that turn with the node."""
    R = rotate(node.turn(x)[:, None], np.eye(3))
    m = len(node.names)
    B = np.eye(m)
    points = node.points
    B[:points, :points] = R[:points, :points].T
    if m > points and not node.planar:
        B[points:, points:] = R.T
    return B
