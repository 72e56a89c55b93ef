"""Other models of the same mechanism: finer beams, rigid beams, beams without the non-linear strain terms.

`refine` splits every flexible beam (PLBEAM, BEAM, BEAMW) into n equal ones along its chord. With xi = s/l on the
parent and h = l/n, the deformations e_p, e_q of a bending pair (slopes relative to the chord times l, e_q with the opposite
sign: pure bending is e_q = e_p) belong to the cubic

    w/l = e_p/l (xi - 2 xi^2 + xi^3) - e_q/l (xi^3 - xi^2)        (clamped cubic; theory-planar.md, beam)

and those of a part follow from its end slopes relative to its own chord, times h. Elongation is divided by n,
torsion (twist times length) by n^2. A preload (sigma_p, sigma_q) is a bending moment that runs linearly from sigma_p
l to sigma_q l, so a part has m(xi_i)/h and m(xi_i+1)/h; the normal force is the same in all parts, the torsional
preload (moment divided by the length) is multiplied by n, that of warping (bimoment divided by l^2) by n^2 and linear
along the beam. Twist rates at the new nodes are new dynamic degrees of freedom.

Limits: start values and prescribed deformations are split by this linear theory, exact for small deformations. Both
modes of a bending pair must be of one class. A released deformation (RLSE) that carries stiffness becomes dynamic in
all parts but the last, which keeps the release; one without stiffness (a joint) cannot be split. MEE on a split beam
and inputs or outputs (third block) on one are refused. The first part keeps the number of the parent, further
elements and nodes get numbers above all others.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.deck.keyword_table import KEYWORDS, BlockKind
from spacar.deck.statement import Value
from spacar.errors import UsageError

PAIRS = {t.keyword: t.split for t in ELEMENT_TYPES.values() if t.split}  # bending modes at p and q
BEAMS = tuple(PAIRS)
TORSION = {k: next((m for m, (n, _) in enumerate(ELEMENT_TYPES[k].modes, 1) if n == "torsion"), None) for k in BEAMS}
PER_ELEMENT = ("EM", "ESTIFF", "EDAMP")
CLASSES = ("DYNE", "RLSE", "INPUTE", "KINE")
Row = tuple[Value, ...]
Motions = dict[int, tuple[float, ...]]  # mode -> start, rate(, acceleration)


def beam_modes(deck: Deck) -> dict[int, dict[int, str]]:
    """Of every beam that is not rigid: mode -> DYNE, RLSE, INPUTE or KINE."""
    beams = {s.integer(0): s.keyword for s in deck.of(*BEAMS, block=1)}
    modes: dict[int, dict[int, str]] = {}
    for s in deck.of(*CLASSES, block=1):
        number, *which = s.integers()
        if number in beams:
            every = ELEMENT_TYPES[beams[number]].classed
            known = [m for m in which or every if m in every]
            modes.setdefault(number, {}).update(dict.fromkeys(known, s.keyword))
    return modes


def flexible_beams(deck: Deck) -> dict[int, dict[int, str]]:
    """Beams with dynamic or prescribed deformations, or released ones that carry stiffness; modes as `beam_modes`."""
    stiff = {s.integer(0): {m for m, k in _stiffness_modes(deck, s).items() if k} for s in deck.of("ESTIFF", block=2)}
    return {
        number: modes
        for number, modes in beam_modes(deck).items()
        if any(c != "RLSE" or m in stiff.get(number, ()) for m, c in modes.items())
    }


def _stiffness_modes(deck: Deck, estiff: Statement) -> dict[int, float]:
    """Coefficient of every mode of the element of an ESTIFF statement."""
    keyword = next(s.keyword for s in deck.of(*ELEMENT_TYPES, block=1) if s.values[0] == estiff.values[0])
    return {m: estiff.real(p - 1) for m, p in enumerate(ELEMENT_TYPES[keyword].stiffness, 1)}


def refine(deck: Deck, n: int) -> Deck:
    """The same mechanism with n elements in the place of every flexible beam (1: the deck itself); limits see above.

    Raises UsageError for n < 1, a model without flexible beams, and one that cannot be split.
    """
    if n < 1:
        raise UsageError(f"a beam is split into 1 or more elements, not {n}", "study.refine")
    split = flexible_beams(deck)
    if not split:
        raise UsageError(f"{deck.source} has no flexible {' or '.join(BEAMS)} to refine", "study.refine")
    if n == 1:
        return deck
    _require_splittable(deck, split)
    elements = {s.integer(0): s for s in deck.of(*ELEMENT_TYPES, block=1)}
    top_node = max(s.integer(k) for s in elements.values() for k in range(1, 1 + len(ELEMENT_TYPES[s.keyword].nodes)))
    top_element = max(elements)
    position = {s.integer(0): np.array(s.reals(1, 3)) for s in deck.of("X", block=1)}
    parts: dict[int, list[int]] = {}
    kinematics: list[Row] = []
    for s in deck.statements:
        if s.block != 1:
            continue
        if s.keyword in BEAMS and s.integer(0) in split:
            number, kind = s.integer(0), ELEMENT_TYPES[s.keyword]
            parts[number] = [number, *range(top_element + 1, top_element + n)]
            top_element += n - 1
            half = len(kind.nodes) // 2  # position, orientation(, warping) at each end
            inner = [tuple(range(top_node + half * i + 1, top_node + half * (i + 1) + 1)) for i in range(n - 1)]
            top_node += half * (n - 1)
            nodes = tuple(s.integer(i) for i in range(1, 1 + 2 * half))
            ends = [nodes[:half], *inner, nodes[half:]]
            for part, a, b in zip(parts[number], ends, ends[1:], strict=False):
                kinematics.append((s.keyword, part, *a, *b, *s.values[1 + 2 * half :]))
            x_p, x_q = (position.get(node, np.zeros(3)) for node in (nodes[0], nodes[half]))
            size = 2 if kind.planar else 3
            for i, (node, *_) in enumerate(inner, 1):
                kinematics.append(("X", node, *(x_p + (i / n) * (x_q - x_p))[:size].tolist()))
    for s in deck.statements:
        if s.block == 1 and not (s.keyword in BEAMS and s.values[0] in split):
            kinematics += _kinematic(s, split, parts)
    dynamics = [row for s in deck.statements if s.block == 2 for row in _dynamic(deck, s, parts)]
    dynamics += _motion_rows(deck, parts)
    third: list[Row] = [(s.keyword, *s.values) for s in deck.statements if s.block == 3]
    return Deck.build(kinematics, dynamics, third, mode=deck.mode, source=f"{deck.source} x {n}", path=deck.path)


def _kinematic(s: Statement, split: dict[int, dict[int, str]], parts: dict[int, list[int]]) -> Iterable[Row]:
    """Rows of a statement of the kinematics block that is no split beam."""
    if s.keyword in ("LDEFORM", "ADEFORM") and s.values and s.values[0] in parts:
        return [(s.keyword, part) for part in parts[s.integer(0)]]
    if s.keyword not in CLASSES or s.values[0] not in parts:
        return [(s.keyword, *s.values)]
    number = s.integer(0)
    modes = s.integers(1) or tuple(m for m, c in split[number].items() if c == s.keyword)
    modes = tuple(m for m in modes if m in split[number])  # without those that are released in any case
    if s.keyword != "RLSE":
        return [(s.keyword, part, *modes) for part in parts[number]]
    *others, last = parts[number]
    rows: list[Row] = [("DYNE", part, *modes) for part in others]
    return [*rows, ("RLSE", last, *modes)]


def _dynamic(deck: Deck, s: Statement, parts: dict[int, list[int]]) -> Iterable[Row]:
    """Rows of a statement of the dynamics block; motions of split beams come later, pair by pair."""
    if s.keyword == "MEE" or not s.values or s.values[0] not in parts:
        return [(s.keyword, *s.values)]
    number = s.integer(0)
    n = len(parts[number])
    if s.keyword in PER_ELEMENT:
        return [(s.keyword, part, *s.values[1:]) for part in parts[number]]
    if s.keyword in ("ESIG", "DELESIG"):
        keyword = next(b.keyword for b in deck.of(*BEAMS, block=1) if b.values[0] == number)
        table = _split_preload(keyword, s.reals(1, len(ELEMENT_TYPES[keyword].modes)), n)
        return [(s.keyword, part, *row) for part, row in zip(parts[number], table.tolist(), strict=True)]
    if s.keyword in ("STARTDE", "INPUTE", "DELINPE"):
        return []
    return [(s.keyword, *s.values)]


def _split_preload(keyword: str, sigma: tuple[float, ...], n: int) -> np.ndarray:
    """Preload of the parts, (n, modes)."""
    table = np.tile(np.array(sigma), (n, 1))
    if TORSION[keyword] is not None:
        table[:, 1] *= n
    xi = np.arange(n + 1) / n
    warping = ELEMENT_TYPES[keyword].released
    for p, q in (*PAIRS[keyword], *([warping] if warping else [])):
        m = sigma[p - 1] * (1.0 - xi) + sigma[q - 1] * xi  # moment / l, bimoment / l^2
        factor = n**2 if p in warping else n
        table[:, p - 1], table[:, q - 1] = factor * m[:-1], factor * m[1:]
    return table


def split_pair(e_p: np.ndarray, e_q: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Bending deformations of the n parts, (n, k) each, of a parent with e_p, e_q (k,)."""
    xi = (np.arange(n + 1) / n)[:, None]
    w = e_p * (xi - 2 * xi**2 + xi**3) - e_q * (xi**3 - xi**2)
    slope = e_p * (1 - 4 * xi + 3 * xi**2) - e_q * (3 * xi**2 - 2 * xi)
    chord = np.diff(w, axis=0) * n
    return (slope[:-1] - chord) / n, -(slope[1:] - chord) / n


