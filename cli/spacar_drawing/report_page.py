"""The report of a run: a self-contained HTML page with embedded pictures, without scripts but that of the viewer."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from html import escape

import numpy as np

from spacar.deck import ELEMENT_TYPES
from spacar.errors import UsageError
from spacar_drawing.curves import Curve, evaluate, in_units
from spacar_drawing.defaults import plain
from spacar_drawing.files import evenly
from spacar_drawing.history import axis_text, history_figure
from spacar_drawing.look import extent_of
from spacar_drawing.mechanism_picture import Extras, picture
from spacar_drawing.mode_picture import constraint_still, constraints, mode_still
from spacar_drawing.mode_shapes import modes_of, suitable_factor
from spacar_drawing.page_parts import html_figure, html_table, number_text, page
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.scene import Scene

MOST_CURVES = 12
MOST_MODES = 4
_NAMED = (("Coordinates", "QNAME"), ("Speeds", "SNAME"), ("Inputs", "UNAME"), ("Outputs", "YNAME"))


@plain
def report_page(
    source: PictureSource, expressions: Sequence[str] = (), log_lines: int = 120, view: str = "iso",
    viewer: bool = False, symbols: Sequence[str] = (),
) -> str:  # fmt: skip
    """The page of a result as text: see `report` of drawing_calls."""
    scene = source.scene
    extras = Extras(view=view, title="")
    parts = [_summary(source), _model(source, extras, tuple(symbols))]
    if viewer:  # the page of `spacar view` in a frame of its own, which cannot reach this page
        from spacar_drawing.viewer_page import view_page

        frame = f'sandbox="allow-scripts" title="motion" srcdoc="{escape(view_page(source, view=view), quote=True)}"'
        parts.append(f'<h2>Motion</h2><iframe class="viewer" {frame}></iframe>')
    parts.append(_freedoms(source))
    if not source.named and not scene.analysis.forces:
        parts.append(_constraints(source, extras))
    if scene.analysis.stationary:
        parts.append(_modes(source, extras))
    curves = [evaluate(source, text) for text in expressions] or key_curves(source)
    curves = [in_units(c, scene.metre) for c in curves]
    resting = [] if expressions else [c for c in curves if not np.any(c.values)]  # what was asked for is always shown
    curves = [c for c in curves if all(c is not r for r in resting)]
    parts.append(_results(source, curves, resting))
    if source.steps > 2 and curves:
        figure = history_figure(curves, evaluate(source, "t"), "", scene.analysis.stationary)
        parts.append("<h2>Plots</h2>" + html_figure(figure, ", ".join(c.text for c in curves) + " over time."))
    parts.append(_log(source, log_lines))
    return page(scene.title, parts)


def key_curves(source: PictureSource) -> list[Curve]:
    """What a reader wants to see first: in inverse dynamics the stresses and motions of the hinges; else the degrees of
    freedom that the analysis found, what the prescribed ones need as driving forces or stresses, and the coordinates
    that move most."""
    if source.named:  # coordinates that are not amplitudes of fields, all when there is no other; outputs
        names = _texts(source, "QNAME")
        names = [name for name in names if not name.startswith("phi")] or names
        return [evaluate(source, name) for name in names + _texts(source, "YNAME")][:MOST_CURVES]
    scene = source.scene
    found = freedoms(scene)
    if scene.analysis.gives_setpoints or scene.analysis.takes_setpoints:
        joints = [e.number for e in scene.elements if e.shape == "hinge" and scene.e_class(e.number, 1) != "fixed"]
        if joints:
            texts = [f"{name}[{n},1]" for name in ("sig", "e") for n in joints[: MOST_CURVES // 2]]
            return [evaluate(source, text) for text in texts]
    texts = [text for text, _, kind in found if kind != "input"]
    for text, _, kind in found:
        # the force dual to an Euler parameter says nothing to a reader
        place = scene.planar or int(text[2:].partition(",")[0]) in scene.position_nodes
        if kind == "input" and (text[0] == "e" or place):
            texts.append(text.replace("x[", "fxtot[") if text[0] == "x" else text.replace("e[", "sig["))
    if len(texts) < MOST_CURVES:
        x = source.x()
        moves = [
            (float(np.ptp(x[:, scene.lnp[n - 1, i] - 1])), f"x[{n},{i + 1}]")
            for n in scene.position_nodes.tolist()
            for i in range(scene.dimension)
        ]
        largest = max((m for m, _ in moves), default=0.0)
        ranked = sorted((m for m in moves if m[0] > 1e-9 * (1.0 + largest)), key=lambda m: -m[0])[:3]
        texts += [text for _, text in ranked if text not in texts]
    return [evaluate(source, text) for text in texts[:MOST_CURVES]]


def _texts(source: PictureSource, name: str) -> list[str]:
    return [str(text) for text in source.header.get(name, [])]


def freedoms(scene: Scene) -> list[tuple[str, str, str]]:
    """(expression, description, class) of every degree of freedom and kinematic coordinate, in the order of q."""
    found: list[tuple[int, str, str, str]] = []
    rank = {"input": 0, "dynamic": 1, "kinematic": 4}
    for node, row in enumerate(scene.lnp, 1):
        for k in np.flatnonzero(row > 0).tolist():
            kind = scene.x_class(node, k + 1)
            if kind in rank:
                position = node in scene.position_nodes
                name = "xyz"[k] if position else "rotation" if scene.planar else f"\N{GREEK SMALL LETTER LAMDA}{k}"
                found.append((rank[kind], f"x[{node},{k + 1}]", f"node {node}, {name}", kind))
    for e in scene.elements:
        for m in np.flatnonzero(scene.le[e.number - 1] > 0).tolist():
            kind = scene.e_class(e.number, m + 1)
            if kind in rank:
                mode, place = ELEMENT_TYPES[e.keyword].modes[m][0], rank[kind] + (2 if kind != "kinematic" else 1)
                found.append((place, f"e[{e.number},{m + 1}]", f"{e.keyword} {e.number}, {mode}", kind))
    return [(text, words, kind) for _, text, words, kind in sorted(found, key=lambda f: f[0])]


def _summary(source: PictureSource) -> str:
    header, scene = source.header, source.scene
    mode = scene.analysis
    words = Counter(e.keyword for e in scene.elements)
    steps = str(source.steps)
    if not (scene.analysis.stationary or source.steps == 1):
        steps += f", t = {source.time(1):.6g} to {source.time(source.steps):.6g} s"
    rows = [
        ("Input", _text(header, "SOURCE")),
        ("Analysis", "spacar symbolic simulate" if source.named else f"mode {mode.number}: {mode.title}"),
        ("Program", _text(header, "VERSION")), ("Elements", ", ".join(f"{n} {k}" for k, n in words.items())),
        ("Nodes", f"{len(scene.position_nodes)} for positions, {len(scene.orientation_nodes)} for orientations"),
        ("Steps stored", steps),
        ("Input digest", f"SHA-256 {_text(header, 'SHA256')[:16]}\N{HORIZONTAL ELLIPSIS}"),
    ]  # fmt: skip
    warning = '<p class="warn">The run did not come to its end: the result is incomplete.</p>'
    return ("" if source.complete else warning) + html_table(rows, head=None, klass="facts")


def _text(header: object, name: str) -> str:
    value = np.ravel(header.get(name, [""]))  # type: ignore[attr-defined]
    return str(value[0]) if len(value) else ""


def _model(source: PictureSource, extras: Extras, symbols: tuple[str, ...]) -> str:
    scene = source.scene
    k = source.steps if scene.analysis.stationary else 1
    numbered = picture(source, replace(extras, node_numbers=True, element_numbers=True), [k], (), False)
    text = "Numbers of nodes (orientation nodes in brackets) and of elements (in boxes)."
    out = "<h2>Model</h2>" + html_figure(numbered, text)
    if symbols:
        marked = picture(source, replace(extras, symbols=symbols), [k], (), False)
        out += html_figure(marked, f"{', '.join(symbols).capitalize()} of step {k}.")
    if source.steps > 2 and not scene.analysis.stationary:
        chosen = evenly(1, source.steps, 9)
        if np.ptp([source.x(k) for k in chosen], axis=0).any():
            moving = picture(source, extras, chosen, (), False)
            out += html_figure(moving, f"{len(chosen)} evenly spread steps, the last one in full.")
    return out


def _freedoms(source: PictureSource) -> str:
    if source.named:
        facts = [(title, ", ".join(_texts(source, ident)) or "none") for title, ident in _NAMED]
        return "<h2>Quantities</h2>" + html_table(facts, head=None, klass="facts")
    found = freedoms(source.scene)
    counts = {kind: sum(f[2] == kind for f in found) for kind in ("input", "dynamic", "kinematic")}
    words = {"input": "prescribed", "dynamic": "dynamic", "kinematic": "kinematic"}
    text = ", ".join(f"{n} {words[k]}" for k, n in counts.items() if n) or "none"
    rows = [(str(i + 1), a, b, words[c]) for i, (a, b, c) in enumerate(found)]
    table = html_table(rows, ("", "variable", "meaning", "class")) if rows else ""
    if len(rows) > 30:
        table = f"<details><summary>all {len(rows)}</summary>{table}</details>"
    return f"<h2>Degrees of freedom</h2><p>{text}.</p>{table}"


def _results(source: PictureSource, curves: Sequence[Curve], resting: Sequence[Curve]) -> str:
    """Start, end and extremes of the curves; of a single step the values. The resting ones are only named."""
    left = f"<p>Zero at all steps: {escape(', '.join(c.text for c in resting))}.</p>" if resting else ""
    if not curves:
        return f"<h2>Key results</h2>{left}" if left else ""
    rows: list[tuple[str, ...]] = []
    times = np.ravel(source.get("t"))
    unit = "" if source.scene.analysis.stationary else " s"
    for c in curves:
        v = np.asarray(c.values)
        if len(v) == 1:
            rows.append((axis_text(c), number_text(v[0])))
            continue
        extremes = [f"{number_text(v[k])} at {times[k]:.4g}{unit}" for k in (np.argmin(v), np.argmax(v))]
        rows.append((axis_text(c), number_text(v[0]), number_text(v[-1]), *extremes))
    head = ("", "value") if source.steps == 1 else ("", "first", "last", "smallest", "largest")
    return "<h2>Key results</h2>" + html_table(rows, head, "numbers") + left


def _modes(source: PictureSource, extras: Extras) -> str:
    """Tables and pictures of vibration and buckling modes; a sentence where the result has none."""
    out = ""
    analysis = source.scene.analysis
    kinds = [k for k, given in (("vibration", analysis.linearized), ("buckling", analysis.buckling)) if given]
    step, extent = source.steps, extent_of(source, source.steps)
    for kind in kinds:
        try:
            found = modes_of(source, kind, step)
        except UsageError as error:
            out += f'<h2>{kind.capitalize()} modes</h2><p class="warn">{escape(str(error))}</p>'
            continue
        head, rows = ["mode", "load multiplier"], [[str(m.number), number_text(m.value.real)] for m in found]
        if kind == "vibration":
            head = ["mode", "real part (1/s)", "frequency (rad/s)", "frequency (Hz)", "damping ratio"]
            for row, m in zip(rows, found, strict=True):
                omega, size = abs(m.value.imag), abs(m.value)
                ratio = number_text(-m.value.real / size) if size else ""
                row += [number_text(omega), number_text(omega / (2 * np.pi)), ratio]
        out += f"<h2>{kind.capitalize()} modes</h2>" + html_table(rows, head, "numbers")
        for m in found[:MOST_MODES]:
            factor = suitable_factor(source.scene, m.motion, extent)
            still = mode_still(source, step, replace(extras, title=m.label), m, factor, True)
            out += html_figure(still, m.label.replace("   ", ": ", 1), "half")
    return out


def _constraints(source: PictureSource, extras: Extras) -> str:
    found = constraints(source, 1)
    figure = constraint_still(source, 1, extras, found)
    text = f"{len(found.over)} over-constraints, {len(found.under)} under-constraints."
    caption = "Red elements take part in over-constraints; dashed red: free motion."
    return f"<h2>Constraints</h2><p>{text}</p>" + html_figure(figure, caption)


def _log(source: PictureSource, lines: int) -> str:
    path = source.beside(".log")
    if not lines or not path.is_file():
        return ""
    text = path.read_text("utf-8", "replace").splitlines()
    if len(text) > 2 * lines:
        left = len(text) - 2 * lines
        text = [*text[:lines], "", f"[... {left} lines left out, see {path.name} ...]", "", *text[-lines:]]
    return f"<h2>Log</h2><pre>{escape(chr(10).join(text))}</pre>"
