"""Checks of the reference configuration: X, lengths, directions, ORPINBOD."""

from collections.abc import Iterable
from itertools import chain, repeat
from math import asin, degrees, dist, hypot, inf

from spacar.deck.check_material import CheckMaterial
from spacar.deck.statement import Statement, StatementGroup
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import ElementType

ZERO_LENGTH = 1e-8
"""A length below this part of the size of the model is zero: a chosen bound, for the digits of a file."""
PARALLEL = 1e-5
"""Two directions with a smaller sine are parallel (the public routine refuses the same sine)."""
SMALLEST_PRODUCT = 1e-290
"""Products above it are normal numbers, with relative errors of a rounding."""

Vector = tuple[float, ...]
_WITH_RADII = ("PLWHEEL", "TWHEEL", "PLBELT")
ORIGIN = (0.0, 0.0, 0.0)  # of a node without X


def least_length(s: Statement) -> float:
    """The chord of an element must be longer [m]: pulleys of a belt that lie in each other have no free belt."""
    return abs(s.real(5) - s.real(6)) if s.keyword == "PLBELT" else 0.0


def check_geometry(scene: CheckMaterial) -> None:
    """Positions given once, elements with a length, directions that define a frame."""
    positions = _positions(scene)
    most = 2.0 * max(map(abs, chain.from_iterable(positions.values())), default=0.0)  # no smaller than the model is
    size: float | None = None
    if scene.outline.regular:
        groups = scene.index.groups_of(*[kind.keyword for kind in scene.outline.kinds], block=1)
    else:
        elements = scene.outline.elements
        groups = [StatementGroup.of(elements[number]) for number in scene.outline.types]
    for group in groups:
        kind = ELEMENT_TYPES[group.keyword]
        if not _ordinary(group, kind, positions, most):
            size = _size(scene, positions) if size is None else size
            for s in group:
                _check_element(scene, s, kind, positions, size)
    for s in scene.index.of("ORPINBOD"):
        _check_directions(scene, s)
    for s in scene.index.of("ORTUBE"):
        for first, what in ((1, "tangent at p"), (4, "tangent at q"), (7, "direction of y' at q")):
            if not any(s.reals(first, 3)):
                scene.findings.error(s, first, f"the {what} is a zero vector", "direction")
        if _sine(s.reals(4, 3), s.reals(7, 3)) < PARALLEL and any(s.reals(4, 3)) and any(s.reals(7, 3)):
            scene.findings.error(s, 7, "the direction of y' at q is parallel to the tangent at q", "direction")


def _size(scene: CheckMaterial, positions: dict[int, Vector]) -> float:
    """Largest extent of the model along an axis."""
    places = [positions.get(n, ORIGIN) for n, role in scene.outline.roles.items() if role == "position"]
    return max([max(axis) - min(axis) for axis in zip(*places)], default=0.0)  # noqa: B905 (three in each)


def _positions(scene: CheckMaterial) -> dict[int, Vector]:
    """Positions of the nodes with an X statement; nodes without X are at the origin."""
    positions: dict[int, Vector] = {}
    groups, roles = scene.index.groups_of("X", block=1), scene.outline.roles
    for group in groups:
        zeros = [repeat(0.0)] * (4 - group.width)
        nodes, *places = group.columns(0, group.width)
        new = dict(zip(nodes, zip(*places, *zeros)))  # noqa: B905 (of equal lengths)
        if not _all_new(new, group, positions) or set(map(roles.get, new)) != {"position"}:
            return _positions_one_by_one(scene, chain.from_iterable(groups))
        positions.update(new)
    return positions


def _positions_one_by_one(scene: CheckMaterial, statements: Iterable[Statement]) -> dict[int, Vector]:
    """The positions of X statements; positions of other nodes and repeated ones are reported."""
    positions: dict[int, Vector] = {}
    given: dict[int, Statement] = {}
    for s in statements:
        node, place = s.integer(0), s.reals(1, 3)
        if scene.outline.roles.get(node) == "orientation":
            text = f"node {node} is an orientation node; initial orientations cannot be chosen"
            scene.findings.error(s, 0, text, "orientation-given")
            continue
        if scene.outline.roles.get(node) == "warping":
            if any(place):
                text = f"node {node} is a warping node; its coordinate is zero at the start"
                scene.findings.error(s, 1, text, "warping-given")
            continue
        if node in given:
            line = given[node].line
            if positions[node] == place:
                scene.findings.warning(s, None, f"the same position was already given at line {line}", "repeated")
            else:
                text = f"node {node} was already given another position at line {line}"
                scene.findings.error(s, None, text, "repeated")
            continue
        given[node], positions[node] = s, place
    return positions


def _all_new(new: dict[int, Vector], group: StatementGroup, given: dict[int, Vector]) -> bool:
    """Whether every statement of a group, of which `new` are those of different nodes, is the first of its node."""
    return len(new) == len(group.lines) and given.keys().isdisjoint(new)


