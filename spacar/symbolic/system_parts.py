"""The parts of a system as records: points, sections, beams, bodies, loads. They hold, they do not compute."""

from __future__ import annotations

from dataclasses import dataclass, field

import sympy as sp

from spacar.symbolic.beam_shapes import X, integral
from spacar.symbolic.fields import Field, Foreshortening
from spacar.symbolic.reference_frames import ReferenceFrame
from spacar.symbolic.unit_vectors import AccelerationSymbols, Rule, Scalars
from spacar.symbolic.vectors import ZERO, Dyad, Vector


@dataclass(frozen=True, eq=False)
class GeometricPoint:
    """A point at `offset` from `base`. `velocity` (in N) was given by the user when `given` is set."""

    name: str
    base: GeometricPoint | None
    offset: Vector
    velocity: Vector
    given: bool = False

    @property
    def position(self) -> Vector:
        """Vector from the origin."""
        return self.offset if self.base is None else self.base.position + self.offset

    @property
    def adrift(self) -> GeometricPoint | None:
        """The nearest point on the way to the origin of which only the velocity is known; None: the place is known."""
        if self.base is None:
            return None
        return self if self.given and self.base.base is None and not self.offset else self.base.adrift


@dataclass(frozen=True, eq=False)
class CrossSection(GeometricPoint):
    """A cross-section of a beam: a point with a frame of its own, and the values of the fields there.

    `u`, `w` deflections, `slope`, `slope_w` their derivatives to x, `twist`, `stretch`; zero when there is no field.
    """

    frame: ReferenceFrame = field(default_factory=lambda: ReferenceFrame("section"))
    values: dict[str, sp.Expr] = field(default_factory=dict)

    def __getattr__(self, name: str) -> sp.Expr:
        values = object.__getattribute__(self, "values")
        if name in ("u", "w", "slope", "slope_w", "twist", "stretch"):
            return values.get(name, sp.S.Zero)
        raise AttributeError(name)


FrameOrSection = ReferenceFrame | CrossSection


def frame_at(place: FrameOrSection) -> ReferenceFrame:
    """A frame, or that of a cross-section."""
    return place.frame if isinstance(place, CrossSection) else place


@dataclass(frozen=True, eq=False)
class Beam:
    """A beam along axis 1 of `frame` from `root`; mass per length, length, fields, damping.

    `offset` is the vector from the root to the mass point x in field symbols u(x, t).
    """

    name: str
    frame: ReferenceFrame
    root: GeometricPoint
    length: sp.Expr
    mass: sp.Expr
    polar: sp.Expr
    damping: sp.Expr
    damping_boundary: bool
    fields: tuple[Field, ...]
    shortening: Foreshortening | None
    offset: Vector
    sections: dict[sp.Expr, CrossSection] = field(default_factory=dict)

    @property
    def tip(self) -> CrossSection:
        return self.sections[self.length]

    @property
    def total_mass(self) -> sp.Expr:
        """∫ρ dx [kg]."""
        return integral(self.mass, X, self.length)

    @property
    def parts(self) -> tuple[Field | Foreshortening, ...]:
        """What is assumed along it: fields, and their foreshortening."""
        return (*self.fields, self.shortening) if self.shortening else self.fields

    def assumed(self, accelerations: AccelerationSymbols) -> Rule:
        """The assumed fields in the place of u(x, t) and its derivatives."""
        return {symbol: value for part in self.parts for symbol, value in part.substitution(accelerations).items()}

    def shape(self, x: sp.Expr) -> Rule:
        """The values of the fields at x in the place of u(x, t)."""
        return {part.function: part.value(x) for part in self.parts}

    @property
    def modes(self) -> list[tuple[Field, sp.Expr, sp.Expr, sp.Expr]]:
        """(field, φ_k, dφ_k, ψ_k) of every shape."""
        return [(f, *mode) for f in self.fields for mode in zip(f.coordinates, f.speeds, f.shapes, strict=True)]

    @property
    def coordinates(self) -> Scalars:
        return tuple(q for f in self.fields for q in f.coordinates)

    @property
    def speeds(self) -> Scalars:
        return tuple(s for f in self.fields for s in f.speeds)


@dataclass(frozen=True, eq=False)
class RigidBody:
    """A rigid body or particle: mass [kg] at its mass centre `point`, central inertia dyad [kg m²] (0: particle)."""

    name: str
    point: GeometricPoint
    mass: sp.Expr
    frame: ReferenceFrame | None = None
    inertia: Dyad = field(default_factory=Dyad)


@dataclass(frozen=True, eq=False)
class Load:
    """A force [N] at a point, or a torque [N m] on a frame with its reaction on another frame (or None)."""

    vector: Vector
    point: GeometricPoint | None = None
    frame: ReferenceFrame | None = None
    reaction: ReferenceFrame | None = None

    @property
    def turned(self) -> list[tuple[ReferenceFrame, int]]:
        """The frames that the torque turns, with its sign."""
        return [(frame, sign) for frame, sign in ((self.frame, 1), (self.reaction, -1)) if frame is not None]


@dataclass(frozen=True, eq=False)
class DistributedLoad:
    """A force per length [N/m] on a beam: Σ vector · g(x) of `parts`, the vectors without x."""

    beam: Beam
    parts: tuple[tuple[Vector, sp.Expr], ...]

    @property
    def vector(self) -> Vector:
        """The force per length as a function of x."""
        return sum((v * g for v, g in self.parts), ZERO)


@dataclass(frozen=True, eq=False)
class Spring:
    """A linear spring and damper between two points: force k (l − l0) + c l̇ along the line that joins them."""

    a: GeometricPoint
    b: GeometricPoint
    stiffness: sp.Expr
    rest: sp.Expr
    damping: sp.Expr
    length: sp.Expr
    lengthening: sp.Expr
    direction: Vector

    def energy(self) -> sp.Expr:
        return self.stiffness * (self.length - self.rest) ** 2 / 2

    def loads(self) -> tuple[Load, Load]:
        tension = self.stiffness * (self.length - self.rest) + self.damping * self.lengthening
        return Load(self.direction * tension, self.a), Load(-self.direction * tension, self.b)


@dataclass(frozen=True, eq=False)
class Constraint:
    """velocity = 0, linear in the speeds; for a position constraint `position` = 0 too. `force` is its λ."""

    name: str
    velocity: sp.Expr
    position: sp.Expr | None
    force: sp.Symbol
