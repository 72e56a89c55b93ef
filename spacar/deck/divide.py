"""Several equal beams in the place of one: statements of the divided model (PLBEAM, BEAM, BEAMW).

A beam of length l is divided along its chord into n of length h = l/n. With xi = s/l on the parent the deformations
e_p, e_q of a bending pair (slopes relative to the chord times l, e_q with the opposite sign: pure bending is
e_q = e_p) belong to the cubic

    w/l = e_p/l (xi - 2 xi^2 + xi^3) - e_q/l (xi^3 - xi^2)        (clamped cubic; theory-planar.md section 3.1)

and those of a part follow from its end slopes relative to its own chord, times h. Elongation is divided by n, torsion
(twist times length) by n^2. A preload (sigma_p, sigma_q) is a bending moment that runs linearly from sigma_p l to
sigma_q l, so a part has m(xi_i)/h and m(xi_i+1)/h; the normal force is the same in all parts, the torsional preload
(moment divided by the length) is multiplied by n, that of warping (bimoment divided by l^2) by n^2 and linear along the
beam. Twist rates at the new nodes are new dynamic degrees of freedom.

Limits: start values and prescribed deformations are split by this linear theory, exact for small deformations. Both
modes of a bending pair must be of one class. A released deformation (RLSE) that carries stiffness becomes dynamic in
all parts but the last, which keeps the release; one without stiffness (a joint) cannot be split. MEE on a split beam
and inputs or outputs (third block) on one are refused. The first part keeps the number of the parent, further
elements and nodes get numbers above all others.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

from spacar.deck.keyword_table import KEYWORDS
from spacar.deck.statement import Statement, Value
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import BlockKind

PAIRS = {t.keyword: t.split for t in ELEMENT_TYPES.values() if t.split}  # bending modes at p and q
BEAMS = tuple(PAIRS)
TORSION = {k: next((m for m, (n, _) in enumerate(ELEMENT_TYPES[k].modes, 1) if n == "torsion"), None) for k in BEAMS}
PER_ELEMENT = ("EM", "ESTIFF", "EDAMP")
CLASSES = ("DYNE", "RLSE", "INPUTE", "KINE")
MOTIONS = {"STARTDE": 2, "INPUTE": 3, "DELINPE": 1}  # how many values follow element and mode
Vector = tuple[float, ...]


def beam_modes(statements: Sequence[Statement], keywords: Iterable[str] = BEAMS) -> dict[int, dict[int, str]]:
    """Of every beam (or element of other keywords) that is not rigid: mode -> DYNE, RLSE, INPUTE or KINE."""
    wanted = tuple(keywords)
    beams = {s.integer(0): s.keyword for s in statements if s.block == 1 and s.keyword in wanted}
    modes: dict[int, dict[int, str]] = {}
    for s in statements:
        if s.block == 1 and s.keyword in CLASSES:
            number, *which = s.integers()
            if number in beams:
                every = ELEMENT_TYPES[beams[number]].classed
                known = [m for m in which or every if m in every]
                modes.setdefault(number, {}).update(dict.fromkeys(known, s.keyword))
    return modes


def stiffness_modes(statements: Sequence[Statement]) -> dict[int, dict[int, float]]:
    """Element -> coefficient of every mode, of the elements with ESTIFF."""
    keywords = {s.integer(0): s.keyword for s in statements if s.block == 1 and s.keyword in ELEMENT_TYPES}
    return {
        s.integer(0): {m: s.real(p - 1) for m, p in enumerate(ELEMENT_TYPES[keywords[s.integer(0)]].stiffness, 1)}
        for s in statements
        if s.block == 2 and s.keyword == "ESTIFF"
    }


def obstacles(
    statements: Sequence[Statement], chosen: Iterable[int], stiffness: Mapping[int, Mapping[int, float]]
) -> Iterator[tuple[int, Statement | None, str]]:
    """Why these beams cannot be divided: beam, the statement about it where there is one, and the reason.

    `stiffness`: element -> coefficient of every mode, as `stiffness_modes`.
    """
    split, modes_of = set(chosen), beam_modes(statements)
    beams = {s.integer(0): s.keyword for s in statements if s.block == 1 and s.keyword in BEAMS}
    for number in sorted(split):
        modes = modes_of.get(number, {})
        for m, c in modes.items():
            if c == "RLSE" and not stiffness.get(number, {}).get(m):
                yield number, None, (
                    f"its mode {m} is released without stiffness; put the joint into an element of its own (a hinge, or"
                    " a node that the beams do not share)"
                )
        for p, q in PAIRS[beams[number]]:
            if modes.get(p) != modes.get(q):
                yield number, None, (
                    f"its bending modes {p} and {q} are of different classes ({modes.get(p, 'fixed')},"
                    f" {modes.get(q, 'fixed')})"
                )
    for s in statements:
        about: set[Value] = set()
        if s.keyword == "MEE":
            about = {s.values[0], s.values[2]} if len(s.values) == 5 else {s.values[0]}
        if s.block == 3:
            about = _elements_of_port(s)
        for beam in sorted(about & split, key=str):
            yield int(beam), s, "refer to nodes, or to a model without it"


def _elements_of_port(s: Statement) -> set[Value]:
    """Elements that a statement of the third block is about: OUTE, INPUTS ... port, element, mode; TRE element, ..."""
    for block in BlockKind:
        keyword = KEYWORDS.get((s.keyword, block)) if block.number == 3 else None
        if keyword is not None:
            parameters = keyword.variants[0].parameters
            return {v for v, p in zip(s.values, parameters, strict=False) if p.of == "element"}
    return set()


def divided(
    statements: Sequence[Statement], pieces: Mapping[int, int]
) -> tuple[list[Statement], dict[int, list[int]]]:
    """The statements of the model with `pieces[element]` beams in the place of the element, and the numbers of the
    beams that each of these elements became; limits see above."""
    pieces = {number: n for number, n in pieces.items() if n > 1}
    if not pieces:
        return list(statements), {}
    elements = {s.integer(0): s for s in statements if s.block == 1 and s.keyword in ELEMENT_TYPES}
    top_node = max(s.integer(k) for s in elements.values() for k in range(1, 1 + len(ELEMENT_TYPES[s.keyword].nodes)))
    top_element = max(elements)
    position = {s.integer(0): s.reals(1, 3) for s in statements if s.keyword == "X" and s.block == 1}
    split = beam_modes(statements)
    parts: dict[int, list[int]] = {}
    found: list[Statement] = []
    for s in statements:
        if s.block != 1 or s.keyword not in BEAMS or s.integer(0) not in pieces:
            continue
        number, kind = s.integer(0), ELEMENT_TYPES[s.keyword]
        n = pieces[number]
        parts[number] = [number, *range(top_element + 1, top_element + n)]
        top_element += n - 1
        half = len(kind.nodes) // 2  # position, orientation(, warping) at each end
        inner = [tuple(range(top_node + half * i + 1, top_node + half * (i + 1) + 1)) for i in range(n - 1)]
        top_node += half * (n - 1)
        nodes = tuple(s.integer(i) for i in range(1, 1 + 2 * half))
        for part, (a, b) in zip(parts[number], pairwise([nodes[:half], *inner, nodes[half:]]), strict=True):
            found.append(made(s, part, *a, *b, *s.values[1 + 2 * half :]))
        zero = (0.0, 0.0, 0.0)
        ends = [position.get(node, zero)[: 2 if kind.planar else 3] for node in (nodes[0], nodes[half])]
        for i, (node, *_) in enumerate(inner, 1):
            place = [a + (i / n) * (b - a) for a, b in zip(*ends, strict=True)]
            found.append(made(s, node, *place, keyword="X"))
    for s in statements:
        if s.block == 1 and not (s.keyword in BEAMS and s.integer(0) in parts):
            found += _kinematic(s, split, parts)
    keywords = {number: elements[number].keyword for number in parts}
    for s in statements:
        if s.block == 2:
            found += _dynamic(s, parts, keywords)
    found += _motions(statements, parts, keywords)
    return found + [s for s in statements if s.block == 3], parts


def made(origin: Statement, *values: Value, keyword: str = "", block: int = 0) -> Statement:
    """A statement that another one stands for: messages about it name the line of that one; it has no columns."""
    return Statement(keyword or origin.keyword, values, block or origin.block, origin.line)


def _kinematic(s: Statement, split: dict[int, dict[int, str]], parts: dict[int, list[int]]) -> list[Statement]:
    """What a statement of the kinematics block that is no divided beam becomes."""
    if s.keyword == "ADEFORM" and not s.values:  # all elements
        return [s]
    if s.keyword in ("LDEFORM", "ADEFORM") and s.values[0] in parts:
        return [made(s, part) for part in parts[s.integer(0)]]
    if s.keyword not in CLASSES or s.values[0] not in parts:
        return [s]
    number = s.integer(0)
    modes = s.integers(1) or tuple(m for m, c in split[number].items() if c == s.keyword)
    modes = tuple(m for m in modes if m in split[number])  # without those that are released in any case
    if s.keyword != "RLSE":
        return [made(s, part, *modes) for part in parts[number]]
    *others, last = parts[number]
    return [*(made(s, part, *modes, keyword="DYNE") for part in others), made(s, last, *modes)]


def _dynamic(s: Statement, parts: dict[int, list[int]], keywords: dict[int, str]) -> list[Statement]:
    """What a statement of the dynamics block becomes; motions of divided beams come later, pair by pair."""
    if s.keyword == "MEE" or not s.values or s.values[0] not in parts:
        return [s]
    number = s.integer(0)
    n = len(parts[number])
    if s.keyword in PER_ELEMENT:
        return [made(s, part, *s.values[1:]) for part in parts[number]]
    if s.keyword in ("ESIG", "DELESIG"):
        keyword = keywords[number]
        table = split_preload(keyword, s.reals(1, len(ELEMENT_TYPES[keyword].modes)), n)
        return [made(s, part, *row) for part, row in zip(parts[number], table, strict=True)]
    return [] if s.keyword in MOTIONS else [s]


def split_preload(keyword: str, sigma: Vector, n: int) -> list[Vector]:
    """Preload of each of the n parts."""
    warping = ELEMENT_TYPES[keyword].released
    pairs = (*PAIRS[keyword], *([warping] if warping else []))
    rows = []
    for i in range(n):
        row = list(sigma)
        if TORSION[keyword] is not None:
            row[1] *= n
        for p, q in pairs:
            factor = n**2 if p in warping else n
            for mode, xi in ((p, i / n), (q, (i + 1) / n)):  # moment / l, bimoment / l^2
                row[mode - 1] = factor * (sigma[p - 1] * (1.0 - xi) + sigma[q - 1] * xi)
        rows.append(tuple(row))
    return rows


def joined_preload(keyword: str, n: int) -> list[tuple[int, int, float]]:
    """How generalized stresses of the parent follow from those of its n parts: (mode, part, factor), modes from 1.

    The reverse of `split_preload`: the moments at the two ends, the means of normal force and torsion.
    """
    warping = ELEMENT_TYPES[keyword].released
    pairs = (*PAIRS[keyword], *([warping] if warping else []))
    found = [(1, part, 1.0 / n) for part in range(n)]
    if TORSION[keyword] is not None:
        found += [(2, part, 1.0 / n**2) for part in range(n)]
    for p, q in pairs:
        factor = 1.0 / (n**2 if p in warping else n)
        found += [(p, 0, factor), (q, n - 1, factor)]
    return found


def split_pair(e_p: Vector, e_q: Vector, n: int) -> tuple[list[Vector], list[Vector]]:
    """Bending deformations of the n parts of a parent with e_p, e_q (value, rate, ...): n times as many of each."""

    def line(xi: float, a: float, b: float) -> float:
        return a * (xi - 2 * xi**2 + xi**3) - b * (xi**3 - xi**2)

    def slope(xi: float, a: float, b: float) -> float:
        return a * (1 - 4 * xi + 3 * xi**2) - b * (3 * xi**2 - 2 * xi)

    at_p, at_q = [], []
    for i in range(n):
        a, b = i / n, (i + 1) / n
        chord = [n * (line(b, u, v) - line(a, u, v)) for u, v in zip(e_p, e_q, strict=True)]
        at_p.append(tuple((slope(a, u, v) - c) / n for u, v, c in zip(e_p, e_q, chord, strict=True)))
        at_q.append(tuple(-(slope(b, u, v) - c) / n for u, v, c in zip(e_p, e_q, chord, strict=True)))
    return at_p, at_q


def _motions(statements: Sequence[Statement], parts: dict[int, list[int]], keywords: dict[int, str]) -> list[Statement]:
    """STARTDE, INPUTE and DELINPE of all parts of the divided beams."""
    found = []
    for keyword, width in MOTIONS.items():
        given: dict[int, dict[int, Statement]] = {}
        for s in statements:
            if s.block == 2 and s.keyword == keyword and s.values[0] in parts:
                given.setdefault(s.integer(0), {})[s.integer(1)] = s
        for number, of in given.items():
            values = {mode: s.reals(2, width) for mode, s in of.items()}
            origin = next(iter(of.values()))
            for mode, rows in _split_motion(keywords[number], values, width, len(parts[number])).items():
                by = of.get(mode, origin)
                found += [made(by, part, mode, *row) for part, row in zip(parts[number], rows, strict=True)]
    return found


def _split_motion(keyword: str, given: dict[int, Vector], width: int, n: int) -> dict[int, list[Vector]]:
    """mode -> motion of each of the n parts."""
    zero, torsion = (0.0,) * width, TORSION[keyword]
    result = {}
    if 1 in given:
        result[1] = [tuple(v / n for v in given[1])] * n
    if torsion in given:
        result[2] = [tuple(v / n**2 for v in given[2])] * n
    for p, q in PAIRS[keyword]:
        if p in given or q in given:
            result[p], result[q] = split_pair(given.get(p, zero), given.get(q, zero), n)
    return result
