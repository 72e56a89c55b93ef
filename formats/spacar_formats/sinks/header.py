"""Header variables of the result files: what a run knows with its first step (reference/files.md 3 to 6)."""

from __future__ import annotations

from collections.abc import Container
from typing import Any

import numpy as np
from numpy.typing import NDArray

import spacar
from spacar.deck import ELEMENT_TYPES
from spacar.mechanism.mechanism import Mechanism
from spacar.stream import Run
from spacar_formats.signals import state_names

Array = NDArray[np.float64]

# Keywords whose numbers after the element number are stored as rows of a table: width of the table.
PARAMETERS = {"STIF": ("ESTIFF", 6), "EDAMP": ("EDAMP", 6), "EM": ("EM", 9), "ESIG": ("ESIG", 6)}
QUADRATIC = ("PLBEAM", "BEAM", "PLTUBE", "TUBE")  # types with second order terms in their strains
LTV_COUNTS = ("NNOM", "NX", "NU", "NY", "NRBM", "NYS", "NYSI", "DFT", "X0")


def provenance(run: Run) -> dict[str, Any]:
    """Which program, from which input: the text variables of files.md section 9."""
    deck = run.mechanism.deck
    return {
        "VERSION": f"spacar {spacar.__version__}",
        "SOURCE": deck.source,
        "SHA256": deck.sha256,
        "MODE": run.mode.number,
    }


def counts(run: Run) -> dict[str, Any]:
    """Degrees of freedom: all, dynamic, and the same with the kinematic coordinates."""
    n = run.mechanism.numbering
    return {"NDOF": n.ndof, "NDDOF": n.nddof, "NKDOF": n.nkdof, "NKDDOF": n.nkddof}


def sbd_header(run: Run, stored: Container[str] = ()) -> dict[str, Any]:
    """Everything of files.md section 4 that does not change with time."""
    mechanism = run.mechanism
    n = mechanism.numbering
    rows = len(n.le)
    keywords = [n.keyword.get(i, "") for i in range(1, rows + 1)]
    header = provenance(run) | {"ETYPE": keywords} | counts(run)
    header |= {"NX": n.nx, "NE": n.ne, "NXP": n.nxp, "NEP": n.nep}
    header |= {"LNP": n.lnp, "LE": n.le, "LN": n.ln, "IT": n.it.reshape(1, -1)}
    header |= element_tables(mechanism)
    for ident, (keyword, width) in PARAMETERS.items():
        header[ident] = parameters(mechanism, keyword, width)
    header["EINIT"] = initial_deformations(mechanism)
    return header


def element_tables(mechanism: Mechanism) -> dict[str, Array]:
    """KDEF, RXYZ, RQ, DR0, RL0: a row for every element number up to the highest, zero if unused."""
    rows = len(mechanism.numbering.le)
    linear = {int(s.values[0]) for s in mechanism.deck.of("LDEFORM", block=1)}
    elements = [b.family for b in mechanism.batches if b.family.keyword in ELEMENT_TYPES]
    width = max((f.data.shape[1] for f in elements if f.data is not None), default=1)
    kdef, length = np.zeros(rows, np.int64), np.zeros(rows)
    frame_p, frame_q, data = np.zeros((rows, 9)), np.zeros((rows, 9)), np.zeros((rows, width))
    for family in elements:
        here = family.numbers - 1
        if family.keyword in QUADRATIC:
            kdef[here] = [int(i) not in linear for i in family.numbers]
        length[here] = family.length
        for table, value in ((frame_p, family.frame_p), (frame_q, family.frame_q)):
            if value is not None:
                table[here] = value
        if family.data is not None:
            data[here, : family.data.shape[1]] = family.data
    return {"KDEF": kdef, "RXYZ": frame_p, "RQ": frame_q, "DR0": data, "RL0": length}


def parameters(mechanism: Mechanism, keyword: str, width: int) -> Array:
    """(highest element, width): the values of a dynamics statement behind the element number."""
    table = np.zeros((len(mechanism.numbering.le), width))
    for s in mechanism.deck.of(keyword, block=2):
        values = s.values[1 : 1 + width]
        table[int(s.values[0]) - 1, : len(values)] = values
    return table


def initial_deformations(mechanism: Mechanism) -> Array:
    """(highest element, 6): start values of prescribed and dynamic deformations, zero elsewhere."""
    table = np.zeros((len(mechanism.numbering.le), 6))
    for s in mechanism.deck.of("INPUTE", "STARTDE", block=2):
        if len(s.values) > 2:
            table[int(s.values[0]) - 1, int(s.values[1]) - 1] = s.values[2]
    return table


def sbm_header(run: Run, stored: Container[str] = ()) -> dict[str, Any]:
    """Sizes of the matrices (files.md section 5)."""
    return provenance(run) | counts(run) | {"NNOM": int(run.header.get("NNOM", 0))}


def ltv_header(run: Run, stored: Container[str]) -> dict[str, Any]:
    """Sizes, indices, initial state, names of the signals (files.md section 6); DFT: whether D is stored."""
    header = provenance(run) | {"NNOM": 0, "NU": 0, "NY": 0}
    if "A" in stored:
        header["DFT"] = int("D" in stored)
    header |= {ident: run.header[ident] for ident in LTV_COUNTS if ident in run.header}
    names = {"UNAMES": run.header.get("inputs"), "YNAMES": run.header.get("outputs")}
    if "A" in stored:
        names["XNAMES"] = state_names(run.mechanism.numbering)
    return header | {ident: list(lines) for ident, lines in names.items() if lines}
