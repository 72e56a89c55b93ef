"""Every statement of the keyword table beside every way of dividing beams. All reals equal numbers of elements and
nodes on purpose. The same model with shifted numbers, where they equal none, is the truth: what names an element or
node is shifted, nothing else, and the results are the same."""

from itertools import pairwise

import numpy as np
import pytest

import spacar
from spacar.deck import ELEMENT_TYPES, Deck, parse_deck
from spacar.deck.keyword_table import KEYWORDS
from spacar.deck.rewrite.references import NODE, named, places, renumbered
from spacar.deck.rewrite.refine import refine, refine_divisible
from spacar.deck.table_types import BlockKind
from spacar.errors import InputError, SpacarError

SHIFT = 40
VALUES = (1.0, 2.0, 3.0, 1.0, 1.0, 2.0, 3.0, 3.0, 1.0)
SECTIONS = ("SECTION", "MATERIAL", "UNITS")  # no numbers of elements or nodes
# Wheels and tubes, which the models below have not; MEE, and where all beams are divided inputs, outputs and paths of
# beams: these name a beam that cannot be divided.
ELSEWHERE = {"KINX", "KINE", "ORTUBE", "DELOMF", "MEE", "INTEGRAT"}
OF_BEAMS = {
    k.name
    for k in KEYWORDS.values()
    if k.block.number == 3 and any(p.of == "element" for p in k.variants[0].parameters)
}
CLASSES = ("RLSE", "INPUTE", "DYNE", "KINE")


def model(shift: int, planar: bool, statement: tuple, block: int, third: bool) -> list[list[tuple]]:
    """Two beams in line (1: E, 2: E) and a rigid body (3) at their end, with one statement more; what would say the
    same twice is left out."""
    word = "PL" if planar else ""
    direction = () if planar else (0.0, 1.0, 0.0)
    body = () if planar else (0.0, 1.0, 0.0)
    E, N = (lambda k: k + shift), (lambda k: k + shift)
    kinematics = [
        (f"{word}BEAM", E(1), N(1), N(2), N(3), N(4), *direction),
        (f"{word}BEAM", E(2), N(3), N(4), N(5), N(6), *direction),
        (f"{word}RBEAM", E(3), N(5), N(6), N(7), *body),
        ("X", N(3), 1.0, 0.0), ("X", N(5), 2.0, 0.0), ("X", N(7), 3.0, 0.0),
        ("FIX", N(1)), ("FIX", N(2)), *[("DYNE", E(k), *((2, 3) if planar else (2, 3, 4, 5, 6))) for k in (1, 2)],
    ]  # fmt: skip
    bending = (7e4, 7e4) if planar else (7e4, 5e4, 7e4, 6e4)
    dynamics = [*[("ESTIFF", E(k), *bending) for k in (1, 2)]]
    dynamics += [("EM", E(1), 1.0), ("EM", E(2), 1.0), ("XM", N(7), 3.0)]
    own = statement[:1] if len(statement) == 1 or not isinstance(statement[1], int) else statement[:2]
    blocks = [kinematics, dynamics, trajectory(shift, planar, statement, kinematics) if third else []]
    if block == 0 and statement[0] in CLASSES:
        kinematics[:] = [r for r in kinematics if r[:2] != ("DYNE", statement[1])]
    if statement[0] in ("INPUTE", "DELINPE") and block == 1:
        kinematics[:] = [r for r in kinematics if r[:2] != ("DYNE", statement[1])]
        kinematics.append(("INPUTE", statement[1], 2, 3) if planar else ("INPUTE", statement[1], 2))
    if statement[0] in ("INPUTX", "DELINPX", "STARTDX") and block == 1:
        kinematics.append(("DYNX" if statement[0] == "STARTDX" else "INPUTX", statement[1], statement[2]))
    if statement[0].startswith("DEL"):
        dynamics.append(("ITERSTEP", 10, 2, 5e-7, 1, 2, 2))
    if block == 2 and statement[0] == "OUTF":
        kinematics.append(("FIX", *statement[2:]))
    if block == 2 and statement[0].startswith(("IN", "NOM")):
        classed = "INPUTX" if statement[0].startswith("INX") else "INPUTE" if statement[0].startswith("INE") else ""
        kinematics[:] = [r for r in kinematics if classed != "INPUTE" or r[:2] != ("DYNE", statement[2])]
        kinematics.extend([(classed, *statement[2:])] if classed else [])
    blocks[block] = [r for r in blocks[block] if r[: len(own)] != own]
    blocks[block].insert(0, statement) if statement[0] == "TRAJECT" else blocks[block].append(statement)
    return blocks


