"""The page of `spacar view`: a self-contained HTML page that turns, zooms and plays a result with WebGL 2.

Nothing is loaded from elsewhere. The script is that of SCRIPTS as they stand, the only one that the page's security
policy admits (by its digest); the model is data beside it, written so that no text of a model can end its element.

Colours of `spacar view --stress`: a stress or stress resultant along beams and trusses, over all pictures.

Every frame of the mesh along an elastic line, and of a truss that is drawn as a spring, gets a number for every
picture, 0 ... LAST for the range of the colours, NONE where there is no finite value; the page mixes the palette
between them.
"""

import json
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES
from spacar.deck.length_unit import shown_in
from spacar.errors import UsageError
from spacar_drawing.files import evenly
from spacar_drawing.look import look_of, node_names
from spacar_drawing.mechanism_picture import Extras, series_bounds, step_text
from spacar_drawing.picture_source import PictureSource
from spacar_drawing.scene import Scene, positions
from spacar_drawing.stage import view_angles
from spacar_drawing.stress_picture import colour_range, courses
from spacar_drawing.stresses import QUANTITIES
from spacar_drawing.viewer_mesh import COLOUR, ELEMENT, FRAME, NORMAL, PLACE, Draw, TriangleMesh, mesh_of

NONE, LAST = 65535, 65534
SHADES = 9  # of the palette


@dataclass(frozen=True)
class FieldColours:
    """numbers (pictures, frames); low, high the range, in `unit`; palette SHADES colours of 0 ... 255."""

    name: str
    unit: str
    low: float
    high: float
    palette: list[list[int]]
    numbers: NDArray[np.uint16]


def field_colours(source: PictureSource, mesh: TriangleMesh, chosen: Sequence[int], quantity: str) -> FieldColours:
    """The quantity (of QUANTITIES) at the steps that the pictures show. Raises UsageError as `view_page`."""
    if quantity not in QUANTITIES:
        raise UsageError(f"there is no stress '{quantity}'; expected {', '.join(QUANTITIES)}", "draw.stress")
    values = np.full((len(chosen), mesh.frames), np.nan)
    owner = mesh.owner
    trusses = {e.number: np.flatnonzero(owner == e.number) for e in source.scene.elements if e.shape == "truss"}
    counts = sorted({n for _, _, n in mesh.lines}) or [2]
    for k, step in enumerate(chosen):
        for n in counts:
            found = {e.number: values for e, values in courses(source, step, quantity, n)}
            for first, elements, points in mesh.lines:
                for i, number in enumerate(elements if points == n else ()):
                    if number in found:
                        values[k, first + i * n : first + (i + 1) * n] = found[number]
        for number, frames in trusses.items():  # uniform, however it is drawn
            if number in found:
                values[k, frames] = found[number][0]
    low, high, colours = colour_range(values, quantity)
    known = np.isfinite(values)
    numbers = np.where(known, np.rint(LAST * (np.where(known, values, low) - low) / (high - low)), NONE)
    shades = colours(np.linspace(0.0, 1.0, SHADES))
    unit = shown_in(QUANTITIES[quantity][1], source.scene.metre)[1]
    palette = np.rint(255 * shades[:, :3]).astype(int).tolist()
    return FieldColours(QUANTITIES[quantity][0], unit, low, high, palette, numbers.astype(np.uint16))


BUDGET = 24e6  # bytes of the moving part; of longer results fewer pictures are kept
MOST_VALUES = 4e6  # bytes of deformations and stresses
MOST_PICTURES = 150
SCRIPTS = ("viewer.js", "viewer_controls.js", "viewer_start.js")
STYLE = """
*{box-sizing:border-box}html,body{margin:0;height:100%;font:14px/1.4 system-ui,sans-serif;color:#1d262e;background:#fff}
body{display:flex;flex-direction:column}header,#bar{display:flex;gap:.6em;align-items:center;padding:.45em .9em;
flex-wrap:wrap;border-bottom:1px solid #dde2e6}#bar{border:0;border-top:1px solid #dde2e6}h1{font-size:1em;margin:0}
#time{color:#4d565e}#stage{position:relative;flex:1;min-height:120px}canvas{position:absolute;inset:0;width:100%;
height:100%}#view{touch-action:none;cursor:grab}#over{pointer-events:none}#panel{position:absolute;top:.6em;right:.6em;
background:#fffffff0;border:1px solid #dde2e6;border-radius:4px;padding:.4em .7em;max-width:17em;pointer-events:none;
max-height:90%;overflow:hidden}#panel.left{left:.6em;right:auto}
#panel th{text-align:left;font-weight:400;color:#4d565e;padding-right:.9em}
#panel td{font-variant-numeric:tabular-nums;text-align:right}#hint{color:#6b747b;margin:0;font-size:.9em}
#controls{display:flex;gap:.6em;flex:1;align-items:center}#controls[hidden]{display:none}#step{flex:1;min-width:8em}
button{font:inherit;padding:.15em .7em;border:1px solid #b9c1c8;background:#f6f8f9;border-radius:4px}
#note{color:#a33;margin:0}label{color:#4d565e}label[hidden]{display:none}
"""


