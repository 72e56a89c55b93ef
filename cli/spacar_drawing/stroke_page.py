"""The page of `spacar flexure`: five numbers, two pictures, lowest modes; folded: facts, extremes, curves, tables."""

from html import escape

import numpy as np

from spacar.expressions import unit_text
from spacar.stroke import Flexure
from spacar_drawing.defaults import plain
from spacar_drawing.files import evenly
from spacar_drawing.mechanism_picture import Extras, picture
from spacar_drawing.page_parts import folded, html_figure, html_table, page
from spacar_drawing.picture_source import PictureSource, source_of_result
from spacar_drawing.stress_picture import stress_still
from spacar_drawing.stroke_figures import (
    all_figures,
    by_name,
    cell_text,
    errors,
    frequencies,
    shown_column,
    stroke_tables,
    supported,
    symbols,
)

SHOWN = 5  # states in the picture over the stroke
MOST_MODES = 6
FLAT = 0.02  # of the largest displacement: a motion in a coordinate plane


@plain
def stroke_page(study: Flexure, view: str | None, body: bool) -> str:
    """The page as text: see `flexure_page` of drawing_calls."""
    source = source_of_result(study.result)
    curves = [html_figure(figure, caption) for figure, caption in all_figures(study, body)]
    tables = []
    for table in stroke_tables(study, body):
        tables.append(f"<h2>{escape(table.title)}</h2>" + html_table(table.rows, table.heads, "numbers"))
        if table.note:
            tables.append(f"<p>{escape(table.note[0].upper() + table.note[1:])}.</p>")
    unit = shown_column(study, by_name(study)["stroke"])[0]
    heads = ("", "undeflected", "first", "last", f"smallest at ({unit})", f"largest at ({unit})")
    parts = [
        "".join(f'<p class="warn">{escape(line)}</p>' for line in study.warnings),
        html_table(five_numbers(study, body), None, "five"), _pictures(study, source, view),
        _modes(study), folded("Over the stroke", curves),
        folded("Key results", [html_table(extremes(study, body), heads, "numbers")]), folded("Tables", tables),
        folded("Model and run", [_facts(study)]),
    ]  # fmt: skip
    return page(f"{source.scene.title}: flexure", parts)


def five_numbers(study: Flexure, body: bool) -> list[tuple[str, str]]:
    """Range, largest force of the actuator, least of the support stiffness, first unwanted frequency, largest stress;
    what is not known is left out."""
    columns = by_name(study, body)
    unit, stroke = shown_column(study, columns["stroke"])
    rows = [("Range of motion", f"{cell_text(stroke[0])} to {cell_text(stroke[-1])} {unit}")]

    def add(title: str, names: list[str], lowest: bool) -> None:
        known = [columns[n] for n in names if np.isfinite(columns[n].values).any()]
        if not known:
            return
        shown = [shown_column(study, c) for c in known]
        sizes = [np.where(np.isfinite(v), v if lowest else np.abs(v), np.inf if lowest else -np.inf) for _, v in shown]
        best = min if lowest else max
        k = best(range(len(known)), key=lambda i: best(sizes[i]))
        at = int(sizes[k].argmin() if lowest else sizes[k].argmax())
        of = f", {known[k].title.partition(', ')[2]}" if len(names) > 1 else ""
        value = f"{cell_text(shown[k][1][at], 4)} {unit_text(symbols(shown[k][0]))}"
        rows.append((title, f"{value}{of}, at {cell_text(stroke[at])} {unit}"))

    add("Largest actuator moment" if study.move.force_unit == "N m" else "Largest actuator force", ["force"], False)
    add("Least of a support stiffness that remains", [f"remaining_{study.directions[i]}" for i in study.support], True)
    add("First unwanted frequency", ["f_1"], True)
    add("Largest von Mises stress", ["mises"], False)
    return rows


def _modes(study: Flexure) -> str:
    """The lowest frequencies with the drive locked, and that of the free drive."""
    count = min(MOST_MODES, study.frequencies.shape[1])
    known = [study.frequencies[:, i] for i in range(count) if np.isfinite(study.frequencies[:, i]).any()]
    if not known:
        return ""
    rows = [
        (name, *(cell_text(values[k], 4) for k in (study.zero, 0, -1)))
        for name, values in (*((f"mode {i}, drive locked", f) for i, f in enumerate(known, 1)),
                             ("free drive", study.of("drive_hertz")))
    ]  # fmt: skip
    heads = ("frequency (Hz)", "undeflected", "first state", "last state")
    return "<h2>Lowest modes</h2>" + html_table(rows, heads, "numbers")


def _facts(study: Flexure) -> str:
    unit, values = shown_column(study, by_name(study)["stroke"])
    node = study.node
    beside = f" with orientation node {node.orientation}" if node.orientation else ""
    how = "loaded by a force" if study.move.pushed else "prescribed"
    rows = [
        ("Input", study.source), ("Drive", f"{study.move.text}, {how}"),
        ("Range", f"{cell_text(values[0])} to {cell_text(values[-1])} {unit}, {len(study)} states"),
        ("Node", f"{node.position}{beside}"),
        ("Ideal motion", "rotation about an axis" if study.errors.turning else "straight line"),
        ("Energy balance", f"strain energy and work of all loads differ by {study.imbalance:.1g} of it"),
    ]  # fmt: skip
    return html_table(rows, None, "facts")


def extremes(study: Flexure, body: bool) -> list[tuple[str, ...]]:
    """Rows name, undeflected, at both ends, smallest and largest with the stroke where they are."""
    columns = by_name(study, body)
    some = [name for name in frequencies(study) if not name.startswith("f_") or name in ("f_1", "f_drive")]
    shown = [columns[name] for name in ("force", "drive_stiffness", "energy")] + supported(study, columns, "k")
    shown += [columns[name] for name in some] + errors(study, ("pivot_", "tilt_"), ("line_",))
    where = shown_column(study, columns["stroke"])[1]
    rows = []
    for c in shown:
        unit, values = shown_column(study, c)
        known = np.isfinite(values)
        if not known.any() or not np.any(values[known]):
            continue
        low, high = (int(np.flatnonzero(known)[f(values[known])]) for f in (np.argmin, np.argmax))
        text = ["none" if np.isinf(v) and "margin" in c.name else cell_text(v) for v in values[[study.zero, 0, -1]]]
        ends = [f"{cell_text(values[k])} at {cell_text(where[k])}" for k in (low, high)]
        rows.append((f"{c.title} ({unit})" if unit else c.title, *text, *ends))
    return rows


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
        still = stress_still(source, k + 1, Extras(view=view or "iso", title=""), "mises")
        unit, where = shown_column(study, by_name(study)["stroke"])
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
