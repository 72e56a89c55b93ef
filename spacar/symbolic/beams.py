"""Beams with assumed fields and their sections.

The mass point x of a beam is at (x + e − w) b1 + u b2 + w b3, its section turned by u_x about b3, −w_x about b2 and
θ about b1 (in this order; exact rotations by small angles). At a section the fields become pseudo-coordinates with
pseudo-speeds. Source: the paper, (5), (6), (10); `symbolic.md`, sections 3.3, 3.4, 8.7.
"""

from typing import Any

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.beam_shapes import X, field_function, shape_functions
from spacar.symbolic.description import Description
from spacar.symbolic.fields import Field, Foreshortening, Pseudo
from spacar.symbolic.reference_frames import ReferenceFrame
from spacar.symbolic.system_parts import Beam, CrossSection, GeometricPoint
from spacar.symbolic.unit_vectors import TIME
from spacar.symbolic.vectors import ZERO, Vector

DEFAULT_SHAPES = 3


def make_beam(
    system: Description,
    name: str,
    frame: ReferenceFrame,
    root: GeometricPoint,
    length: Any,
    mass: Any,
    *,
    EI: Any = None,
    bends: int | tuple[int, ...] = 2,
    field: Any = None,
    damping: Any = 0,
    damping_boundary: bool = True,
    foreshortening: bool | None = None,
    twist: Any = (),
    GJ: Any = 0,
    polar: Any = 0,
    stretch: Any = (),
    EA: Any = 0,
) -> Beam:
    """A beam of `length` [m] and `mass` per length [kg/m].

    bends: 2, 3 or (2, 3), the unit vectors of deflection; EI [N m²] and `field` (shape family, number of default
    shapes, or expressions in x; () for none) then one each or one for both. damping: γ [N s] of the paper, in every
    bending field, with its natural boundary condition unless damping_boundary=False. foreshortening: None means yes
    for default shapes and no for shapes that are written out, as in the paper. twist, GJ [N m²], polar moment of
    inertia per length [kg m]; stretch, EA [N]. mass, EI, GJ, EA and polar may depend on x (a tapered beam). Raises
    UsageError for shapes that violate the conditions at the root.
    """
    system.claim(name, f"beam {name}")
    length, damping = system.expression(length), system.expression(damping)
    mass, polar = (along(system, value) for value in (mass, polar))
    directions = (bends,) if isinstance(bends, int) else tuple(bends)
    if not directions or not set(directions) <= {2, 3} or len(set(directions)) != len(directions):
        raise UsageError(f"beam {name}: bends must be 2, 3 or both, not {bends!r}")
    if foreshortening is None:
        foreshortening = field is None or isinstance(field, int)
    number = len(system.beams) + 1
    made: list[Field] = []

    def add(kind: str, letter: str, direction: int, shapes_of: Any, stiffness: Any, clamped: int) -> None:
        shapes = shape_functions(shapes_of, length, clamped)
        if not shapes:
            return
        done = sum(len(f.shapes) for f in made)
        names = [f"phi{number}_{done + k}" for k in range(1, len(shapes) + 1)]
        pairs = [system.coordinate(name, speed=f"d{name}") for name in names]
        coordinates, speeds = zip(*pairs, strict=True)
        function = field_function(f"{letter}{number}")
        made.append(Field(letter, kind, direction, function, shapes, coordinates, speeds, along(system, stiffness)))

    fields = field if len(directions) == 2 and isinstance(field, (tuple, list)) and len(field) == 2 else None
    stiffnesses = EI if isinstance(EI, (tuple, list)) else (EI,) * len(directions)
    for i, direction in enumerate(directions):
        shapes = fields[i] if fields else (DEFAULT_SHAPES if field is None else field)
        if EI is None and shapes != ():
            raise UsageError(f"beam {name}: bending needs EI (or field = () for a rigid beam)")
        add("bending", "u" if i == 0 else "w", direction, shapes, 0 if EI is None else stiffnesses[i], 2)
    add("twist", "theta", 1, twist, GJ, 1)
    add("stretch", "e", 1, stretch, EA, 1)
    bending = tuple(f for f in made if f.kind == "bending")
    shortening = (
        Foreshortening(field_function(f"shortening{number}"), bending, length) if foreshortening and bending else None
    )
    offset = X * frame[1] + sum((f.function * frame[f.direction] for f in made if f.kind != "twist"), ZERO)
    if shortening:
        offset -= shortening.function * frame[1]
    beam = Beam(name, frame, root, length, mass, polar, damping, damping_boundary, tuple(made), shortening, offset)
    make_section(system, beam, length)
    return beam


def along(system: Description, value: Any) -> sp.Expr:
    """A property that may depend on x, the coordinate along the beam."""
    return system.expression(value, {"x": X}).xreplace({sp.Symbol("x"): X})


def make_section(system: Description, beam: Beam, x: sp.Expr) -> CrossSection:
    """The section at x, made once: pseudo-coordinates for the values of the fields there, a point and a frame."""
    if x in beam.sections:
        return beam.sections[x]
    label = beam.name if x == beam.length else f"{beam.name}_{len(beam.sections)}"
    pseudo: dict[str, sp.Expr] = {}

    def add(letters: str, part: Field | Foreshortening, *derivative: int) -> sp.Expr:
        names = f"{label}_{letters}", f"{label}_{letters}t"
        for name, what in zip(names, ("pseudo-coordinate", "pseudo-speed"), strict=True):
            system.claim(name, f"{what} {name}")
        q, s = (sp.Function(name, real=True)(TIME) for name in names)
        system.accelerations[s] = sp.Symbol(f"{names[1]}_dot", real=True)
        system.rates |= {q.diff(TIME): s, s.diff(TIME): system.accelerations[s]}
        system.pseudo.append(Pseudo(q, s, part.value(x, *derivative), part.gradient(x, *derivative)))
        pseudo[letters] = q
        return q

    offset = x * beam.frame[1]
    turns: list[tuple[int, sp.Expr]] = []
    for f in beam.fields:
        q = add(f.name, f)
        if f.kind == "twist":
            turns.append((1, q))
            continue
        offset += q * beam.frame[f.direction]
        if f.kind == "bending":
            slope = add(f"{f.name}x", f, 1)
            turns.append((3, slope) if f.direction == 2 else (2, -slope))
    if beam.shortening:
        offset -= add("short", beam.shortening) * beam.frame[1]
    frame = beam.frame
    for i, (axis, angle) in enumerate(turns):
        suffix = "tip" if x == beam.length else f"section{len(beam.sections)}"
        name = f"{beam.name}.{suffix}" + ("" if len(turns) == 1 else f".{i + 1}")
        frame = system.frame(name, frame, axis, angle, symbol=f"{beam.frame.symbol}t")
        frame.is_section = True
    velocity: Vector = beam.root.velocity + system.ddt(system.N, offset)
    public = {"u": "u", "w": "w", "slope": "ux", "slope_w": "wx", "twist": "theta", "stretch": "e"}
    values = {name: pseudo[key] for name, key in public.items() if key in pseudo}
    section = CrossSection(
        f"{beam.name}.tip" if x == beam.length else f"{label}", beam.root, offset, velocity, False, frame, values
    )
    beam.sections[x] = section
    return section
