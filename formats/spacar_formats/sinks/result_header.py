"""Header variables of the result files: what a run knows with its first step (reference/files.md 3 to 6)."""

from __future__ import annotations

from collections.abc import Container
from typing import Any

import numpy as np

import spacar
from spacar.mechanism.result_tables import counts, model_tables
from spacar.stream import Run
from spacar_formats.sbf.variable_names import identifier
from spacar_formats.signal_names import state_names

LTV_COUNTS = ("NNOM", "NX", "NU", "NY", "NRBM", "NYS", "NYSI", "DFT", "X0")


def provenance(run: Run) -> dict[str, Any]:
    """Which program, from which input: the text variables of files.md section 9."""
    deck = run.mechanism.deck
    return {
        "VERSION": f"spacar {spacar.__version__}", "SOURCE": deck.source, "SHA256": deck.sha256,
        "MODE": run.mode.number,
    }  # fmt: skip


def sbd_header(run: Run, stored: Container[str] = ()) -> dict[str, Any]:
    """Everything of files.md section 4 that does not change with time."""
    n = run.mechanism.numbering
    keywords = [n.keyword.get(i, "") for i in range(1, len(n.le) + 1)]
    tables = {identifier(name): value for name, value in model_tables(run.mechanism).items()}
    return provenance(run) | {"ETYPE": keywords} | _accuracy(run) | tables


def _accuracy(run: Run) -> dict[str, Any]:
    """Of a run with an accuracy: ACCURACY = estimated error, error asked for (0: none), cost; ACCWAY: how, in words."""
    found = run.header.get("accuracy")
    if found is None:
        return {}
    return {"ACCURACY": np.array([found.estimate, found.target or 0.0, found.cost]), "ACCWAY": [found.way]}


def sbm_header(run: Run, stored: Container[str] = ()) -> dict[str, Any]:
    """Sizes of the matrices (files.md section 5)."""
    sizes = {name.upper(): value for name, value in counts(run.mechanism.numbering).items()}
    return provenance(run) | sizes | {"NNOM": int(run.header.get("NNOM", 0))}


def ltv_header(run: Run, stored: Container[str]) -> dict[str, Any]:
    """Sizes, indices, initial state, names of the signals (files.md section 6); DFT: whether D is stored."""
    header = provenance(run) | {"NNOM": 0, "NU": 0, "NY": 0}
    if "A" in stored:
        header["DFT"] = int("D" in stored)
    header |= {ident: run.header[ident] for ident in LTV_COUNTS if ident in run.header}
    linear = "A" in stored or "ASP" in stored
    names = {"UNAMES": run.header.get("inputs"), "YNAMES": run.header.get("outputs")}
    if linear:
        names["XNAMES"] = run.header.get("states") or state_names(run.mechanism.numbering)
    return header | {ident: list(lines) for ident, lines in names.items() if lines}
