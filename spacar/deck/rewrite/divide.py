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

Limits: start values and prescribed deformations are split by this linear theory, exact for small deformations. A
released deformation (RLSE) that carries stiffness becomes dynamic in all parts but the last, which keeps the release;
one without stiffness (a joint) cannot be split. Both modes of a bending pair must be of one class, or one dynamic and
one released. `RULES` has the statements that can be split; any other one that names a split beam (MEE, inputs, outputs,
paths) is refused. The first part keeps the number of the parent, further elements and nodes get numbers above all
others.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from operator import attrgetter

from spacar.deck.rewrite.references import ELEMENT, NODE, about, made, named
from spacar.deck.statement import Statement
from spacar.deck.table_elements import ELEMENT_TYPES

PAIRS = {t.keyword: t.split for t in ELEMENT_TYPES.values() if t.split}  # bending modes at p and q
BEAMS = tuple(PAIRS)
TORSION = {k: next((m for m, (n, _) in enumerate(ELEMENT_TYPES[k].modes, 1) if n == "torsion"), None) for k in BEAMS}
CLASSES = ("DYNE", "RLSE", "INPUTE", "KINE")
ALIKE = ("LDEFORM", "ADEFORM", "EM", "ESTIFF", "EDAMP")  # the same for every part
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
                reason = f"its mode {m} is released without stiffness; put the joint into an element of its own"
                yield number, None, f"{reason} (a hinge, or a node that the beams do not share)"
        for p, q in PAIRS[beams[number]]:
            if len({"DYNE" if c == "RLSE" else c for c in (modes.get(p), modes.get(q))}) > 1:
                classes = f"({modes.get(p, 'fixed')}, {modes.get(q, 'fixed')})"
                yield number, None, f"its bending modes {p} and {q} are of different classes {classes}"
    for s in statements:
        if s.keyword not in ELEMENT_TYPES and (s.keyword, s.block) not in RULES:
            for beam in sorted(split.intersection(named(s, ELEMENT))):
                yield beam, s, "refer to nodes, or to a model without it"


@dataclass
class _Division:
    """What becomes of the statements about divided beams: modes and classes of these before, their parts, keywords and
    motions, which are divided pair by pair: keyword and beam -> mode -> statement."""

    modes: dict[int, dict[int, str]]
    parts: dict[int, list[int]] = field(default_factory=dict)
    keywords: dict[int, str] = field(default_factory=dict)
    motions: dict[tuple[str, int], dict[int, Statement]] = field(default_factory=dict)

    def alike(self, s: Statement, beam: int) -> list[Statement]:
        return [made(s, part, *s.values[1:]) for part in self.parts[beam]]

    def classes(self, s: Statement, beam: int) -> list[Statement]:
        own = self.modes[beam]
        modes = s.integers(1) or tuple(m for m, c in own.items() if c == s.keyword)
        modes = tuple(m for m in modes if m in own)  # without those that are released in any case
        if s.keyword != "RLSE":
            return [made(s, part, *modes) for part in self.parts[beam]]
        *others, last = self.parts[beam]
        return [*(made(s, part, *modes, keyword="DYNE") for part in others), made(s, last, *modes)]

    def preload(self, s: Statement, beam: int) -> list[Statement]:
        keyword, parts = self.keywords[beam], self.parts[beam]
        table = split_preload(keyword, s.reals(1, len(ELEMENT_TYPES[keyword].modes)), len(parts))
        return [made(s, part, *row) for part, row in zip(parts, table, strict=True)]

    def motion(self, s: Statement, beam: int) -> list[Statement]:
        """Of all modes, in the place of the first."""
        of, parts = self.motions.pop((s.keyword, beam), {}), self.parts[beam]
        width = MOTIONS[s.keyword]
        values = {mode: o.reals(2, width) for mode, o in of.items()}
        found = []
        for mode, rows in split_motion(self.keywords[beam], values, width, len(parts)).items():
            by = of.get(mode, s)
            kept = parts[:-1] if self.modes[beam].get(mode) == "RLSE" else parts  # the last one follows
            found += [made(by, part, mode, *row) for part, row in zip(kept, rows, strict=False)]
        return found


Rule = Callable[[_Division, Statement, int], list[Statement]]
RULES: dict[tuple[str, int], Rule] = {
    **{(k, 1): _Division.classes for k in CLASSES},
    **{(k, block): _Division.alike for k in ALIKE for block in (1, 2)},
    **{(k, 2): _Division.motion for k in MOTIONS},
    ("ESIG", 2): _Division.preload,
    ("DELESIG", 2): _Division.preload,
}
"""Keyword and block of the statements about a beam that can be divided -> what they become."""


def divided(statements: Sequence[Statement], pieces: Mapping[int, int]) -> tuple[list[Statement], dict[int, list[int]]]:
    """The statements of the model with `pieces[element]` beams in the place of the element, and the numbers of the
    beams that each of these elements became; limits see above."""
    pieces = {number: n for number, n in pieces.items() if n > 1}
    if not pieces:
        return list(statements), {}
    elements = {s.integer(0): s for s in statements if s.block == 1 and s.keyword in ELEMENT_TYPES}
    top_node = max(node for s in elements.values() for node in named(s, NODE))
    top_element = max(elements)
    position = {s.integer(0): s.reals(1, 3) for s in statements if s.keyword == "X" and s.block == 1}
    division = _Division(beam_modes(statements))
    found: list[Statement] = []
    for number, s in elements.items():
        if s.keyword not in BEAMS or number not in pieces:
            continue
        kind = ELEMENT_TYPES[s.keyword]
        n = pieces[number]
        parts = division.parts[number] = [number, *range(top_element + 1, top_element + n)]
        division.keywords[number] = s.keyword
        top_element += n - 1
        nodes = named(s, NODE)
        half = len(nodes) // 2  # position, orientation(, warping) at each end
        inner = [tuple(range(top_node + half * i + 1, top_node + half * (i + 1) + 1)) for i in range(n - 1)]
        top_node += half * (n - 1)
        for part, (a, b) in zip(parts, pairwise([nodes[:half], *inner, nodes[half:]]), strict=True):
            found.append(made(s, part, *a, *b, *s.values[1 + 2 * half :]))
        zero = (0.0, 0.0, 0.0)
        ends = [position.get(node, zero)[: 2 if kind.planar else 3] for node in (nodes[0], nodes[half])]
        for i, (node, *_) in enumerate(inner, 1):
            place = [a + (i / n) * (b - a) for a, b in zip(*ends, strict=True)]
            found.append(made(s, node, *place, keyword="X"))
    for s in statements:
        if s.block == 2 and s.keyword in MOTIONS and s.integer(0) in division.parts:
            division.motions.setdefault((s.keyword, s.integer(0)), {})[s.integer(1)] = s
    for s in statements:
        beam = about(s)
        if beam is None or beam not in division.parts:
            found.append(s)
        elif s.keyword not in ELEMENT_TYPES:
            rule = RULES.get((s.keyword, s.block))
            found += rule(division, s, beam) if rule else [s]
    return sorted(found, key=attrgetter("block")), division.parts


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


def split_motion(keyword: str, given: dict[int, Vector], width: int, n: int) -> dict[int, list[Vector]]:
    """mode -> motion of each of the n parts; given: mode -> that of the beam."""
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