def _motion_rows(deck: Deck, parts: dict[int, list[int]]) -> list[Row]:
    """STARTDE, INPUTE and DELINPE of all parts of the split beams."""
    beams = {s.integer(0): s.keyword for s in deck.of(*BEAMS, block=1)}
    rows: list[Row] = []
    for keyword, width in (("STARTDE", 2), ("INPUTE", 3), ("DELINPE", 1)):
        motions: dict[int, Motions] = {}
        for s in deck.of(keyword, block=2):
            if s.values[0] in parts:
                motions.setdefault(s.integer(0), {})[s.integer(1)] = s.reals(2, width)
        for number, given in motions.items():
            for mode, table in _split_motion(beams[number], given, width, len(parts[number])).items():
                rows += [(keyword, part, mode, *row) for part, row in zip(parts[number], table.tolist(), strict=True)]
    return rows


def _split_motion(keyword: str, given: Motions, width: int, n: int) -> dict[int, np.ndarray]:
    """mode -> motion of the parts, (n, width)."""
    zero = np.zeros(width)
    value = {m: np.array(v) for m, v in given.items()}
    result = {}
    if 1 in value:
        result[1] = np.tile(value[1] / n, (n, 1))
    if TORSION[keyword] in value:
        result[2] = np.tile(value[2] / n**2, (n, 1))
    for p, q in PAIRS[keyword]:
        if p in value or q in value:
            result[p], result[q] = split_pair(value.get(p, zero), value.get(q, zero), n)
    return result


