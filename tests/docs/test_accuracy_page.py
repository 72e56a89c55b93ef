"""The numbers of docs/accuracy.md that examples give are those of this program, to the last digit of the page.

The other rows (closed forms to rounding, rods, solids) are tests of their rooms.
"""

import re
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest

import spacar

from .citations import DOCS, HOUSE
from .documents import NUMBER


def rows() -> list[tuple[str, str, str]]:
    """(example, quantity, numbers that hold here) of the page; an empty first cell repeats the example above it."""
    found, example = [], ""
    for line in re.findall(r"^\|(.*)\|$", (DOCS / "accuracy.md").read_text(encoding="utf-8"), re.MULTILINE)[2:]:
        name, quantity, published, here, _ = (cell.strip() for cell in line.split("|"))
        example = name or example
        found.append((example, quantity, here if NUMBER.search(here) else published))
    return found


def last(mode: int, example: str, variable: str, **options: Any) -> np.ndarray:
    return spacar.run(mode, HOUSE / "data" / f"{example}.dat", **options)[variable][-1]


def tip(beams: str) -> np.ndarray:
    return spacar.run(7, HOUSE / "data" / "plbeam5.dat", beams=beams).node(11)[-1]


COMPUTED = {
    ("`fourbar`", "dynamic stiffening N0"): lambda: last(4, "fourbar", "n0"),
    ("`massspring`", "eigenvalues of the rotating mass"): lambda: last(7, "massspring", "eigval")[::2, 1],
    ("`column2`", "buckling multiplier"): lambda: last(8, "column2", "lmult"),
    ("`lateral4`", "lateral buckling, four elements"): lambda: last(8, "lateral4", "lmult"),
    ("`lateral4`", "exact solution; four elements with ADEFORM"): lambda: last(8, "lateral4", "lmult", beams="angle"),
    ("`shear2`", "frequencies of a short beam"): lambda: (
        2 * np.pi * spacar.run(7, HOUSE / "data" / "shear2.dat").frequencies[-1]
    ),
    ("`plbeam5`", "tip of the bent cantilever"): lambda: tip("sine"),
    ("`plbeam5`", "elastica; five elements with ADEFORM"): lambda: tip("angle"),
    ("`crank`", "position; acceleration at the start"): lambda: [
        spacar.run(1, HOUSE / "data" / "crank.dat").node(6, 1, "xdd")[0]
    ],
    ("`robotinv`", "torques at rest at the end"): lambda: last(2, "robotinv", "u0")[1:],
    ("`trike2`, `trike3v`", "eigenvalues, planar against spatial"): lambda: last(7, "trike3v", "eigval")[:2, 0],
}


def agree(text: str, values: Iterable[float]) -> bool:
    """Whether the numbers of a text are the first of the values, rounded to the digits that it shows."""
    shown = NUMBER.findall(text.replace("−", "-"))
    return all(
        f"{value:.{len(number.partition('.')[2])}f}" == number for number, value in zip(shown, values, strict=False)
    )


@pytest.mark.parametrize(("example", "quantity", "text"), [r for r in rows() if r[:2] in COMPUTED])
def test_a_row_of_the_page(example: str, quantity: str, text: str) -> None:
    values = np.ravel(COMPUTED[example, quantity]())
    assert NUMBER.search(text)
    assert agree(text, values), (text, values)


def test_every_row_is_looked_at() -> None:
    """Rows that are not computed here name no example, or an error of rounding only, or matrices (`lever`)."""
    assert set(COMPUTED) <= {row[:2] for row in rows()}
    others = {example for example, quantity, _ in rows() if (example, quantity) not in COMPUTED}
    assert {name for name in others if name.startswith("`")} == {"`lever`", "`cardan`", "`slider`"}
