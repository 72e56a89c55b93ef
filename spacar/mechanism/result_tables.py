"""What result files say once a run: sizes, tables and parameters of the model, by their MATLAB names
(files.md section 4).

Tables have a row for every node or element number up to the highest, zero where the number is not used.
"""

from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.numbering import Numbering

# Statements whose values behind the element number are rows of a table: name of the table, keyword, width.
PARAMETERS = (("estiff", "ESTIFF", 6), ("edamp", "EDAMP", 6), ("em", "EM", 9), ("esig", "ESIG", 6))
# Table kdform (files.md section 4) by measure and LDEFORM.
KDFORM = {("", True): 0, ("", False): 1, ("angle", False): 2, ("angle", True): 3}
WIDER = {"estiff": 7, "edamp": 7, "esig": 8, "einit": 8}  # in a model with warping (theory-warping.md section 7)


def model_tables(mechanism: Mechanism) -> dict[str, Any]:
    """All of them, in the order of the files.

    ndof nddof nkdof nkddof nx ne (numbers); nxp nep (5,); lnp (nodes, 4), le (elements, 6), ln (elements, 4), it
    (1, elements); kdform rl0 [m] (elements,); rxyz rxyzq (elements, 9); dr0 (elements, k) [m]; estiff edamp esig einit
    (elements, 6), em (elements, 9); x0 (nx,) start coordinates, xm (nodes, 6) lumped masses [kg] and inertias [kg m^2],
    grav (3,) gravity [m/s^2] without load increments. With warping le (elements, 8), ln (elements, 6), widths of WIDER.
    """
    n = mechanism.numbering
    tables = counts(n) | {"nx": n.nx, "ne": n.ne, "nxp": n.nxp, "nep": n.nep}
    tables |= {"lnp": n.lnp, "le": n.le, "ln": n.ln, "it": n.it.reshape(1, -1)}
    tables |= _elements(mechanism)
    wider = WIDER if n.warped else {}
    for name, keyword, width in PARAMETERS:
        tables[name] = _parameters(mechanism, keyword, len(n.le), wider.get(name, width))
    tables["einit"] = _initial_deformations(mechanism, wider.get("einit", 6))
    masses, gravity = _parameters(mechanism, "XM", len(n.lnp), 6), np.zeros(3)
    for given in mechanism.deck.index.rows("GRAVITY", 2):
        gravity[: len(given)] = given
    return tables | {"x0": mechanism.x0, "xm": masses, "grav": gravity}


def counts(n: Numbering) -> dict[str, int]:
    """Degrees of freedom: all, dynamic, and the same with the kinematic coordinates."""
    return {"ndof": n.ndof, "nddof": n.nddof, "nkdof": n.nkdof, "nkddof": n.nkddof}


def _elements(mechanism: Mechanism) -> dict[str, Array]:
    """kdform, rxyz, rxyzq, dr0, rl0 of the element families."""
    rows = len(mechanism.numbering.le)
    linear = {int(s.values[0]) for s in mechanism.deck.of("LDEFORM", block=1)}
    elements = [b.family for b in mechanism.batches if b.family.keyword in ELEMENT_TYPES]
    width = max((f.data.shape[1] for f in elements if f.data is not None), default=1)
    kdform, length = np.zeros(rows, np.int64), np.zeros(rows)
    frame_p, frame_q, data = np.zeros((rows, 9)), np.zeros((rows, 9)), np.zeros((rows, width))
    for family in elements:
        here = family.numbers - 1
        if ELEMENT_TYPES[family.keyword].shape == "beam":
            kdform[here] = [KDFORM[family.measure, int(i) in linear] for i in family.numbers]
        length[here] = family.length
        for table, value in ((frame_p, family.frame_p), (frame_q, family.frame_q)):
            if value is not None:
                table[here] = value
        if family.data is not None:
            data[here, : family.data.shape[1]] = family.data
    return {"kdform": kdform, "rxyz": frame_p, "rxyzq": frame_q, "dr0": data, "rl0": length}


def _parameters(mechanism: Mechanism, keyword: str, rows: int, width: int) -> Array:
    """(rows, width): the values of a dynamics statement behind its element or node number, those of the last one."""
    table = np.zeros((rows, width))
    for number, *values in mechanism.deck.index.rows(keyword, 2):
        values = values[:width]
        table[int(number) - 1, : len(values)] = values
    return table


def _initial_deformations(mechanism: Mechanism, width: int) -> Array:
    """(highest element, width): start values of prescribed and dynamic deformations, zero elsewhere."""
    table = np.zeros((len(mechanism.numbering.le), width))
    for s in mechanism.deck.of("INPUTE", "STARTDE", block=2):
        if len(s.values) > 2:
            table[int(s.values[0]) - 1, int(s.values[1]) - 1] = s.values[2]
    return table
