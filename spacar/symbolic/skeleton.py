"""What a system looks like: points, lines between them and middle lines of beams, as nodes and elements.

The tables are those of a result of the numeric core (reference/files.md, sections 3 and 4), so that `draw` and `report`
work on results of this part: a line of fixed direction in a frame is a rigid beam with the orientation of the
frame, a beam is `PIECES` flexible ones along its deflected middle line, a spring a truss. Points that do not move in N
are supports. Points of which only the velocity is known have no place and are left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp
from sympy.core.function import AppliedUndef

from spacar.errors import UsageError
from spacar.symbolic.beam_shapes import X
from spacar.symbolic.reference_frames import ReferenceFrame
from spacar.symbolic.simulated_motion import SimulatedMotion
from spacar.symbolic.system import MultibodySystem
from spacar.symbolic.system_parts import Beam, CrossSection, GeometricPoint
from spacar.symbolic.transform import DirectionCosines, transform, turn_matrix
from spacar.symbolic.unit_vectors import TIME
from spacar.symbolic.vectors import Vector

PIECES = 6
CLASSES = {"rigid": 0, "bar": 0, "beam": 1, "spring": 2}  # of e: fixed, dynamic, calculable in the files


@dataclass
class _SkeletonLine:
    """An element: `rigid`, `beam` or `spring`; nodes are places in the lists of positions and orientations."""

    kind: str
    ends: tuple[int, int]
    turns: tuple[int, int] = (-1, -1)
    along: sp.Matrix | None = None  # direction in the frame of the first end


@dataclass
class _Parts:
    """Expressions of all nodes, and the elements between them."""

    system: MultibodySystem
    cosines: DirectionCosines = field(default_factory=DirectionCosines)
    positions: list[sp.Matrix] = field(default_factory=list)
    fixed: list[bool] = field(default_factory=list)
    orientations: list[sp.Matrix] = field(default_factory=list)
    lines: list[_SkeletonLine] = field(default_factory=list)
    _points: dict[GeometricPoint, int] = field(default_factory=dict)
    _frames: dict[ReferenceFrame, int] = field(default_factory=dict)

    def place(self, vector: Vector) -> int:
        N = self.system.N
        row = sp.Matrix([transform(vector & N[i], self.cosines) for i in (1, 2, 3)])
        self.positions.append(self.known(row))
        self.fixed.append(not vector.frames() - {N} and not row.atoms(AppliedUndef) and not row.has(TIME))
        return len(self.positions) - 1

    def known(self, row: sp.Matrix) -> sp.Matrix:
        return row.xreplace(self.system.pseudo_values())

    def point(self, point: GeometricPoint) -> int | None:
        """The node of a point; None when its place is not known."""
        if point.adrift:
            return None
        if point not in self._points:
            try:
                self._points[point] = self.place(point.position)
            except UsageError:  # an orientation that only its angular velocity describes
                return None
        return self._points[point]

    def orientation(self, frame: ReferenceFrame) -> int:
        if frame not in self._frames:
            self.orientations.append(self.known(self.cosines.matrix(self.system.N, frame)))
            self._frames[frame] = len(self.orientations) - 1
        return self._frames[frame]


def skeleton(system: MultibodySystem) -> _Parts:
    """The nodes and lines of a system."""
    parts = _Parts(system)
    for point in [system.O, *system.points]:
        end = parts.point(point)
        base = parts.point(point.base) if end is not None and point.base is not None else None
        if end is not None and base is not None and not isinstance(point, CrossSection):
            _link(parts, point, base, end)
    for beam in system.beams:
        _middle_line(parts, beam)
    for spring in system.springs:
        a, b = parts.point(spring.a), parts.point(spring.b)
        if a is not None and b is not None:
            parts.lines.append(_SkeletonLine("spring", (a, b)))
    return parts


def _link(parts: _Parts, point: GeometricPoint, base: int, end: int) -> None:
    """The line from the base of a point, unless it is part of the ground or has no length."""
    frames = point.offset.frames()
    if not frames - {parts.system.N}:
        return
    if len(frames) == 1:
        (frame,) = frames
        along = parts.cosines.components(point.offset, frame)
        if not along.atoms(AppliedUndef) and not along.has(TIME):
            turn = parts.orientation(frame)
            parts.lines.append(_SkeletonLine("rigid", (base, end), (turn, turn), along))
            return
    parts.lines.append(_SkeletonLine("bar", (base, end)))


def _middle_line(parts: _Parts, beam: Beam) -> None:
    """Stations from the root to the tip with the turned sections as orientations."""
    root = beam.root.position
    turn = parts.cosines.matrix(parts.system.N, beam.frame)
    start = parts.point(beam.root)
    if start is None:
        return
    nodes, turns = [], []
    for k in range(PIECES + 1):
        x = beam.length * k / PIECES
        offset = beam.offset.xreplace(beam.shape(x) | {X: x})
        at_root = k == 0 and all(c == 0 for c in parts.cosines.components(offset, beam.frame))
        tip = parts.point(beam.tip) if k == PIECES else None
        nodes.append(start if at_root else tip if tip is not None else parts.place(root + offset))
        section = turn
        for f in beam.fields:
            if f.kind != "stretch":
                slope = f.value(x, 1) if f.kind == "bending" else f.value(x)
                axis, angle = (1, slope) if f.kind == "twist" else (3, slope) if f.direction == 2 else (2, -slope)
                section = section * turn_matrix(axis, sp.cos(angle), sp.sin(angle))
        parts.orientations.append(parts.known(section))
        turns.append(len(parts.orientations) - 1)
    kind = "beam" if beam.fields else "rigid"
    for k in range(PIECES):
        ends, sections = (nodes[k], nodes[k + 1]), (turns[k], turns[k + 1])
        parts.lines.append(_SkeletonLine(kind, ends, sections, sp.Matrix([1, 0, 0])))


@dataclass(frozen=True)
class Picture:
    """Tables of a result file: `header` by identifier, and `x` (steps, nx)."""

    header: dict[str, Any]
    x: np.ndarray


def picture(system: MultibodySystem, run: SimulatedMotion, values: Mapping[str, float]) -> Picture | None:
    """The skeleton with numbers along a motion; None when there is nothing to be drawn.

    A place may need a parameter that the equations do not, and that has no value: then there is no picture either.
    """
    parts = skeleton(system)
    rows = [*parts.positions, *parts.orientations, *(line.along for line in parts.lines if line.along is not None)]
    atoms = {a for row in rows for a in row.atoms(AppliedUndef, sp.Symbol)} - {TIME}
    if not {_name(a) for a in atoms} <= {*values, *run.names, *run.input_names}:
        return None
    places = _numbers(parts.positions, run, values).reshape(len(run.time), -1, 3)
    turns = _numbers(parts.orientations, run, values).reshape(len(run.time), -1, 3, 3)
    if not places.shape[1]:
        return None
    planar = not places[..., 2].any() and (not turns.size or bool(np.all(turns[..., 2, 2] == 1.0)))
    if not (np.isfinite(places).all() and np.isfinite(turns).all()):
        return None
    masses = {n for body in system.bodies if (n := parts.point(body.point)) is not None}
    used = sorted({n for line in parts.lines for n in line.ends} | masses)
    if not used:
        return None
    columns = [sp.zeros(3, 1) if line.along is None else line.along for line in parts.lines]
    return _tables(parts, places, turns, planar, used, _numbers(columns, run, values)[0].reshape(-1, 3))


def _name(atom: Any) -> str:
    return str(atom.func) if isinstance(atom, AppliedUndef) else str(atom.name)


def _numbers(rows: list[sp.Matrix], run: SimulatedMotion, values: Mapping[str, float]) -> np.ndarray:
    """(steps, entries) of expressions; names of the model stay out of the text that is executed."""
    flat = [e for row in rows for e in row]
    atoms = sorted(set().union(*(e.atoms(AppliedUndef) | e.free_symbols for e in flat)) if flat else (), key=str)
    result = np.empty((len(run.time), len(flat)))
    known = {atom: sp.Symbol(f"v{k}") for k, atom in enumerate(atoms)}
    given = {name: np.full(len(run.time), value) for name, value in values.items()}
    columns = [run.time if a == TIME else given[_name(a)] if _name(a) in given else run[_name(a)] for a in atoms]
    function = sp.lambdify(list(known.values()), [e.xreplace(known) for e in flat], "numpy", cse=True)
    for k, column in enumerate(function(*columns)):
        result[:, k] = column
    return result


def _tables(
    parts: _Parts, places: np.ndarray, turns: np.ndarray, planar: bool, used: list[int], along: np.ndarray
) -> Picture:
    k, r, modes = (2, 1, 3) if planar else (3, 4, 6)
    used = sorted(used, key=lambda n: (not parts.fixed[n], n))  # fixed coordinates come first
    ends = {n: i + 1 for i, n in enumerate(used)}
    frames = sorted({t for line in parts.lines for t in line.turns if t >= 0})
    turning = {t: len(used) + i + 1 for i, t in enumerate(frames)}
    lnp = np.zeros((len(used) + len(frames), 4), int)
    lnp[: len(used), :k] = np.arange(len(used) * k).reshape(-1, k) + 1
    lnp[len(used) :, :r] = len(used) * k + np.arange(len(frames) * r).reshape(-1, r) + 1
    x = [places[:, used, :k].reshape(len(places), -1)]
    if planar:
        x.append(np.unwrap(np.arctan2(turns[:, frames, 1, 0], turns[:, frames, 0, 0]), axis=0))
    else:
        x.append(_euler_parameters(turns[:, frames]).reshape(len(places), -1))
    count = len(parts.lines)
    keywords, ln, stiff = [], np.zeros((count, 4), int), np.zeros((count, 6))
    start, kinds = np.zeros((count, 3, 3)), []
    length = np.array([np.linalg.norm(np.subtract(*places[0, list(line.ends)])) for line in parts.lines])
    for i, line in enumerate(parts.lines):
        beam = line.turns[0] >= 0
        keywords.append(("PL" if planar else "") + ("BEAM" if beam else "TRUSS"))
        p, q = (ends[n] for n in line.ends)
        ln[i] = (p, turning[line.turns[0]], q, turning[line.turns[1]]) if beam else (p, 0, q, 0)
        start[i] = _start_frame(along[i], planar) if beam else 0.0
        kinds += [(CLASSES[line.kind], i, m) for m in range(modes if beam else 1)]
        stiff[i, 0] = float(line.kind == "spring")
    le = np.zeros((count, 6), int)
    size = [sum(kind == c for kind, *_ in kinds) for c in range(3)]
    for number, (_, i, m) in enumerate(sorted(kinds), 1):
        le[i, m] = number
    fixed = sum(parts.fixed[n] for n in used) * k
    nx = int(lnp.max())
    header = {
        "ETYPE": keywords, "MODE": 1, "LNP": lnp, "LE": le, "LN": ln, "RXYZ": start.reshape(count, 9),
        "RQ": np.zeros((count, 9)), "RL0": length, "DR0": np.zeros((count, 1)), "STIF": stiff,
        "EDAMP": np.zeros((count, 6)), "KDEF": np.zeros(count, int), "NX": nx, "NE": len(kinds),
        "NXP": np.array([fixed, nx - fixed, 0, 0, 0]), "NEP": np.array([size[0], size[2], 0, size[1], 0]),
    }  # fmt: skip
    return Picture(header, np.concatenate(x, axis=1))


def _start_frame(along: np.ndarray, planar: bool) -> np.ndarray:
    """Rows x' along the line, y', z' of an element in the frame of its first end."""
    size = np.linalg.norm(along)
    first = along / size if size else np.array([1.0, 0.0, 0.0])
    aside = np.array([0.0, 0.0, 1.0]) if planar or abs(first[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    second = np.cross(aside, first)
    second /= np.linalg.norm(second)
    return np.array([first, second, np.cross(first, second)])


def _euler_parameters(R: np.ndarray) -> np.ndarray:
    """(…, 4) unit quaternions λ0..λ3 of rotation matrices (…, 3, 3), from their largest component."""
    from scipy.spatial.transform import Rotation as ScipyRotation

    found = ScipyRotation.from_matrix(R.reshape(-1, 3, 3)).as_quat()
    return np.roll(found, 1, axis=1).reshape(*R.shape[:-2], 4)
