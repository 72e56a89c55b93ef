"""UNITS: the power of the metre in every number of a statement, from the units of the keyword table.

Where the table names no unit because it depends on the node or the deformation mode, it follows from virtual work:
sigma e, S e^2 and f x are energies, N m.
"""

import re
from collections.abc import Sequence

from spacar.deck.cross_section import SHAPES
from spacar.deck.statement import Value
from spacar.deck.table_types import ElementType, Parameter

_METRE = re.compile(r"m(?:\^(\d+))?\Z")
COORDINATE_POWER = {"position": 1, "orientation": 0, "warping": -1}
BY_COORDINATE = ("INPUTX", "STARTDX", "DELINPX", "TRVMAX")
BY_MODE = ("INPUTE", "STARTDE", "DELINPE", "TRE", "TREPMAX")


def metres(unit: str) -> int:
    """Power of the metre in a unit such as "N m^2" or "kg/m"."""
    power, *below = unit.split("/")
    return _count(power) - sum(_count(part) for part in below)


def _count(product: str) -> int:
    return sum(int(m[1] or 1) for word in product.split() if (m := _METRE.match(word)))


def shown_in(unit: str, metre: float) -> tuple[float, str]:
    """Factor on a number in SI, and the text of its unit, when it is shown with 1e-3 m (mm) as the unit of length."""
    if metre == 1.0:
        return 1.0, unit
    plain = unit.translate({ord("\N{SUPERSCRIPT TWO}"): "^2"})
    return metre ** -metres(plain), re.sub(r"\bm(?=[\^\N{SUPERSCRIPT TWO}]|\b)", "mm", unit)


def length_power(
    keyword: str, place: int, parameter: Parameter, values: Sequence[Value], kinds: Sequence[ElementType], role: str
) -> int:
    """Power of the metre of one real of a statement.

    place, parameter   of the number (from 0);  values  of the statement;  kinds  types of the elements that it names
    (MEE: two);  role  of its node
    """
    if keyword == "SECTION":
        shape = SHAPES.get(str(values[1]).upper())
        return shape.dims[place - 2][1] if shape is not None and place - 2 < len(shape.dims) else 1
    if keyword == "MATERIAL" and place == 2 and float(values[2]) <= 0.5:
        return 0  # Poisson's ratio
    if parameter.unit and not parameter.unit.startswith(("coefficient", "1/")) and keyword != "MEE":
        return metres(parameter.unit)
    if parameter.of or parameter.unit == "s":
        return 0
    if keyword in BY_COORDINATE:
        return COORDINATE_POWER.get(role, 0)
    if not kinds:
        return 0

    def mode(number: Value, of: int = 0) -> int:
        kind = kinds[min(of, len(kinds) - 1)]
        return metres(kind.modes[int(number) - 1][1]) if 1 <= int(number) <= len(kind.modes) else 0

    if keyword in BY_MODE:
        return mode(1 if keyword in ("TRE", "TREPMAX") else values[1])
    if keyword in ("ESIG", "DELESIG"):
        return 1 - mode(place)
    if keyword in ("ESTIFF", "EDAMP"):
        return 1 - 2 * mode(place)
    if keyword == "MEE":
        return 2 - mode(values[1]) - (mode(values[3], 1) if len(values) == 5 else mode(values[1]))
    return 0
