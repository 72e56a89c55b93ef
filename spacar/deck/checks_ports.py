"""Checks of input and output numbers: 1 ... n, each once."""

from __future__ import annotations

from spacar.deck.check_material import CheckMaterial
from spacar.deck.findings import ranges
from spacar.deck.statement import Statement


def check_ports(scene: CheckMaterial) -> None:
    """The numbers are the positions in the vectors u and y, so there must be no gap and no second use."""
    used: dict[str, dict[int, Statement]] = {"input": {}, "output": {}}
    nouns = {name: scene.row(name, 3).variants[0].parameters[0].of for name in scene.index.keywords(3)}
    for s in scene.of(*(name for name, noun in nouns.items() if noun in used), block=3):
        noun, number = nouns[s.keyword], s.integer(0)
        first = used[noun].setdefault(number, s)
        if number < 1:
            scene.findings.error(s, 0, f"{noun} number {number} must be positive", "port-number")
        elif first is not s:
            text = f"{noun} number {number} is already used by {first.keyword} at line {first.line}"
            scene.findings.error(s, 0, text, "port-number")
    for noun, numbers in used.items():
        good = {n for n in numbers if n >= 1}
        if not good or max(good) == len(good) or 3 in scene.outline.broken_blocks:
            continue
        last = max(good)
        lowest = next(n for n in range(1, last) if n not in good)
        text = f"{noun} numbers must be 1 to n without gaps: {lowest} is missing, {ranges(good)} are used"
        scene.findings.error(numbers[last], 0, text, "port-number")
