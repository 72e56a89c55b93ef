"""The page of `spacar flexure`: facts, extremes, pictures over the stroke, plots, tables; it holds all it shows."""

from __future__ import annotations

from html import escape

import numpy as np

from spacar.stroke import Flexure
from spacar.stroke.flexure_results import Column
from spacar_drawing.defaults import plain
from spacar_drawing.mechanism_picture import Extras
from spacar_drawing.moving_figure import evenly
from spacar_drawing.page_parts import html_figure, html_table, page
from spacar_drawing.picture_source import PictureSource, source_of_result
from spacar_drawing.step_pictures import picture
from spacar_drawing.stress_picture import stress_still
from spacar_drawing.stroke_figures import all_figures
from spacar_drawing.stroke_tables import cell_text, matters, shown_column, stroke_tables

SHOWN = 5  # states in the picture over the stroke
FLAT = 0.02  # of the largest displacement: a motion in a coordinate plane


@plain
def stroke_page(study: Flexure, view: str | None = None, body: bool = False) -> str:
    """The page as text. `view` of spatial pictures (None: the plane of the motion, iso for stresses); `body`: stiffness
    along axes of the node."""
    source = source_of_result(study.result)
    parts = [_facts(study), _warnings(study), _extremes(study, body), _pictures(study, source, view)]
    parts += ["<h2>Over the stroke</h2>"]
    parts += [html_figure(figure, caption) for figure, caption in all_figures(study, body)]
    for table in stroke_tables(study, body):
        parts.append(f"<h2>{escape(table.title)}</h2>" + html_table(table.rows, table.heads, "numbers"))
        if table.note:
            parts.append(f"<p>{escape(table.note[0].upper() + table.note[1:])}.</p>")
    return page(f"{source.scene.title}: flexure", parts)


def _facts(study: Flexure) -> str:
    stroke = Column("stroke", "", study.move.unit, study.stroke)
    unit, values = shown_column(study, stroke)
    node = study.node
    beside = f" with orientation node {node.orientation}" if node.orientation else ""
    how = "loaded by a force" if study.move.pushed else "prescribed"
    rows = [
        ("Input", study.source),
        ("Drive", f"{study.move.text}, {how}"),
        ("Range", f"{cell_text(values[0])} to {cell_text(values[-1])} {unit}, {len(study)} states"),
        ("Node", f"{node.position}{beside}"),
        ("Ideal motion", "rotation about an axis" if study.errors.turning else "straight line"),
        ("Energy balance", _balance(study)),
    ]
    return html_table(rows, None, "facts")


def _balance(study: Flexure) -> str:
    """Strain energy against the work of all loads."""
    return f"strain energy and work of all loads differ by {study.imbalance:.1g} of it"


def _warnings(study: Flexure) -> str:
    return "".join(f'<p class="warn">{escape(line)}</p>' for line in study.warnings)


def extremes(study: Flexure, body: bool = False) -> list[tuple[str, ...]]:
    """Rows name, undeflected, at both ends, smallest and largest with the stroke where they are."""
    names = ["force", "drive_stiffness", "energy"]
    names += [f"k_{study.directions[i]}" for i in study.support]
    names += ["f_1", "f_drive", "margin", "margin_free"]
    names += ["margin_extra", "margin_extra_free", "mises"] if study.extra else ["mises"]
    kinds = ("pivot_", "tilt_") if study.errors.turning else ("line_",)
    names += [c.name for c in study.motion_columns() if c.name.startswith(kinds) and matters(study, c)]
    by_name = {c.name: c for c in study.columns(body)}
    where = shown_column(study, by_name["stroke"])[1]
    rows = []
    for name in names:
        c = by_name[name]
        unit, values = shown_column(study, c)
        known = np.isfinite(values)
        if not known.any() or not np.any(values[known]):
            continue
        low, high = (int(np.flatnonzero(known)[f(values[known])]) for f in (np.argmin, np.argmax))
        text = ["none" if np.isinf(v) and "margin" in name else cell_text(v) for v in values[[study.zero, 0, -1]]]
        ends = [f"{cell_text(values[k])} at {cell_text(where[k])}" for k in (low, high)]
        rows.append((f"{c.title} ({unit})" if unit else c.title, *text, *ends))
    return rows


def _extremes(study: Flexure, body: bool) -> str:
    unit = shown_column(study, Column("stroke", "", study.move.unit, study.stroke))[0]
    head = ("", "undeflected", "first", "last", f"smallest at ({unit})", f"largest at ({unit})")
    return "<h2>Key results</h2>" + html_table(extremes(study, body), head, "numbers")


def _pictures(study: Flexure, source: PictureSource, view: str | None) -> str:
    """The range of motion, the undeflected state in full where it is inside; the largest stress."""
    numbers = evenly(1, len(study), SHOWN)
    undeflected = 0 < study.zero < len(study) - 1
    if undeflected:
        numbers = [*(k for k in numbers if k != study.zero + 1), study.zero + 1]
    extras = Extras(view=view or _plane(study), title="")
    full = "undeflected" if undeflected else "last"
    out = "<h2>Range of motion</h2>" + html_figure(
        picture(source, extras, numbers, [study.node.position], False),
        f"{len(numbers)} states of the stroke, the {full} one in full, and the path of node {study.node.position}.",
    )
    stress, element, place = study.largest_stress
    if np.isfinite(stress).any() and np.nanmax(stress) > 0.0:
        k = int(np.nanargmax(stress))
        still = stress_still(
            source.scene, source.x(k + 1), source.get("sig", k + 1), source.get("e", k + 1), source.settings,
            Extras(view=view or "iso", title=""), "mises",
        )  # fmt: skip
        unit, where = shown_column(study, Column("stroke", "", study.move.unit, study.stroke))
        at = {0.0: "at its end p", 1.0: "at its end q"}.get(float(place[k]), f"at {place[k]:.3g} of its length")
        text = f"Von Mises stress at {cell_text(where[k])} {unit}, where it is largest: in element {element[k]} {at}."
        out += html_figure(still, text)
    return out


def _plane(study: Flexure) -> str:
    """The coordinate plane in which the node moves, or to which its axis is normal; else a view from above."""
    e = study.errors
    if e.turning and np.abs(e.axis).max() > 1.0 - FLAT:
        return ("yz", "xz", "xy")[int(np.argmax(np.abs(e.axis)))]
    size = np.abs(e.displacement).max(axis=0)
    k = int(np.argmin(size))
    return ("yz", "xz", "xy")[k] if size[k] < FLAT * size.max() else "iso"
