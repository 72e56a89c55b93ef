"""Tables of `spacar flexure`: the same rows for the terminal and for the page, in the unit of length of the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.deck.length_unit import shown_in
from spacar.stroke import Flexure
from spacar.stroke.flexure_results import Column

NOTHING = 1e-12  # of the size of the model, or rad: what is smaller is rounding and not shown
RIGID = "rigid"
MOST_FREQUENCIES = 3


@dataclass(frozen=True)
class StrokeTable:
    """A table with one row a state: heading, heads of the columns with units, texts, what is explained below it."""

    title: str
    heads: list[str]
    rows: list[list[str]]
    note: str = ""


def stroke_tables(study: Flexure, body: bool = False) -> list[StrokeTable]:
    """Force and energy, motion, support stiffness, frequencies with buckling and stress."""
    by_name = {c.name: c for c in study.columns(body)}
    chosen = [study.directions[i] for i in study.support]
    axes = "axes of the node" if body else "global axes"
    motion = [c for c in study.motion_columns() if not c.name.startswith("u_") or not study.errors.turning]
    first = [f"f_{i}" for i in range(1, 1 + min(MOST_FREQUENCIES, study.frequencies.shape[1]))]
    last = [*first, "f_drive", "margin", "margin_free", "mises", "mises_element", "mises_place"]
    ideal = "axis through the pole of the undeflected state" if study.errors.turning else "line of the undeflected state"
    return [
        _table(study, "Force and energy", [by_name[n] for n in ("force", "drive_stiffness", "work", "energy")]),
        _table(study, f"Motion of node {study.node.position}", [c for c in motion if _moves(study, c)],
               f"errors against the {ideal}"),
        _table(study, f"Support stiffness of node {study.node.position}, drive locked ({axes})",
               [by_name[f"k_{d}"] for d in chosen]),
        _table(study, "Remaining support stiffness", [by_name[f"remaining_{d}"] for d in chosen],
               "in % of the undeflected state"),
        _table(study, "Frequencies, buckling, stress", [by_name[n] for n in last if np.any(by_name[n].values == by_name[n].values)],
               "f_1, f_2 ... with the drive locked, f_1 is the first unwanted one; f_drive that of the free drive; "
               "margin: lowest load multiplier, locked and free"),
    ]  # fmt: skip


def shown_column(study: Flexure, column: Column) -> tuple[str, Array]:
    """Unit and values in the unit of length of the model; ratios in %."""
    if column.name.startswith("remaining"):
        return "%", 100.0 * column.values
    factor, unit = shown_in(column.unit, study.metre)
    return unit, factor * column.values


def cell_text(value: float, digits: int = 5) -> str:
    """`rigid` for an infinite stiffness, nothing for what is not known."""
    if value != value:
        return ""
    return RIGID if np.isinf(value) else f"{float(value) + 0.0:.{digits}g}"


def _moves(study: Flexure, column: Column) -> bool:
    length = study.result.mechanism.length if column.unit == "m" else 1.0
    return bool(np.nanmax(np.abs(column.values), initial=0.0) > NOTHING * length)


def _table(study: Flexure, title: str, columns: list[Column], note: str = "") -> StrokeTable:
    stroke = Column("stroke", "stroke", study.move.unit, study.stroke)
    columns = [stroke, *columns]
    heads, texts = [], []
    for c in columns:
        unit, values = shown_column(study, c)
        name = c.name.removeprefix("remaining_").replace("mises_", "").replace("_", " ")
        heads.append(f"{name} ({unit})" if unit and unit != "%" else name)
        texts.append([_text(c, v) for v in values.tolist()])
    return StrokeTable(title, heads, [list(row) for row in zip(*texts, strict=True)], note)


def _text(column: Column, value: float) -> str:
    if column.name.startswith("margin") and np.isinf(value):
        return "none"
    if column.name == "mises_element":
        return str(int(value)) if value else ""
    return cell_text(value, 4 if column.name.startswith("remaining") else 5)