def trajectory(shift: int, planar: bool, statement: tuple, kinematics: list[tuple]) -> list[tuple]:
    """A third block in which the statement may stand, and what moves is prescribed."""
    rows: list[tuple] = [("TRAJECT", 1), ("TRTIME", 1.0, 2)]
    name, *values = statement
    if name in ("TRE", "TREPMAX"):
        kinematics.append(("INPUTE", values[0], 1))
        return [*rows, ("TRE", values[0], 1.0)]
    if name[:2] != "TR" or name in ("TRAJECT", "TRTIME"):
        return [*rows, ("USERTRAJ", "f")]
    turned = values[0] == 4 + shift
    if turned:
        kinematics.append(("INPUTX", values[0]))
        return [*rows, ("TROT", values[0], 1.0, *(() if planar else (0.0, 0.0, 1.0)))]
    kinematics.append(("INPUTX", 3 + shift))
    return rows if name == "TRCIRL" else [*rows, ("TRANS", 3 + shift, *(3.0, 2.0, 1.0)[: 2 if planar else 3])]


def statements(shift: int, planar: bool, every: bool = True):
    """(kind of block, statement) for every keyword and form, `every` number of values or the extremes."""
    space = "planar" if planar else "spatial"
    for (name, kind), row in KEYWORDS.items():
        if name in ELEMENT_TYPES or name in (*SECTIONS, "BEAMSEC"):
            continue
        for variant in row.variants:
            if variant.space not in ("", space) or variant.role == "warping":
                continue
            for count in variant.counts if every else {variant.counts[0], variant.counts[-1]}:
                parameters = variant.parameters[:count]
                if any(p.kind == "name" for p in parameters):
                    continue
                beams = not variant.types or {"PLBEAM", "BEAM"} & {*variant.types}
                node = {"position": 3, "orientation": 4}.get(variant.role, 3)
                seen = {"element": 0, "mode": 1, "coordinate": 0}
                values: list = []
                for p in parameters:
                    if p.of in seen:
                        seen[p.of] += 1
                    k = seen.get(p.of, 0)
                    if p.of == "element":
                        values.append((0 if beams else 2) + k + shift + (kind.number == 3))
                    elif "node" in p.of:
                        values.append((4 if p.of.startswith("orientation") else node) + shift)
                    elif p.of in seen:  # modes from 2: bending
                        values.append(min(k, 3) if planar and p.of == "mode" else k)
                    else:
                        values.append(1 if p.kind == "integer" else VALUES[len(values) % len(VALUES)])
                yield kind, (name, *values)


def divided(way: str, blocks: list[list[tuple]], shift: int, mode: int | None) -> Deck:
    """The deck divided in one of the ways."""
    if way in ("file", "expand"):
        sections = [("SECTION", "s", "RECT", 1.0, 2.0), ("MATERIAL", "m", 3e6, 1e6, 2.0)]
        sections.append(("BEAMSEC", 1 + shift, "s", "m", 2))
        dynamics = [r for r in blocks[1] if r[:2] not in (("ESTIFF", 1 + shift), ("EM", 1 + shift))]
        deck = Deck.build([*blocks[0], *sections], dynamics, blocks[2], mode=mode)
        return deck if way == "file" else parse_deck(deck.to_text(), mode=mode)
    deck = Deck.build(*blocks, mode=mode)
    return refine(deck, 3) if way == "refine" else refine_divisible(deck, 2)[0]


def outcome(way: str, shift: int, planar: bool, kind: BlockKind, statement: tuple, mode: int | None):
    try:
        blocks = model(shift, planar, statement, kind.number - 1, kind is BlockKind.TRAJECTORY)
        return divided(way, blocks, shift, mode)
    except InputError as error:
        return sorted((m.code, m.keyword.split()[0]) for m in error.messages if m.severity == "error")
    except SpacarError as error:
        return error.code