def view_page(
    source: PictureSource, frames: int = MOST_PICTURES, view: str = "iso", fps: float = 25.0, stress: str | None = None
) -> str:
    """The page of a result as text: see `view` of drawing_calls."""
    data = json.dumps(view_model(source, frames, view, fps, stress), separators=(",", ":"), allow_nan=False)
    data = data.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e")
    script = "\n".join(script_text(name) for name in SCRIPTS)
    digest = b64encode(sha256(script.encode()).digest()).decode()
    style = b64encode(sha256(STYLE.encode()).digest()).decode()
    policy = f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'sha256-{style}'"
    title = escape(source.scene.title)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width">\n'
        f"<title>{title}: spacar view</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f'<header><h1>{title}</h1><span id="time"></span><p id="note"></p></header>\n{stage_html()}'
        f'<script type="application/json" id="data">{data}</script>\n<script>{script}</script>\n</body>\n</html>\n'
    )


def script_text(name: str) -> str:
    return files("spacar_drawing").joinpath(name).read_text("utf-8")


def stage_html() -> str:
    """The elements that viewer_controls.js works with."""
    names = {"iso": "iso", "top": "xy", "xz": "xz", "yz": "yz"}
    buttons = "".join(
        f'<button type="button" data-view="{a:g},{b:g}">{text}</button>'
        for text, (a, b) in ((text, view_angles(name)) for name, text in names.items())
    )
    return (
        '<div id="stage"><canvas id="view"></canvas><canvas id="over"></canvas>'
        '<div id="panel"><table><tbody id="picked"></tbody></table>'
        '<p id="hint">drag: turn; shift and drag: move; wheel: zoom; click: numbers of a node or element</p>'
        "</div></div>\n"
        '<div id="bar"><span id="controls"><button type="button" id="play">play</button>'
        '<input id="step" type="range" min="0" value="0" aria-label="step"></span>'
        f"{buttons}"
        '<label><input type="checkbox" id="numbers"> numbers</label>'
        '<label><input type="checkbox" id="marks" checked> nodes</label>'
        '<label id="fields" hidden><input type="checkbox" id="field" checked> stress</label></div>\n'
    )


def view_model(
    source: PictureSource, frames: int = MOST_PICTURES, view: str = "iso", fps: float = 25.0, stress: str | None = None,
    more: Sequence[Draw] = (),
) -> dict[str, Any]:  # fmt: skip
    """What makeViewer (viewer.js) shows: see `view_page`; `more` draws shapes beside the mechanism."""
    scene = source.scene
    look = look_of(scene, np.stack([source.x(k) for k in evenly(1, source.steps, 24)]), source.settings)
    first = mesh_of(scene, source.x(1)[None], look, more)
    if not first.corners and not len(scene.position_nodes):
        raise UsageError(f"{source.name} has nothing that could be drawn", "draw.empty")
    per_picture = (24 if stress is None else 26) * first.frames + 12 * len(scene.position_nodes)
    chosen = evenly(1, source.steps, max(2, min(frames, int(BUDGET / max(per_picture, 1)))))
    xs = np.stack([source.x(k) for k in chosen])
    mesh = first if chosen == [1] else mesh_of(scene, xs, look, more)
    places = positions(scene, xs)[:, scene.position_nodes - 1]
    low, high = series_bounds(scene, xs, look, Extras(), 12)
    centre = 0.5 * (low + high)
    angles = view_angles(view)  # checked in the plane too
    azimuth, elevation = (-90.0, 90.0) if scene.planar else angles
    values, columns = _values(source, chosen)
    traces, spans = _paths(source, centre)
    arrays = _arrays(mesh, centre) | {"nodes": _text(places - centre, np.float32), "paths": _text(traces, np.float32)}
    if values is not None:
        arrays["values"] = _text(values, np.float32)
    colours = None
    if stress is not None:
        colours = field_colours(source, mesh, chosen, stress)
        arrays["field"] = _text(colours.numbers, np.uint16)
    return {
        "planar": scene.planar, "frames": mesh.frames,
        "times": [step_text(source, k) for k in chosen], "fps": fps,
        "shown": len(chosen) - 1 if scene.analysis.stationary else 0,
        "nodes": [*node_names(scene).values()], "elements": _elements(scene),
        "modes": {e.keyword: [str(m[0]) for m in ELEMENT_TYPES[e.keyword].modes] for e in scene.elements},
        "ne": int(np.sum(scene.nep)), "columns": columns, "centre": centre.tolist(), "low": (low - centre).tolist(),
        "high": (high - centre).tolist(), "metre": scene.metre, "unit": shown_in("m", scene.metre)[1],
        "azimuth": azimuth, "elevation": elevation, "paths": spans,
        "field": None if colours is None else {k: v for k, v in vars(colours).items() if k != "numbers"},
        "arrays": arrays,
    }  # fmt: skip


