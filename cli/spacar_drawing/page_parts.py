"""Parts of self-contained HTML pages: the page around them, tables, numbers, pictures as data inside the page."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

import spacar
from spacar_drawing.defaults import plain
from spacar_drawing.report_style import STYLE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
def html_figure(figure: Figure, caption: str, klass: str = "") -> str:
    """The picture as data inside the page, so that nothing else is needed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=DPI)
    width = round(figure.get_size_inches()[0] * 96)
    data = base64.b64encode(buffer.getvalue()).decode("ascii")
    text = escape(caption)
    image = f'<img width="{width}" alt="{text}" src="data:image/png;base64,{data}">'
    return f'<figure class="{klass}">{image}<figcaption>{text}</figcaption></figure>'
