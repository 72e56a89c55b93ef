"""Units of signals from their names: "OUTXP node 8 x" is a speed, "INPUTS element 1 (HINGE) e1 ..." a moment.

The letters behind the kind of a coordinate tell its derivative (P, DP), and S or F an input or output that is its dual.
"""

from __future__ import annotations

import re

from spacar.deck import ELEMENT_TYPES
from spacar.expressions import NONE, Dimensions, Unit

KIND = re.compile(r"(?:IN|OUT|NOM|REF|INPUT)(E|X|S|F)(DP|P|S)? ")
NODE = re.compile(r"node \d+ (?:([xyz])|w|phi|lambda\d)")
ELEMENT = re.compile(r"element \d+ \((\w+)\) e(\d+)")
DERIVATIVES = {"P": 1, "DP": 2}


def signal_unit(name: str) -> Unit | None:
    """None: the name does not tell."""
    kind = KIND.match(name)
    if kind is None:
        return None
    letter, order = kind[1], DERIVATIVES.get(kind[2] or "", 0)
    rest = name[kind.end() :]
    if (node := NODE.match(rest)) is not None:
        variable = "fx" if letter == "F" else ("x", "xd", "xdd")[order]
        units = Dimensions(" phi" in rest, False, (1,) if node[1] else (), ())
        return units(variable, (1, 1)) if " w" not in rest else NONE
    element = ELEMENT.match(rest)
    if element is None or element[1] not in ELEMENT_TYPES:
        return None
    mode = int(element[2])
    if not 1 <= mode <= len(ELEMENT_TYPES[element[1]].modes):
        return None
    variable = "sig" if letter == "S" else ("e", "ed", "edd")[order]
    return Dimensions(True, False, (), (element[1],))(variable, (1, mode))