def _arrays(mesh: TriangleMesh, centre: Array) -> dict[str, str]:
    p, y, z = mesh.moving
    corner, padding = mesh.corner, np.zeros((mesh.corners, 1))
    axes = np.rint(32767 * np.clip(np.concatenate((y, z), axis=2), -1, 1))
    return {
        "p": _text(p - centre, np.float32), "axes": _text(axes, np.int16),
        "frame": _text(corner[:, FRAME], np.uint32), "place": _text(corner[:, PLACE], np.float32),
        "normal": _text(np.hstack((np.rint(127 * corner[:, NORMAL]), padding)), np.int8),
        "colour": _text(np.hstack((np.rint(255 * corner[:, COLOUR]), padding)), np.uint8),
        "element": _text(corner[:, ELEMENT], np.uint32), "triangles": _text(mesh.triangles, np.uint32),
    }  # fmt: skip


def _text(values: NDArray[Any], kind: Any) -> str:
    """The bytes of an array, little-endian."""
    return b64encode(np.ascontiguousarray(values, np.dtype(kind).newbyteorder("<")).tobytes()).decode("ascii")


def _values(source: PictureSource, chosen: Sequence[int]) -> tuple[Array | None, int]:
    """Deformations, then stresses of the pictures, and how many numbers a picture has; None when they are too many."""
    found = [source.read(name, chosen[0]) for name in ("e", "sig")]
    if any(v is None for v in found):
        return None, 0
    columns = sum(v.size for v in found if v is not None)
    if 4 * columns * len(chosen) > MOST_VALUES:
        return None, 0
    rows = [np.concatenate([np.ravel(source.get(name, k)) for name in ("e", "sig")]) for k in chosen]
    largest = np.finfo(np.float32).max
    return np.clip(np.nan_to_num(np.array(rows)), -largest, largest), columns


def _elements(scene: Scene) -> dict[str, Any]:
    """Keyword, nodes and columns (from 1, 0: none) of the deformations of every element."""
    keywords = [scene.keywords[e.number - 1] for e in scene.elements]
    modes = [len(ELEMENT_TYPES[keyword].modes) for keyword in keywords]
    rows = [e.number - 1 for e in scene.elements]
    nodes, columns = (table[rows].tolist() for table in (scene.ln, scene.le))
    return {
        str(row + 1): [keyword, " ".join([str(n) for n in ends if n]), places[:count]]
        for row, keyword, ends, places, count in zip(rows, keywords, nodes, columns, modes, strict=True)
    }


def _paths(source: PictureSource, centre: Array) -> tuple[Array, list[list[int]]]:
    """Points of the paths of TRAJECTNODE one after the other, and [first, count] of each."""
    known = set(source.scene.position_nodes.tolist())
    nodes = [n for n in source.settings.traces if n in known]
    if not nodes:
        return np.zeros((0, 3)), []
    every = positions(source.scene, source.x())
    spans = [[i * len(every), len(every)] for i in range(len(nodes))]
    return np.concatenate([every[:, n - 1] for n in nodes]) - centre, spans