def _require_splittable(deck: Deck, split: dict[int, dict[int, str]]) -> None:
    beams = {s.integer(0): s.keyword for s in deck.of(*BEAMS, block=1)}
    stiffness = {s.integer(0): _stiffness_modes(deck, s) for s in deck.of("ESTIFF", block=2)}
    for number, modes in split.items():
        for m, c in modes.items():
            if c == "RLSE" and not stiffness.get(number, {}).get(m):
                text = (
                    f"beam {number} cannot be split: its mode {m} is released without stiffness; put the joint into an"
                )
                raise UsageError(
                    f"{text} element of its own (a hinge, or a node that the beams do not share)", "study.refine"
                )
        for p, q in PAIRS[beams[number]]:
            if modes.get(p) != modes.get(q):
                text = f"beam {number} cannot be split: its bending modes {p} and {q} are of different classes"
                raise UsageError(f"{text} ({modes.get(p, 'fixed')}, {modes.get(q, 'fixed')})", "study.refine")
    for s in deck.statements:
        about: set[Value] = set()
        if s.keyword == "MEE":
            about = {s.values[0], s.values[2]} if len(s.values) == 5 else {s.values[0]}
        if s.block == 3 and deck.third is not None:
            about = _elements_of_port(s)
        for beam in sorted(about & set(split), key=str):
            text = f"{deck.where(s)}: it is about beam {beam}, which would be split"
            raise UsageError(f"{text}; refine a model without it, or refer to nodes", "study.refine")


