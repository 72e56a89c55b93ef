"""Tables of `spacar flexure`: the same rows for the terminal and for the page, in the unit of length of the model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.deck.length_unit import shown_in
from spacar.stroke import Flexure
from spacar.stroke.flexure_results import Column

NOTHING = 1e-12  # of the size of the model, or rad: what is smaller is rounding and not shown
TRACE = 1e-4  # of the largest one of the same kind
ROUNDING = 1e-13  # of the largest value of a column
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
    hidden = ("u_", "rotation_") if study.errors.turning else ()
    motion = [c for c in study.motion_columns() if not c.name.startswith(hidden) and matters(study, c)]
    first = [f"f_{i}" for i in range(1, 1 + min(MOST_FREQUENCIES, study.frequencies.shape[1]))]
    extra = [name for name in ("margin_extra", "margin_extra_free") if name in by_name]
    last = [*first, "f_drive", "margin", "margin_free", *extra, "mises", "mises_element", "mises_place"]
    ideal = "axis" if study.errors.turning else "line"
    if np.isnan(by_name["mises"].values).all():
        last = [name for name in last if not name.startswith("mises")]
    left = [by_name[f"remaining_{d}"] for d in chosen]
    tables = [
        _table(study, "Force and energy", [by_name[n] for n in ("force", "drive_stiffness", "work", "energy")]),
        _table(study, f"Motion of node {study.node.position}", motion,
               f"errors against the {ideal} of the undeflected state"),
        _table(study, f"Support stiffness of node {study.node.position}, drive locked ({axes})",
               [by_name[f"k_{d}"] for d in chosen]),
        _table(study, "Remaining support stiffness", [c for c in left if _known(c)],
               "in % of the undeflected state"),
        _table(study, "Frequencies, buckling, stress", [by_name[n] for n in last if _known(by_name[n])],
               "f 1, f 2 ... with the drive locked, f 1 is the first unwanted one; f drive: of the free drive; "
               "margin: lowest multiplier of all loads"
               + (f", margin extra: of {' and '.join(study.extra)} alone" if extra else "")),
    ]  # fmt: skip
    return [table for table in tables if len(table.heads) > 1]


def shown_column(study: Flexure, column: Column) -> tuple[str, Array]:
    """Unit and values in the unit of length of the model; ratios in %."""
    if column.name.startswith("remaining"):
        return "%", 100.0 * column.values
    factor, unit = shown_in(column.unit, study.metre)
    finite = np.abs(column.values[np.isfinite(column.values)])
    still = np.abs(column.values) <= ROUNDING * finite.max(initial=0.0)
    return unit, factor * np.where(still, 0.0, column.values)


def cell_text(value: float, digits: int = 5) -> str:
    """`rigid` for an infinite stiffness, nothing for what is not known."""
    if value != value:
        return ""
    return RIGID if np.isinf(value) else f"{float(value) + 0.0:.{digits}g}"


def _known(column: Column) -> bool:
    return not bool(np.isnan(column.values).all())


def matters(study: Flexure, column: Column) -> bool:
    """Is it more than rounding, and more than a trace beside the same of the other axes?"""
    kind = column.name[: column.name.rfind("_")]
    group = [c for c in study.motion_columns() if c.name[: c.name.rfind("_")] == kind]
    length = study.result.mechanism.length if column.unit == "m" else 1.0
    largest = max(float(np.nanmax(np.abs(c.values), initial=0.0)) for c in group)
    return bool(np.nanmax(np.abs(column.values), initial=0.0) > max(NOTHING * length, TRACE * largest))


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