@pytest.mark.parametrize("way", ["file", "expand", "elements", "refine"])
@pytest.mark.parametrize(
    ("planar", "counts"),
    [(True, "extremes"), *(pytest.param(p, "every", marks=pytest.mark.slow) for p in (True, False))],
)
def test_numbers_of_values_do_not_matter(way: str, planar: bool, counts: str) -> None:
    """Statement by statement: a value is the same, or a number that is shifted; every keyword is read at least once."""
    right: set[str] = set()
    every: set[str] = set()
    both = (statements(shift, planar, counts == "every") for shift in (0, SHIFT))
    for (kind, here), (_, there) in zip(*both, strict=True):
        a, b = (outcome(way, d, planar, kind, s, None) for d, s in ((0, here), (SHIFT, there)))
        every.add(here[0])
        if not isinstance(a, Deck):
            assert a == b, (here, a, b)
            continue
        right.add(here[0])
        assert len(a.statements) == len(b.statements), here
        for s, t in zip(a.statements, b.statements, strict=True):
            assert (s.keyword, len(s.values)) == (t.keyword, len(t.values)), here
            of = [i for i, _ in places(s)]
            for i, (v, w) in enumerate(zip(s.values, t.values, strict=True)):
                assert w == (v + SHIFT if i in of else v), (here, s, t)
        shifted = renumbered(a.statements, (SHIFT).__add__, (SHIFT).__add__)
        assert [s[:3] for s in shifted] == [s[:3] for s in b.statements]
    # the others need another model (tubes, wheels, ports on beams that cannot be divided) and are refused alike
    refused = ELSEWHERE | (OF_BEAMS if way in ("elements", "refine") else set())
    assert every - right <= refused, every - right - refused


RUN = [
    (1, "TIMESTEP", (1.0, 2)), (1, "GRAVITY", (1.0, 2.0)), (1, "ERROR", (2.0, 1.0)), (7, "GRAVITY", (2.0, 1.0)),
    (7, "ITERSTEP", (2, 1, 1.0)), (7, "MODES", (1,)), (8, "DELGRAV", (1.0, 2.0)), (1, "INTEGRAT", (140, 1.0)),
]  # fmt: skip


@pytest.mark.parametrize(("mode", "keyword", "values"), RUN)
@pytest.mark.parametrize("way", ["file", "expand", "elements", "refine"])
def test_results_do_not_depend_on_the_numbers(way: str, mode: int, keyword: str, values: tuple) -> None:
    kind = BlockKind.DYNAMICS
    found = []
    for shift in (0, SHIFT):
        deck = outcome(way, shift, True, kind, (keyword, *values), mode)
        assert isinstance(deck, Deck), deck
        run = {"max_iterations": 10} if keyword == "ITERSTEP" else {}
        found.append(spacar.run(mode, deck, **run))
    for name in ("x", "sig"):
        np.testing.assert_array_equal(found[0][name], found[1][name])


def test_the_table_tells_what_a_value_names() -> None:
    """Keyword, block and number of values are enough: no two forms name different things at one place."""
    for (name, kind), row in KEYWORDS.items():
        by_count: dict[int, set[tuple]] = {}
        for variant in row.variants:
            for count in variant.counts:
                of = tuple("node" if p.of.endswith("node") else p.of for p in variant.parameters[:count])
                by_count.setdefault(count, set()).add(tuple(o if o in ("element", "node") else "" for o in of))
        assert all(len(forms) == 1 for forms in by_count.values()), (name, kind)


def test_fronts_follow_their_paths() -> None:
    """TRFRONT names the node or element that has a path in its trajectory."""
    text = "PLBEAM 1 1 2 3 4\nX 3 1 0\nFIX 1\nFIX 2\nINPUTE 1 1\nEND HALT\nXM 3 1\nEND HALT\n"
    text += "TRAJECT 1\nTRE 1 0.1\nTRFRONT 1 2\nTRTIME 1 2\nEND END\n"
    deck = parse_deck(text, mode=2)
    rows = [s.values for s in renumbered(deck.statements, lambda n: n + 10, lambda n: n + 20) if s.keyword == "TRFRONT"]
    assert rows == [(11, 2)]
    assert not any(named(s, NODE) for s in deck.statements if s.block == 3)
    assert all(a.block <= b.block for a, b in pairwise(deck.statements))
