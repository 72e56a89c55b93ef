"""Parts of self-contained HTML pages: the page around them, tables, numbers, pictures as data inside the page.

Style sheet of the report: one column, readable on screen and paper.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from io import BytesIO
from typing import TYPE_CHECKING

import spacar
from spacar_drawing.defaults import plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLE = """
body { margin: 0; background: #f3f5f7; color: #1d262e; font: 15px/1.5 "DejaVu Sans", Verdana, sans-serif; }
main { max-width: 880px; margin: 0 auto; padding: 28px 36px 40px; background: #fff; }
h1 { font-size: 26px; font-weight: 600; margin: 0 0 14px; }
h2 { font-size: 18px; font-weight: 600; margin: 34px 0 10px; padding-bottom: 4px; border-bottom: 1px solid #d8dee3; }
table { border-collapse: collapse; font-size: 13px; }
th, td { text-align: left; padding: 3px 18px 3px 0; vertical-align: top; font-weight: 400; }
thead th { color: #5b6770; border-bottom: 1px solid #d8dee3; }
tbody tr + tr { border-top: 1px solid #eef1f3; }
table.facts th { color: #5b6770; white-space: nowrap; }
table.numbers td { font-variant-numeric: tabular-nums; }
table.five td { font-size: 17px; font-variant-numeric: tabular-nums; }
details { margin-top: 18px; border-top: 1px solid #d8dee3; padding-top: 8px; }
summary { font-size: 18px; font-weight: 600; cursor: pointer; }
.scroll { overflow-x: auto; }
figure { margin: 12px 0 20px; }
figure.half { display: inline-block; width: 48%; margin: 8px 1% 12px 0; vertical-align: top; }
iframe.viewer { width: 100%; height: 560px; border: 1px solid #d8dee3; }
img { max-width: 100%; height: auto; display: block; }
figcaption { color: #5b6770; font-size: 12.5px; margin-top: 4px; }
pre { font: 12px/1.4 "DejaVu Sans Mono", Consolas, monospace; }
pre { background: #f7f9fa; border: 1px solid #e3e7ea; padding: 12px; overflow-x: auto; }
.warn { background: #fdf1e3; border-left: 4px solid #c2703d; padding: 8px 12px; }
footer { margin-top: 36px; color: #8a97a3; font-size: 12px; }
@media print { details > * { display: block; } }
@media print { body { background: #fff; } main { padding: 0; } figure, table { break-inside: avoid; } }
"""

DPI = 120


def page(title: str, parts: Sequence[str]) -> str:
    """The whole page; `title` is plain text, `parts` are HTML, empty ones are left out."""
    title = escape(title)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="viewport" '
        'content="width=device-width">\n'
        f"<title>{title}: spacar report</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n"
        f"<h1>{title}</h1>\n"
        + "\n".join(p for p in parts if p)
        + f"\n<footer>spacar {spacar.__version__}</footer>\n</main>\n</body>\n</html>\n"
    )


def number_text(value: float) -> str:
    """Six digits with a true minus sign."""
    return f"{float(value) + 0.0:.6g}".replace("-", "\N{MINUS SIGN}")


def html_table(rows: Sequence[Sequence[str]], head: Sequence[str] | None, klass: str = "") -> str:
    """A table of plain texts; the first cell of a row is its heading."""
    top = "<thead><tr>" + "".join(f"<th>{escape(h)}</th>" for h in head) + "</tr></thead>" if head else ""
    body = "".join(
        f"<tr><th>{escape(r[0])}</th>" + "".join(f"<td>{escape(c)}</td>" for c in r[1:]) + "</tr>" for r in rows
    )
    return f'<div class="scroll"><table class="{klass}">{top}<tbody>{body}</tbody></table></div>'


def folded(title: str, parts: Sequence[str]) -> str:
    """Parts that are shown when their heading is asked for."""
    return f"<details><summary>{escape(title)}</summary>\n" + "\n".join(p for p in parts if p) + "\n</details>"


@plain
def png(figure: Figure, dpi: float) -> bytes:
    data = BytesIO()
    figure.savefig(data, format="png", dpi=dpi)
    return data.getvalue()


def html_figure(figure: Figure, caption: str, klass: str = "") -> str:
    """The picture as data inside the page, so that nothing else is needed."""
    width = round(figure.get_size_inches()[0] * 96)
    data = b64encode(png(figure, DPI)).decode()
    text = escape(caption)
    image = f'<img width="{width}" alt="{text}" src="data:image/png;base64,{data}">'
    return f'<figure class="{klass}">{image}<figcaption>{text}</figcaption></figure>'