def _ordinary(group: StatementGroup, kind: ElementType, positions: dict[int, Vector], size: float) -> bool:
    """Whether elements are clearly long enough and their directions clearly good, so that none needs a closer look."""
    if kind.keyword in _WITH_RADII:
        return False
    given, directions = kind.direction, []
    if given is not None:
        start, end = given[0] - 1, given[0] - 1 + given[1]
        if group.width >= end:
            directions = [*zip(*group.columns(start, end))]  # noqa: B905 (of equal lengths)
            if not all(map(any, directions)):
                return False
    ends = kind.position_places
    if len(ends) < 2:
        return True
    p, q = ends
    starts = [positions.get(node, ORIGIN) for node in group.values[p :: group.width]]
    stops = [positions.get(node, ORIGIN) for node in group.values[q :: group.width]]
    if not min(map(dist, starts, stops)) > 2.0 * ZERO_LENGTH * size:
        return False
    return not directions or given is None or given[2] == "axis" or all(map(_oblique, starts, stops, directions))


def _oblique(p: Vector, q: Vector, direction: Vector) -> bool:
    """Whether a direction (three components) is clearly not parallel to pq; false too where squares are no numbers."""
    x, y, z = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    a, b, c = direction
    product = (x * x + y * y + z * z) * (a * a + b * b + c * c)
    across = (y * c - z * b) ** 2 + (z * a - x * c) ** 2 + (x * b - y * a) ** 2
    return SMALLEST_PRODUCT < product < inf and across > (2.0 * PARALLEL) ** 2 * product


def _check_element(
    scene: CheckMaterial, s: Statement, kind: ElementType, positions: dict[int, Vector], size: float
) -> None:
    direction = direction_of(s, kind)
    if direction is not None and not any(direction):
        assert kind.direction is not None
        scene.findings.error(s, kind.direction[0] - 1, "the direction vector is zero", "direction")
        direction = None
    if s.keyword in ("PLWHEEL", "TWHEEL"):
        _check_radii(scene, s)
    ends = [s.integer(i) for i in kind.position_places]
    if len(ends) < 2 or ends[0] == ends[1] or any(("X", n) in scene.outline.broken for n in ends):
        return
    p, q = positions.get(ends[0], ORIGIN), positions.get(ends[1], ORIGIN)
    chord = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    length = hypot(*chord)
    if length <= ZERO_LENGTH * size:
        if kind.length == "always" or (kind.length == "with direction" and direction is not None):
            without = [str(n) for n in ends if n not in positions]
            missing = f"; no X for node {' and '.join(without)}" if without else ""
            text = f"length {length:.6g} between nodes {ends[0]} and {ends[1]} is zero{missing}"
            scene.findings.error(s, None, f"{text} (size of the model {size:.6g})", "zero-length")
        return
    if 0.0 < length <= least_length(s):
        text = f"the pulleys with radii {s.real(5):.6g} and {s.real(6):.6g} are only {length:.6g} apart: no free belt"
        scene.findings.error(s, 5, text, "belt")
    if kind.direction is not None and kind.direction[2] != "axis" and direction is not None:
        sine = _sine(chord, direction)
        if sine < PARALLEL:
            text = f"the direction vector is parallel to the line from node {ends[0]} to node {ends[1]}"
            text += f" (angle {degrees(asin(sine)):.2g} degrees, length {length:.6g})"
            scene.findings.error(s, kind.direction[0] - 1, text, "direction")


def _check_radii(scene: CheckMaterial, s: Statement) -> None:
    """Radii of wheels are positive, that of the tread of a torus wheel smaller than the whole."""
    if s.keyword == "PLWHEEL" and s.real(4) <= 0.0:
        scene.findings.error(s, 4, f"wheel radius {s.real(4):g} must be positive", "radius")
    if s.keyword == "TWHEEL" and not 0.0 <= s.real(5) < s.real(4):
        text = f"transverse radius {s.real(5):g} must be between 0 and the equatorial radius {s.real(4):g}"
        scene.findings.error(s, 5, text, "radius")


def direction_of(s: Statement, kind: ElementType) -> Vector | None:
    """The direction vector of the statement, None when it was left out."""
    if kind.direction is None:
        return None
    first, count, _ = kind.direction
    return s.reals(first - 1, count) if len(s.values) >= first - 1 + count else None


def _check_directions(scene: CheckMaterial, s: Statement) -> None:
    """The vectors of ORPINBOD must be linearly independent."""
    dimension = 2 if len(s.values) in (3, 5) else 3
    vectors = [s.reals(i, dimension) for i in range(1, len(s.values), dimension)]
    for i, v in enumerate(vectors):
        if not any(v):
            scene.findings.error(s, 1 + i * dimension, "the direction vector is zero", "direction")
            return
    units = [_unit(v) for v in vectors]
    if len(units) == 2:
        volume = _sine(units[0], units[1])
    elif len(units) == 3:
        volume = abs(sum(a * b for a, b in zip(units[0], _cross(units[1], units[2]), strict=True)))
    else:
        return
    if volume < PARALLEL:
        text = f"the direction vectors are linearly dependent (volume of their unit vectors {volume:.2g})"
        scene.findings.error(s, 1, text, "direction")


def _unit(v: Vector) -> Vector:
    length = hypot(*v)  # which scales, so that neither tiny nor huge components lose their direction
    return tuple([c / length for c in v])


def _sine(a: Vector, b: Vector) -> float:
    """Sine of the angle between two vectors of two or three components; 1 when one of them is zero."""
    if not any(a) or not any(b):
        return 1.0
    a3, b3 = ((*_unit(v), 0.0)[:3] for v in (a, b))
    return min(1.0, hypot(*_cross(a3, b3)))


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
