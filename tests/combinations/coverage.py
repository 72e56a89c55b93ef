"""The covering array: every pair of element type, load or property, mode and option occurs in a case of `array.txt`.

`python -m tests.combinations.coverage` draws the array anew (after a change of the generator, or a new keyword or
element type). Pairs that cannot occur follow from the tables of keywords and modes, each with its reason.
"""

from __future__ import annotations

import random
import sys
import tempfile
from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path

from spacar.deck import ELEMENT_TYPES
from spacar.deck.checks_dynamics import _ADDITIONAL
from spacar.deck.table_types import uses
from spacar.integrators.methods import METHODS
from spacar.modes import MODES

from .case import Spec, drawn
from .cases import TYPES
from .model import Element, Model, Node
from .options import OPTIONS
from .properties import PROPERTIES, fits, keyword_row

ARRAY = Path(__file__).with_name("array.txt")
Value = tuple[str, str]  # factor, value
FACTORS: dict[str, tuple[str, ...]] = {
    "type": TYPES, "property": PROPERTIES, "mode": tuple(map(str, MODES)), "option": tuple(OPTIONS),
}  # fmt: skip


def modes_of(value: Value) -> tuple[set[int], str]:
    """The modes in which a value can occur, and why not in others."""
    factor, name = value
    if factor == "type":
        slips = ELEMENT_TYPES[name].slips
        return {m for m, row in MODES.items() if row.wheels or not slips}, f"slips of {name} are not for this mode"
    if factor == "mode":
        return {int(name)}, f"it is mode {name}"
    if factor == "option":
        return {m for m, row in MODES.items() if OPTIONS[name].modes(row)}, f"{name}: not an option of this mode"
    keyword = keyword_row(name)
    found = {m for m in MODES if uses(m, keyword.block.number)}
    if name in _ADDITIONAL:
        return {m for m in found if MODES[m].stationary}, f"{name} is additional loading of stationary states"
    if keyword.classes and not {"prescribed"} & {*keyword.classes}:
        inverse = {m for m in found if MODES[m].gives_setpoints or MODES[m].takes_setpoints}
        return found - inverse, f"{name} is about {' or '.join(keyword.classes)} freedoms; here all are prescribed"
    return found, f"{name} stands in block {keyword.block.number}, which this mode does not use"


def excuse(a: Value, b: Value) -> str:
    """Why two values cannot occur together; empty: they can."""
    kind = next((ELEMENT_TYPES[v] for f, v in (a, b) if f == "type"), None)
    name = next((v for f, v in (a, b) if f == "property"), None)
    if kind and name:
        if not fits(name, kind, keyword_row(name).block.number):
            return f"{name} has no form for {kind.keyword} or its nodes"
        modal = any(p.of == "mode" for p in keyword_row(name).variants[0].parameters)
        if modal and len(kind.slips) == len(kind.modes):
            return f"{name} is about a deformation; those of {kind.keyword} are slips"
    option = next((v for f, v in (a, b) if f == "option"), "")
    if kind and kind.slips and option.startswith("integrator"):
        method = METHODS[int(option.split()[1])]
        if "second order systems" in method.name:
            return f"{method.name}: the slips of {kind.keyword} are no second order system"
    (of_a, why_a), (of_b, why_b) = modes_of(a), modes_of(b)
    return "" if of_a & of_b else f"{why_a}; {why_b}"


def required() -> Iterator[tuple[Value, Value]]:
    """All pairs that can occur."""
    for f, g in combinations(FACTORS, 2):
        for v, w in product(FACTORS[f], FACTORS[g]):
            if not excuse((f, v), (g, w)):
                yield (f, v), (g, w)


