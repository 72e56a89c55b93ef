"""The recursion of strategy `recursive`: what is known of frames and points, body by body, in Z variables.

W_r, V_r are partial (angular) velocities, w, a0, al0 angular velocity and bias accelerations, all in the frame of the
body. Gravity enters once as base acceleration −g. Formulas: `symbolic.md`, section 4.4; beams: `recursive_beam.py`.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import sympy as sp

from spacar.symbolic.collect import ZTable, gather_scalars
from spacar.symbolic.description import Description
from spacar.symbolic.reference_frames import ReferenceFrame, omega, rate
from spacar.symbolic.system_parts import GeometricPoint, Load, RigidBody
from spacar.symbolic.transform import DirectionCosines, merged_rotation, transform
from spacar.symbolic.unit_vectors import ByExpression, Definitions, Unit
from spacar.symbolic.vectors import Vector

Column: TypeAlias = Any  # sympy Matrix of three measure numbers
Partials: TypeAlias = dict[sp.Expr, Column]  # by speeds
NOTHING = sp.zeros(3, 1)


@dataclass(frozen=True)
class FrameMotion:
    """A frame in its own components: partial angular velocities {speed: column}, angular velocity and its bias rate."""

    partials: Partials
    velocity: Column
    bias: Column


@dataclass(frozen=True)
class PointMotion:
    """A point: partial velocities and bias acceleration (−g included) in the components of `frame`."""

    frame: ReferenceFrame
    partials: Partials
    bias: Column


@dataclass
class Sums:
    """Upper triangle of I and f while they are added up."""

    speeds: list[sp.Expr]
    mass: dict[tuple[int, int], list[sp.Expr]] = field(default_factory=lambda: defaultdict(list))
    force: dict[int, list[sp.Expr]] = field(default_factory=lambda: defaultdict(list))

    def add_mass(self, r: sp.Expr, k: sp.Expr, value: sp.Expr) -> None:
        i, j = sorted((self.speeds.index(r), self.speeds.index(k)))
        self.mass[i, j].append(value)

    def add_squares(
        self, partials: Partials, momentum: Callable[[Column], Column]
    ) -> Partials:
        """Add momentum(V_r)·V_k of all pairs of speeds; the momenta."""
        momenta = {}
        for r, V in partials.items():
            momenta[r] = momentum(V)
            for k, U in partials.items():
                if self.speeds.index(k) >= self.speeds.index(r):
                    self.add_mass(r, k, momenta[r].dot(U))
        return momenta

    def add_force(self, r: sp.Expr, value: sp.Expr) -> None:
        self.force[self.speeds.index(r)].append(value)


class Recursion:
    """The state of the recursion for one system: what is known of every frame and point."""

    def __init__(self, system: Description) -> None:
        self.system = system
        self.table = ZTable(forbidden=system.accelerations.values())
        self.cosines = DirectionCosines(self.table)
        self.at_rest = dict.fromkeys(system.accelerations.values(), sp.S.Zero)
        self.field_speed = system.field_speeds
        self.values: ByExpression = {}
        self.slopes: dict[sp.Expr, ByExpression] = {}
        self.slope_rates: Definitions = {}
        for p in system.pseudo:
            gradient = {self.field_speed[q]: self.read(g) for q, g in p.gradient.items()}
            speed = sp.Add(*(g * s for s, g in gradient.items()))
            self.values[p.coordinate] = self.table.read(gather_scalars(p.value), name=str(p.coordinate.func))
            self.values[p.speed] = self.table.read(speed, name=str(p.speed.func))
            self.slopes[p.speed] = gradient
            self.slope_rates[system.accelerations[p.speed]] = self.read(p.bias(self.field_speed))
        self.frames = {system.N: FrameMotion({}, NOTHING, NOTHING)}
        gravity = self.cosines.components(system.gravity, system.N)
        self.points: dict[tuple[GeometricPoint, ReferenceFrame], PointMotion] = {
            (system.O, system.N): PointMotion(system.N, {}, (-gravity).applyfunc(self.read))
        }

    # -- scalars -----------------------------------------------------------------------------------------------

    def read(self, expression: sp.Expr) -> sp.Expr:
        """A memory read of a scalar: dots become cosines, pseudo-coordinates field values."""
        return self.table.read(transform(expression, self.cosines).xreplace(self.values))

    def reads(self, column: Column) -> Column:
        return column.applyfunc(self.read)

    def partials(self, expression: sp.Expr) -> ByExpression:
        """∂expression/∂(every speed), pseudo-speeds resolved into field speeds."""
        result = {s: self.read(expression.diff(s)) for s in self.system.speeds if expression.has(s)}
        for p, gradient in self.slopes.items():
            if expression.has(p):
                factor = self.read(expression.diff(p))
                for s, g in gradient.items():
                    result[s] = result.get(s, sp.S.Zero) + factor * g
        return result

    def columns(self, vector: Column) -> Partials:
        """∂vector/∂(every speed)."""
        found: Partials = {}
        for i, component in enumerate(vector):
            for s, value in self.partials(component).items():
                found.setdefault(s, sp.zeros(3, 1))[i] = value
        return found

    def added(self, partials: Partials, more: Partials) -> Partials:
        """The sum of partial velocities."""
        return partials | {s: self.reads(partials.get(s, NOTHING) + column) for s, column in more.items()}

    def bias(self, expression: sp.Expr) -> sp.Expr:
        """Time derivative of a velocity expression with all accelerations of independent speeds zero."""
        derivative = rate(expression).xreplace(self.system.rates).xreplace(self.slope_rates).xreplace(self.at_rest)
        return self.read(derivative)

    # -- frames ------------------------------------------------------------------------------------------------

    def turn(self, frame: ReferenceFrame) -> tuple[ReferenceFrame, sp.Matrix]:
        """The base of a frame and the matrix that brings components in the base into the frame."""
        base, _, _ = merged_rotation(frame)
        return base, self.cosines.matrix(base, frame).xreplace(self.values).T

    def frame(self, frame: ReferenceFrame) -> FrameMotion:
        """Angular motion of a frame, in its own components."""
        if frame not in self.frames:
            self.frames[frame] = self._turning(frame)
        return self.frames[frame]

    def _turning(self, frame: ReferenceFrame) -> FrameMotion:
        """That of its base and its own; N is the base of a frame of which only the angular velocity is known."""
        if frame.rotation is not None:
            base, R = self.turn(frame)
            _, axis, _ = merged_rotation(frame)
            relative = sp.Add(*omega(base, frame).terms.values()) * sp.eye(3)[:, axis - 1]
        else:
            base, R = self.system.N, sp.eye(3)
            if frame.attitude is not None:
                base = frame.attitude.parent
                R = self.cosines.matrix(frame, base).xreplace(self.values)
            relative = self.cosines.components(omega(base, frame), frame)
        parent = self.frame(base)
        partials = {r: self.reads(R * W) for r, W in parent.partials.items()}
        w0 = self.reads(R * parent.velocity)
        partials = self.added(partials, self.columns(relative))
        spin = self.reads(relative)
        al0 = self.reads(R * parent.bias + w0.cross(spin) + relative.applyfunc(self.bias))
        return FrameMotion(partials, self.reads(w0 + spin), al0)

    # -- points ------------------------------------------------------------------------------------------------

    def point(self, point: GeometricPoint, frame: ReferenceFrame) -> PointMotion:
        """Motion of a point, in the components of `frame`."""
        if (point, frame) not in self.points:
            home = self._home(point)
            if (point, home) not in self.points:
                self.points[point, home] = self._own(point, home)
            self.points[point, frame] = self._express(self.points[point, home], frame)
        return self.points[point, frame]

    def _home(self, point: GeometricPoint) -> ReferenceFrame:
        """The frame in which a point is easiest to describe: that of its offset."""
        if point is self.system.O:
            return self.system.N
        frames = (point.velocity if point.given else point.offset).frames()
        if frames:
            return max(frames, key=lambda f: f.serial)
        return self.system.N if point.base is None else self._home(point.base)

    def _own(self, point: GeometricPoint, home: ReferenceFrame) -> PointMotion:
        if point.given:
            return self._given(point, home)
        assert point.base is not None
        here = self.point(point.base, self._home(point.base))
        pieces: dict[ReferenceFrame, Column] = {}
        for key, c in point.offset.terms.items():
            frame = key.frame if isinstance(key, Unit) else home
            pieces[frame] = pieces.get(frame, NOTHING) + self.cosines.components(Vector({key: c}), frame)
        for frame in sorted(pieces, key=lambda f: f.serial):
            here = self._shift(self._express(here, frame), pieces[frame])
        return self._express(here, home)

    def _shift(self, here: PointMotion, offset: Column) -> PointMotion:
        """From a point to another at `offset`, in the components of the same frame."""
        turning = self.frame(here.frame)
        velocity = offset.applyfunc(lambda c: rate(c).xreplace(self.system.rates))
        r, rdot = self.reads(offset), self.reads(velocity)
        partials = self.added(here.partials, {s: W.cross(r) for s, W in turning.partials.items()})
        partials = self.added(partials, self.columns(velocity))
        w, al0 = turning.velocity, turning.bias
        wr = self.reads(w.cross(r))
        own = velocity.applyfunc(self.bias)
        return PointMotion(
            here.frame, partials, self.reads(here.bias + al0.cross(r) + w.cross(wr) + 2 * w.cross(rdot) + own)
        )

    def _given(self, point: GeometricPoint, home: ReferenceFrame) -> PointMotion:
        """A point whose velocity in N was given."""
        v = self.cosines.components(point.velocity, home)
        partials = self.columns(v)
        gravity = self.cosines.components(self.system.gravity, home)
        w = self.frame(home).velocity
        own = v.applyfunc(self.bias)
        return PointMotion(home, partials, self.reads(own + w.cross(self.reads(v)) - gravity.xreplace(self.values)))

    def _express(self, here: PointMotion, frame: ReferenceFrame) -> PointMotion:
        if here.frame is frame:
            return here
        if frame.rotation is not None and _is_ancestor(here.frame, frame):
            base, R = self.turn(frame)
            here = self._express(here, base)
        else:
            R = self.cosines.matrix(frame, here.frame).xreplace(self.values)
        return PointMotion(frame, {s: self.reads(R * V) for s, V in here.partials.items()}, self.reads(R * here.bias))

    # -- bodies and loads --------------------------------------------------------------------------------------

    def body(self, body: RigidBody, sums: Sums) -> None:
        frame = body.frame or self._home(body.point)
        at = self.point(body.point, frame)
        for r, mV in sums.add_squares(at.partials, lambda V: self.reads(body.mass * V)).items():
            sums.add_force(r, -mV.dot(at.bias))
        if body.frame is None or not body.inertia:
            return
        turning = self.frame(frame)
        J = sp.zeros(3, 3)
        for (p, q), c in body.inertia.terms.items():
            left, right = (self.cosines.components(Vector({k: 1}), frame) for k in (p, q))
            J += c * left * right.T
        J = self.reads(J)
        torque = self.reads(J * turning.bias + turning.velocity.cross(self.reads(J * turning.velocity)))
        sums.add_squares(turning.partials, lambda W: self.reads(J * W))
        for r, W in turning.partials.items():
            sums.add_force(r, -W.dot(torque))

    def load(self, load: Load, sums: Sums) -> None:
        """Generalized forces of a force at a point, or of a torque and its reaction."""
        targets: list[tuple[ReferenceFrame, Partials, int]] = []
        if load.point is not None:
            home = self._home(load.point)
            targets.append((home, self.point(load.point, home).partials, 1))
        targets += [(frame, self.frame(frame).partials, sign) for frame, sign in load.turned]
        for frame, partials, sign in targets:
            vector = self.reads(self.cosines.components(load.vector, frame))
            for r, column in partials.items():
                sums.add_force(r, sign * column.dot(vector))


def _is_ancestor(ancestor: ReferenceFrame, frame: ReferenceFrame) -> bool:
    while frame.rotation is not None:
        frame, _, _ = merged_rotation(frame)
        if frame is ancestor:
            return True
    return False
