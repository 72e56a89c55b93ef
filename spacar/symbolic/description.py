"""The description of a multibody system: coordinates, frames, points, bodies, loads, constraints, as lists of records.

Nothing is derived here. `system.MultibodySystem` adds beams, whose fields need coordinates of this description, and the
derivation. Source: `symbolic.md`, sections 3 and 6.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.beam_shapes import X
from spacar.symbolic.fields import Pseudo
from spacar.symbolic.model_names import ModelNames
from spacar.symbolic.reference_frames import Attitude, ReferenceFrame, dvdt, omega, set_omega
from spacar.symbolic.scalar_reader import read_expression, read_number
from spacar.symbolic.system_parts import (
    Beam,
    Constraint,
    DistributedLoad,
    FrameOrSection,
    GeometricPoint,
    Load,
    RigidBody,
    Spring,
    frame_at,
)
from spacar.symbolic.transform import transform
from spacar.symbolic.unit_vectors import TIME, AccelerationSymbols, ByExpression, Key, Rule, Scalars
from spacar.symbolic.vectors import ZERO, Dyad, Vector

_INERTIA = ((1, 1), (2, 2), (3, 3), (1, 2), (2, 3), (3, 1))


class Description:
    """What is written down of a system in the inertial frame `N` with origin `O`; see `system.MultibodySystem`."""

    def __init__(self, gravity: Any = (0, 0, 0), title: str = "") -> None:
        self.title = title
        self.names: dict[str, str] = {}
        self.parameters_declared: dict[str, sp.Symbol] | None = None
        self.N = ReferenceFrame("N", "n")
        self.O = GeometricPoint("O", None, ZERO, ZERO)
        self.coordinates: list[sp.Expr] = []
        self.speeds: list[sp.Expr] = []
        self.rates: Rule = {}
        self.accelerations: AccelerationSymbols = {}
        self.pseudo: list[Pseudo] = []
        self.quaternions: list[Scalars] = []
        self.inputs: dict[sp.Symbol, sp.Expr | None] = {}
        self.points: list[GeometricPoint] = []
        self.bodies: list[RigidBody] = []
        self.beams: list[Beam] = []
        self.loads: list[Load] = []
        self.distributed_loads: list[DistributedLoad] = []
        self.springs: list[Spring] = []
        self.constraints: list[Constraint] = []
        self.gravity = gravity if isinstance(gravity, Vector) else self.vector(gravity, self.N)

    # -- names and scalars -------------------------------------------------------------------------------------

    def claim(self, name: str, what: str) -> None:
        """Reserve a name. Programs may not distinguish case, so names that differ only in case are refused."""
        other = self.names.get(name.lower())
        if other is not None:
            raise UsageError(
                f"the name of {what} is already that of {other} (names must differ in more than case)", "name"
            )
        self.names[name.lower()] = what

    def expression(self, value: Any, names: Mapping[str, sp.Expr] | None = None, outputs: bool = False) -> sp.Expr:
        """A scalar from a number, a SymPy expression, or a text; the one reader of model files and of Python.

        The names of a text: `model_names.py`, and `names`. Others are parameters, or an error where parameters are
        declared (`parameters_declared`). Decimal numbers are exact. Raises UsageError for anything that is no scalar.
        """
        if isinstance(value, str):
            unknown = None if self.parameters_declared is not None else _parameter
            value = read_expression(value, ModelNames(self, names or {}, outputs), unknown)
        elif isinstance(value, float):
            value = read_number(value)
        try:
            return sp.sympify(value, strict=True).xreplace(self.rates)
        except sp.SympifyError:
            raise UsageError(f"{value!r} is no expression: give a number, a text or a SymPy expression") from None

    def vector(self, components: Sequence[Any], frame: ReferenceFrame) -> Vector:
        """A vector from three measure numbers in a frame."""
        if not _is_list(components) or len(components) != 3:
            raise UsageError(f"a vector needs a list of 3 measure numbers, not {components!r}")
        return sum((self.expression(c) * frame[i] for i, c in enumerate(components, 1)), ZERO)

    def parameters(self, names: str) -> tuple[sp.Symbol, ...]:
        """Real symbols of constant parameters, from names separated by blanks.

        Raises UsageError for the name of time, or of a coordinate, speed or input.
        """
        moving = {str(f.func): "a coordinate or speed" for f in [*self.coordinates, *self.speeds]}
        moving |= {s.name: "an input" for s in self.inputs} | {"t": "time"}
        for name in names.split():
            if name in moving:
                raise UsageError(f"parameter {name}: this is the name of {moving[name]}", "name")
        return tuple(map(_parameter, names.split()))

    def coordinate(self, name: str, speed: str | None = None) -> Any:
        """A generalized coordinate q(t); with `speed` the pair (q, s) with q̇ = s, else give `kinematic` later."""
        self.claim(name, f"coordinate {name}")
        q = sp.Function(name, real=True)(TIME)
        self.coordinates.append(q)
        if speed is None:
            return q
        s = self.speed(speed)
        self.kinematic(q, s)
        return q, s

    def speed(self, name: str) -> sp.Expr:
        """A generalized speed s(t) that need not be the derivative of a coordinate."""
        self.claim(name, f"speed {name}")
        s = sp.Function(name, real=True)(TIME)
        self.speeds.append(s)
        self.accelerations[s] = sp.Symbol(f"{name}_dot", real=True)
        self.rates[s.diff(TIME)] = self.accelerations[s]
        return s

    def kinematic(self, coordinate: sp.Expr, rate: Any) -> None:
        """The kinematic equation q̇ = rate(q, s)."""
        self.rates[coordinate.diff(TIME)] = self.expression(rate)

    def input(self, name: str, expression: Any = None) -> sp.Symbol:
        """An input (force, torque, prescribed value): a symbol of its own in the equations.

        `expression` (state, time, parameters) feeds it in simulations; without it a function must be given there.
        """
        self.claim(name, f"input {name}")
        symbol = sp.Symbol(name, real=True)
        self.inputs[symbol] = None if expression is None else self.expression(expression)
        return symbol

    @property
    def time(self) -> sp.Symbol:
        """The symbol of time t."""
        return TIME

    @property
    def field_speeds(self) -> ByExpression:
        """{φ_k: dφ_k} of all beams."""
        return {q: s for beam in self.beams for q, s in zip(beam.coordinates, beam.speeds, strict=True)}

    def pseudo_values(self) -> ByExpression:
        """Pseudo-coordinates and pseudo-speeds as values of the assumed fields."""
        speeds = self.field_speeds
        values = {p.coordinate: p.value for p in self.pseudo}
        return values | {p.speed: p.rate(speeds) for p in self.pseudo}

    def ddt(self, frame: ReferenceFrame, value: Any) -> Any:
        """Time derivative from `frame` with the kinematic equations put in: q̇ -> speeds, ṡ -> acceleration symbols."""
        return dvdt(frame, value).xreplace(self.rates)

    # -- frames and points -------------------------------------------------------------------------------------

    def frame(
        self, name: str, parent: FrameOrSection, axis: int | str, angle: Any, symbol: str | None = None
    ) -> ReferenceFrame:
        """A frame turned about axis 1, 2 or 3 of its parent (a frame or a beam section) by `angle` [rad].

        A sequence as "321" or "zyx" turns about axes that move along, by as many angles: yaw, pitch and roll.
        """
        base = frame_at(parent)
        if isinstance(axis, str):
            return self._sequence(name, base, axis, angle, symbol)
        if axis not in (1, 2, 3):
            raise UsageError(f"frame {name}: axis must be 1, 2 or 3, not {axis!r}")
        turned = base.turned(name, axis, self.expression(angle), symbol)
        set_omega(base, turned, omega(base, turned).xreplace(self.rates))
        return turned

    def _sequence(self, name: str, base: ReferenceFrame, axes: str, angles: Any, symbol: str | None) -> ReferenceFrame:
        """Turns one after the other; the frames between are NAME_1, NAME_2."""
        numbers = [int(a) for a in axes.lower().translate(str.maketrans("xyz", "123")) if a in "123"]
        if not numbers or len(numbers) != len(axes) or any(a == b for a, b in pairwise(numbers)):
            raise UsageError(f"frame {name}: axis must be 1, 2, 3 or a sequence such as '321' or 'zyx', not {axes!r}")
        if len(numbers) == 1 and not _is_list(angles):
            return self.frame(name, base, numbers[0], angles, symbol)
        if not _is_list(angles) or len(angles) != len(numbers):
            raise UsageError(f"frame {name}: the sequence {axes} needs a list of {len(numbers)} angles, not {angles!r}")
        for k, (number, angle) in enumerate(zip(numbers, angles, strict=True), 1):
            last = k == len(numbers)
            base = self.frame(name if last else f"{name}_{k}", base, number, angle, symbol if last else None)
        return base

    def attitude(
        self, name: str, parent: FrameOrSection, quaternion: Any, speeds: Any, symbol: str | None = None
    ) -> ReferenceFrame:
        """A frame that may turn freely, by a quaternion (e0, e) and the angular velocity ω = Σ w_i b_i in its parent.

        `quaternion` and `speeds` are letters of new coordinates `e0` … `e3` and speeds `w1` … `w3`, or those themselves
        (4 and 3). Without singular position. The kinematic equations ė = ½ e∘(0, ω) keep |e|, and the direction
        cosines are those of e/|e|: whatever an integration does to |e| changes nothing that moves.

            R = 1 + (2/|e|²) (e0 ẽ + ẽ ẽ),   ẽ x = (e1, e2, e3) × x,   ė0 = −½ e·ω,   ė = ½ (e0 ω + e × ω)

        Source: theory-spatial.md, section 1.
        """
        base = frame_at(parent)
        if isinstance(quaternion, str):
            quaternion = [self.coordinate(f"{quaternion}{i}") for i in range(4)]
        if isinstance(speeds, str):
            speeds = [self.speed(f"{speeds}{i}") for i in (1, 2, 3)]
        if len(quaternion) != 4 or len(speeds) != 3:
            raise UsageError(f"frame {name}: a quaternion has 4 coordinates and 3 speeds")
        e0, e, w = quaternion[0], sp.Matrix(quaternion[1:]), sp.Matrix(speeds)
        for q, rate in zip(quaternion, [-e.dot(w) / 2, *((e0 * w + e.cross(w)) / 2)], strict=True):
            self.kinematic(q, rate)
        tilde = sp.Matrix([[0, -e[2], e[1]], [e[2], 0, -e[0]], [-e[1], e[0], 0]])
        scale = 2 / (e0**2 + e.dot(e))
        frame = ReferenceFrame(name, symbol)
        frame.attitude = Attitude(base, sp.eye(3) + scale * (e0 * tilde + tilde * tilde))
        set_omega(base, frame, sum((s * frame[i] for i, s in enumerate(speeds, 1)), ZERO))
        self.quaternions.append(tuple(quaternion))
        return frame

    def point(
        self, name: str, base: GeometricPoint, offset: Vector = ZERO, velocity: Vector | None = None
    ) -> GeometricPoint:
        """The point at `offset` from `base`; `velocity` in N may be given when the constraints of speeds are known."""
        offset, given = self._demand_vector(f"point {name}: offset", offset), velocity is not None
        if given:
            velocity = self._demand_vector(f"point {name}: velocity", velocity)
        else:
            velocity = base.velocity + self.ddt(self.N, offset)
        self.points.append(GeometricPoint(name, base, offset, velocity, given))
        return self.points[-1]

    def _demand_vector(self, what: str, value: Any) -> Vector:
        """With the kinematic equations put in. UsageError for what is no vector."""
        if not isinstance(value, Vector):
            raise UsageError(f"{what} must be a vector such as 2*N[1], not {value!r}")
        return value.xreplace(self.rates)

    # -- bodies ------------------------------------------------------------------------------------------------

    def particle(self, name: str, point: GeometricPoint, mass: Any) -> RigidBody:
        """A mass point."""
        return self._add_body(RigidBody(name, point, self.expression(mass)))

    def rigid_body(
        self, name: str, frame: FrameOrSection, at: GeometricPoint, mass: Any, inertia: Any = None
    ) -> RigidBody:
        """A rigid body with mass centre `at`, fixed in `frame`.

        `inertia`: central inertia dyad, or (I11, I22, I33[, I12, I23, I31]) in `frame` [kg m²].
        """
        frame = frame_at(frame)
        if not isinstance(inertia, Dyad):
            if inertia is not None and not _is_list(inertia):
                raise UsageError(f"body {name}: inertia must be a dyad or 3 or 6 numbers, not {inertia!r}", "inertia")
            numbers = [self.expression(value) for value in (() if inertia is None else inertia)]
            if len(numbers) not in (0, 3, 6):
                raise UsageError(f"body {name}: inertia needs 3 or 6 numbers, not {len(numbers)}", "inertia")
            dyad = Dyad()
            for (i, j), value in zip(_INERTIA, numbers, strict=False):
                for p, q in sorted({(i, j), (j, i)}):
                    dyad += (frame[p] | frame[q]) * value
            inertia = dyad
        return self._add_body(RigidBody(name, at, self.expression(mass), frame, inertia))

    def _add_body(self, body: RigidBody) -> RigidBody:
        self.claim(body.name, f"body {body.name}")
        self.bodies.append(body)
        return body

    # -- loads and constraints ---------------------------------------------------------------------------------

    def force(self, point: GeometricPoint, vector: Vector) -> None:
        """A force on a point."""
        self.loads.append(Load(self._demand_vector("force", vector), point=point))

    def torque(
        self, frame: FrameOrSection, vector: Vector,
        reaction: FrameOrSection | None = None,
    ) -> None:  # fmt: skip
        """A torque on a frame, with the opposite torque on the frame `reaction`. A motor at a tip reacts on the tip."""
        by = None if reaction is None else frame_at(reaction)
        self.loads.append(Load(self._demand_vector("torque", vector), frame=frame_at(frame), reaction=by))

    def distributed(self, beam: Beam, vector: Vector) -> None:
        """A force per length [N/m] on the middle line of a beam; its measure numbers may depend on `x` along the beam,
        as polynomials, and on states and time. Source: (B) of `held.py`, f."""
        parts: dict[sp.Expr, list[tuple[Key, sp.Expr]]] = {}
        for key, c in self._demand_vector(f"load on beam {beam.name}", vector).terms.items():
            for term in sp.Add.make_args(sp.expand(c)):
                factor, along = term.as_independent(X, as_Add=False)
                if not along.is_polynomial(X):
                    raise UsageError(f"load on beam {beam.name}: {along} is not a polynomial in x", "field")
                parts.setdefault(along, []).append((key, factor))
        loads = tuple((Vector.collect(terms), along) for along, terms in parts.items())
        self.distributed_loads.append(DistributedLoad(beam, loads))

    def spring(self, a: GeometricPoint, b: GeometricPoint, stiffness: Any, length: Any = 0, damping: Any = 0) -> None:
        """A linear spring with a damper between two points; `length` is the length without force."""
        line = b.position - a.position
        now = sp.sqrt(sp.expand(line & line))
        stretching = (line & (b.velocity - a.velocity)) / now
        k, rest, c = (self.expression(value) for value in (stiffness, length, damping))
        self.springs.append(Spring(a, b, k, rest, c, now, stretching, line / now))

    def constraint(self, expression: Any, name: str | None = None) -> sp.Symbol:
        """A constraint expression = 0: linear in the speeds, or without speeds (a position constraint).

        Time and prescribed coefficients may occur. Returns its force λ (the generalized forces are Jᵀ λ), a symbol for
        outputs. The λ of a velocity component along e is the force along e. Raises UsageError when the expression
        restricts nothing.
        """
        if isinstance(expression, Vector):
            raise UsageError("a constraint is a scalar: take the component of the vector along a direction (&)")
        name = name or f"constraint{len(self.constraints) + 1}"
        e = self.expression(expression)
        moving = [*self.speeds, *(p.speed for p in self.pseudo)]
        position = None if e.has(*moving) else e
        velocity = e if position is None else self.ddt(self.N, e)
        if not velocity.has(*moving):
            raise UsageError(f"{name}: {e} = 0 contains no coordinate or speed, so it constrains nothing", "constraint")
        self.claim(name, f"constraint {name}")
        force = sp.Symbol(f"{name}_force", real=True)
        self.claim(force.name, f"force of constraint {name}")
        self.constraints.append(Constraint(name, velocity, position, force))
        return force

    def close(
        self, a: GeometricPoint, b: GeometricPoint, directions: Any = None, name: str | None = None
    ) -> tuple[sp.Symbol, ...]:
        """Close a loop: points `a` and `b` coincide along `directions` (unit vectors; default all three of N).

        Directions in which the points coincide in every configuration, as out of the plane of a planar mechanism, are
        left out. Start values are assembled and the loop is kept closed by projection. Returns the forces of `b` on
        `a`, one for each direction that is closed. Raises UsageError when nothing or nothing movable is to be closed.
        """
        name = name or f"close{sum('close' in c.name for c in self.constraints) + 1}"
        wanted = [self.N[i] for i in (1, 2, 3)] if directions is None else directions
        wanted = [wanted] if isinstance(wanted, Vector) else list(wanted)
        gap = a.position - b.position
        open_ones: list[tuple[int, sp.Expr]] = []
        for number, direction in enumerate(wanted, 1):
            if not isinstance(direction, Vector):
                raise UsageError(f"{name}: a direction must be a vector such as N[1], not {direction!r}", "constraint")
            distance = sp.expand(gap & direction)
            if sp.expand(transform(distance)) != 0:
                open_ones.append((number, distance))
        if not open_ones:
            raise UsageError(f"{name}: the points coincide in every configuration already", "constraint")
        return tuple(self.constraint(d, name if len(open_ones) == 1 else f"{name}_{number}") for number, d in open_ones)

    def all_loads(self) -> list[Load]:
        return [*self.loads, *(load for spring in self.springs for load in spring.loads())]


def _is_list(value: Any) -> bool:
    return hasattr(value, "__len__") and not isinstance(value, str)


def _parameter(name: str) -> sp.Symbol:
    return sp.Symbol(name, real=True)