def occurring(spec: Spec, model: Model) -> set[tuple[Value, Value]]:
    """The pairs of a model; a statement about an element or its nodes counts for the type of that element."""
    kinds, nodes = model.types, {}
    for r in model.blocks[0]:
        if r[0] in ELEMENT_TYPES:
            for n in r[2:]:
                if isinstance(n, Node):
                    nodes.setdefault(n, set()).add(r[0])
    every = set(kinds.values())
    settings = {("mode", str(spec.mode)), ("option", spec.option)}
    found = {pair for t in every for s in settings for pair in ((("type", t), s),)}
    found |= {(("mode", str(spec.mode)), ("option", spec.option))}
    for block, rows in enumerate(model.blocks[:2], 1):
        for r in rows:
            if r[0] not in PROPERTIES or keyword_row(r[0]).block.number != block:
                continue
            about = every
            if len(r) > 1 and isinstance(r[1], Element):
                about = {kinds[r[1]]}
            elif len(r) > 1 and isinstance(r[1], Node):
                about = nodes.get(r[1], set())
            if r[0] in ("USERSIG", "USERINP"):
                about = {t for p in (*model.pushes, *model.drives)
                         for t in (nodes[p.owner] if isinstance(p.owner, Node) else {kinds[p.owner]})}  # fmt: skip
            found |= {(("type", t), ("property", r[0])) for t in about}
            found |= {(("property", r[0]), s) for s in settings}
    return found


def written(spec: Spec) -> str:
    words = (spec.seed, spec.attempt, spec.mode, ",".join(spec.types), ",".join(spec.properties) or "-", spec.option)
    return " ".join(map(str, words))


def specs() -> list[Spec]:
    """The cases of the array."""
    found = []
    for line in ARRAY.read_text().splitlines():
        seed, attempt, mode, types, properties, option = line.split(maxsplit=5)
        given = () if properties == "-" else tuple(properties.split(","))
        found.append(Spec(int(seed), tuple(types.split(",")), given, int(mode), option, int(attempt)))
    return found


def wanted(rng: random.Random, seed: int, first: tuple[Value, Value], missing: set) -> Spec:
    """A case with the pair, and with what is missing beside it."""
    have = dict(first)
    partners: dict[str, list[str]] = {f: [] for f in FACTORS}
    for pair in missing:
        for (f, v), other in (pair, pair[::-1]):
            if have.get(other[0]) == other[1]:
                partners[f].append(v)

    order = list(FACTORS)

    def agree(f: str, v: str) -> bool:
        pairs = (sorted(((f, v), other), key=lambda x: order.index(x[0])) for other in have.items() if other[0] != f)
        return all(not excuse(*pair) for pair in pairs)

    for factor in ("mode", "option", "type"):
        if factor not in have:
            names = [v for v in sorted(partners[factor]) if agree(factor, v)] or [
                v for v in FACTORS[factor] if agree(factor, v)
            ]
            have[factor] = rng.choice(names)
    kind = ELEMENT_TYPES[have["type"]]
    chosen = [have["property"]] if "property" in have else []
    names = [v for v in partners["property"] if agree("property", v) and fits(v, kind, keyword_row(v).block.number)]
    chosen += [v for v in rng.sample(names, min(4, len(names))) if v not in chosen]
    more = [t for t in TYPES if ELEMENT_TYPES[t].planar == kind.planar and not ELEMENT_TYPES[t].slips]
    types = (have["type"], *(t for t in rng.sample(more, 1) if t != have["type"]))
    return Spec(seed, tuple(types), tuple(dict.fromkeys(chosen)), int(have["mode"]), have["option"])


def draw(count: int = 300) -> None:
    """Cases until every pair occurs, then more to the count; written to `array.txt`."""
    rng, missing, found, hopeless = random.Random(30), set(required()), [], []
    tries: dict = {}
    seed = 0
    while missing or len(found) < count:
        seed += 1
        first = min(missing, key=lambda p: (tries.get(p, 0), p)) if missing else rng.choice(sorted(required()))
        tries[first] = tries.get(first, 0) + 1
        if tries[first] > 12:
            hopeless.append(first)
            missing.discard(first)
            continue
        spec = wanted(rng, seed, first, missing)
        with tempfile.TemporaryDirectory() as folder:
            try:
                spec, case = drawn(spec, Path(folder))
            except AssertionError as error:
                print(str(error)[:300], file=sys.stderr)
                continue
        new = occurring(spec, case.model) & missing
        if new or not missing:
            missing -= new
            found.append(spec)
            print(len(found), len(missing), len(new), written(spec), sorted(missing)[:1], file=sys.stderr)
    ARRAY.write_text("".join(f"{written(s)}\n" for s in found))
    print(*(f"never occurs: {p}" for p in hopeless), sep="\n")


if __name__ == "__main__":
    draw()
