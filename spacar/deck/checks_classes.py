"""The class of every coordinate and deformation, and checks of the statements that give them."""

from collections.abc import Callable, Mapping

from spacar.deck.check_material import CheckMaterial, Classes
from spacar.deck.statement import Statement
from spacar.deck.table_elements import ELEMENT_TYPES
from spacar.deck.table_types import ELEMENT_CLASSES, NODE_CLASSES

_DONE = {
    "fixed": "fixed", "prescribed": "prescribed", "dynamic": "declared dynamic", "kinematic": "declared kinematic",
    "calculable": "released",
}  # fmt: skip


def classify(scene: CheckMaterial) -> None:
    """Fill the classes of the scene; one thing in two classes is an error, twice in one class a warning."""
    outline = scene.outline
    _put(scene, "coordinate", outline.independent, NODE_CLASSES, scene.coordinates)
    _put(scene, "mode", outline.classed, ELEMENT_CLASSES, scene.deformations)
    _check_euler_parameters(scene)
    _check_kinematic(scene)


def _without_released(scene: CheckMaterial, s: Statement, indices: tuple[int, ...]) -> tuple[int, ...]:
    """The modes that the statement can give a class to; others are an error, except for RLSE, which
    repeats what holds in any case."""
    number = s.integer(0)
    released = scene.outline.types[number].released
    if not released:
        return indices
    if s.keyword != "RLSE":
        for place, index in enumerate(s.integers(1), 1):
            if index in released:
                kind = scene.outline.types[number]
                text = f"mode {index} ({kind.modes[index - 1][0]}) of the {kind.keyword} is always calculable: it"
                text += " follows from its warping node; to prescribe warping give FIX or INPUTX for that node"
                scene.findings.error(s, place, text, "released-mode")
    return tuple(i for i in indices if i not in released)


def _put(
    scene: CheckMaterial, noun: str, every: Callable[[int], tuple[int, ...]], names: Mapping[str, str], classes: Classes
) -> None:
    """Give a class to what the statements name, or, without numbers, to `every` coordinate or mode."""
    count = 0
    for group in scene.index.groups_of(*names, block=1):
        name = names[group.keyword]
        for place, (number, *indices) in enumerate(group.rows()):
            this = name, group, place
            for index in indices or every(number):
                classes[number, index] = this
                count += 1
    if len(classes) == count and not (noun == "mode" and "released" in scene.outline.traits):
        return
    classes.clear()
    for s in scene.index.of(*names, block=1):
        given = s.integers(1) or every(s.integer(0))
        if noun == "mode":
            given = _without_released(scene, s, given)
        _put_one(scene, s, noun, given, names[s.keyword], classes)


def _put_one(
    scene: CheckMaterial, s: Statement, noun: str, indices: tuple[int, ...], name: str, classes: Classes
) -> None:
    number = s.integer(0)
    again: dict[int, list[int]] = {}
    this = name, (s,), 0
    for place, index in enumerate(indices, 1):
        before = classes.setdefault((number, index), this)
        if before is this and index not in indices[: place - 1]:
            continue
        by = before[1][before[2]]
        if before[0] == name:
            again.setdefault(by.line, []).append(index)
        else:
            text = f"{noun} {index} cannot be {name}: it was {_DONE[before[0]]} by {by.keyword} at line {by.line}"
            scene.findings.error(s, place, text, "two-classes")
    for line, (*others, last) in again.items():
        which = f"{noun}s {', '.join(map(str, others))} and {last} were" if others else f"{noun} {last} was"
        scene.findings.warning(s, 1, f"{which} already {_DONE[name]} at line {line}", "repeated")


def _check_euler_parameters(scene: CheckMaterial) -> None:
    """At most three of the four Euler parameters of a node can be given: the normalization gives the fourth."""
    if scene.outline.space == "planar":
        return
    with_fourth = {node for node, index in scene.coordinates if index == 4 and (node, 1) in scene.coordinates}
    for node in filter(with_fourth.__contains__, scene.outline.roles if with_fourth else ()):
        by = [s for i in (1, 2, 3, 4) if (s := scene.giver("node", node, i)) is not None]
        if len(by) == 4:
            last = max(by, key=lambda s: s.line)
            lines = ", ".join(map(str, sorted({s.line for s in by})))
            text = f"all four Euler parameters of node {node} are given (lines {lines}): over-determines their"
            text += " normalization; leave lambda0 (coordinate 1) calculable"
            scene.findings.error(last, None, text, "normalization")


def _check_kinematic(scene: CheckMaterial) -> None:
    if not scene.outline.complete or "slips" in scene.outline.traits:
        return
    for s in scene.index.of("KINX", "KINE"):
        wheels = ", ".join(t.keyword for t in ELEMENT_TYPES.values() if t.slips)
        text = f"there is no non-holonomic element ({wheels}), so no kinematic coordinate can exist"
        scene.findings.error(s, None, text, "no-wheel")
