"""The settings of the VISUALIZATION section: what each is for and what stands behind it, for `check` and `keywords`."""

from __future__ import annotations

from typing import NamedTuple


class Rule(NamedTuple):
    """Numbers behind a setting: how many (None: any number), their kind, and what they are."""

    how_many: int | None
    kind: str  # element, node, unit (0 to 1), switch (0 or 1), positive, real, number (integer from 1), shape
    what: str
    help: str


RULES = {
    "BEAMPROPS": Rule(
        None,
        "element",
        "element numbers",
        "heading: the lines CROSSTYPE and CROSSDIM behind it are for these beams, without numbers for all",
    ),
    "TRUSSPROPS": Rule(
        None,
        "element",
        "element numbers",
        "heading: the lines CROSSTYPE and CROSSDIM behind it are for these trusses, without numbers for all",
    ),
    "GRAPHICS": Rule(
        None,
        "element",
        "element numbers",
        "heading: the lines FACECOLOR and OPACITY behind it are for these elements, without numbers for all",
    ),
    "DONOTDRAW": Rule(None, "element", "element numbers", "leave elements out of the picture"),
    "INITIAL": Rule(0, "real", "", "heading: the line COLOR behind it is for the outline of the position at rest"),
    "CROSSTYPE": Rule(1, "shape", "shape", "shape of a cross-section: RECT, RECTHOL, CIRC, CIRCHOL, I or LINE"),
    "CROSSDIM": Rule(None, "positive", "dimensions", "dimensions of the cross-section in the order of BEAMVIS [m]"),
    "BEAMVIS": Rule(
        None,
        "section",
        "shape, element numbers and dimensions",
        "cross-section of beams: shape (RECT when left out), element numbers (none: all), dimensions [m]",
    ),
    "TRUSSVIS": Rule(None, "section", "shape, element numbers and dimensions", "cross-section of trusses, as BEAMVIS"),
    "HINGEVIS": Rule(3, "hinge", "numbers: element, radius, length", "size of a hinge: element, radius, length [m]"),
    "FACECOLOR": Rule(
        3, "unit", "numbers from 0 to 1: red, green, blue", "colour of elements: red, green, blue from 0 to 1"
    ),
    "COLOR": Rule(
        3,
        "unit",
        "numbers from 0 to 1: red, green, blue",
        "colour of the position at rest: red, green, blue from 0 to 1",
    ),
    "OPACITY": Rule(1, "unit", "number from 0 to 1", "opacity of elements: 0 cannot be seen, 1 is opaque"),
    "TRANSPARENCY": Rule(1, "unit", "number from 0 to 1", "opacity of all solids: 0 cannot be seen, 1 is opaque"),
    "LIGHT": Rule(1, "switch", "number, 0 or 1", "shade solids (1) or not (0)"),
    "TRAJECT": Rule(1, "switch", "number, 0 or 1", "draw the paths of TRAJECTNODE (1) or not (0)"),
    "TRAJECTNODE": Rule(None, "node", "node numbers", "nodes whose paths are drawn"),
    "STEPLINE": Rule(1, "positive", "positive number", "distance of the points on an elastic line, in element lengths"),
    "ENLARGEFACTOR": Rule(1, "real", "number", "factor on a mode whose degrees of freedom have norm 1"),
    "VIBRATIONMODE": Rule(1, "number", "mode number", "the vibration mode that spacar visual shows"),
    "BUCKLINGMODE": Rule(1, "number", "mode number", "the buckling mode that spacar visual shows"),
}
SPELLINGS = {"FACECOLOUR": "FACECOLOR", "COLOUR": "COLOR", "TRANSPERANCY": "TRANSPARENCY"}
NEEDS_GROUP = {
    "CROSSTYPE": ("BEAMPROPS", "TRUSSPROPS"),
    "CROSSDIM": ("BEAMPROPS", "TRUSSPROPS"),
    "FACECOLOR": ("GRAPHICS",),
    "OPACITY": ("GRAPHICS",),
    "COLOR": ("INITIAL",),
}