def _elements_of_port(s: Statement) -> set[Value]:
    """Elements that a statement of the third block is about: OUTE, INPUTS ... port, element, mode; TRE element, ..."""
    for block in BlockKind:
        keyword = KEYWORDS.get((s.keyword, block)) if block.number == 3 else None
        if keyword is not None:
            parameters = keyword.variants[0].parameters
            return {v for v, p in zip(s.values, parameters, strict=False) if p.of == "element"}
    return set()


def rigid(deck: Deck) -> Deck:
    """The mechanism with all dynamic deformations of its beams fixed: DYNE of beams and what belongs to it left out.

    Raises UsageError when no beam has a dynamic deformation.
    """
    modes = {n: {m for m, c in found.items() if c == "DYNE"} for n, found in beam_modes(deck).items()}
    stiff = {n for n, fixed in modes.items() if fixed}
    if not stiff:
        raise UsageError(f"{deck.source} has no beam with dynamic deformations (DYNE)", "study.rigid")
    free = {n for n, found in beam_modes(deck).items() if set(found.values()) - {"DYNE"}}

    def keep(s: Statement) -> bool:
        if not s.values or s.values[0] not in stiff:
            return True
        if s.keyword in ("DYNE", "STARTDE"):
            return False
        return s.keyword not in ("ESTIFF", "EDAMP", "ESIG", "LDEFORM") or s.values[0] in free

    held = [("FIX", node) for node in _free_warping(deck, stiff - free)]
    return _with(deck, [s for s in deck.statements if keep(s)], held, "rigid")


def _free_warping(deck: Deck, rigid: set[int]) -> list[int]:
    """Warping nodes that only rigid beams use and no statement gives a class to: they must be fixed."""
    used: dict[int, bool] = {}
    for s in deck.of(*ELEMENT_TYPES, block=1):
        for place in ELEMENT_TYPES[s.keyword].warping:
            node = s.integer(1 + place)
            used[node] = used.get(node, True) and s.integer(0) in rigid
    given = {s.values[0] for s in deck.of("FIX", "INPUTX", "DYNX", "KINX", block=1)}
    return [node for node, only in used.items() if only and node not in given]


def linear_strain(deck: Deck) -> Deck:
    """The mechanism with LDEFORM for every flexible beam. Raises UsageError when there is none that has not got it."""
    have = {s.integer(0) for s in deck.of("LDEFORM", block=1)}
    rows = [("LDEFORM", n) for n in flexible_beams(deck) if n not in have]
    if not rows:
        raise UsageError(f"{deck.source} has no flexible beam with non-linear strain terms", "study.linear")
    return _with(deck, deck.statements, rows, "LDEFORM")


def _with(deck: Deck, statements: Iterable[Statement], more: Iterable[Row], what: str) -> Deck:
    blocks: list[list[Row]] = [[], [], []]
    for s in statements:
        blocks[s.block - 1].append((s.keyword, *s.values))
    blocks[0] += more
    return Deck.build(*blocks, mode=deck.mode, source=f"{deck.source} ({what})", path=deck.path)
