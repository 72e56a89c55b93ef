"""Executes the cells of a notebook as Jupyter does, without Jupyter: text, pictures, animations.

`python -m tests.docs.notebooks docs/notebooks/*.ipynb` executes them and stores what they print and show.
"""

import ast
import base64
import contextlib
import io
import json
import os
import re
import sys
from pathlib import Path
from typing import Any

PICTURE = re.compile(r'^<img alt="[^"]*" src="data:(image/\w+);base64,([^"]*)">$')
DPI = 60


class Notebook:
    """A file in format 4.5."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.content = json.loads(path.read_text(encoding="utf-8"))

    @property
    def code(self) -> list[dict[str, Any]]:
        return [cell for cell in self.content["cells"] if cell["cell_type"] == "code"]

    def execute(self) -> list[list[dict[str, Any]]]:
        """The outputs of every cell of code, in order."""
        os.environ["MPLBACKEND"] = "Agg"
        names: dict[str, Any] = {}
        cells = enumerate(self.code, 1)
        return [outputs("".join(cell["source"]), names, f"{self.path.name}[{k}]") for k, cell in cells]

    def store(self) -> None:
        """Write the outputs into the file."""
        for count, (cell, found) in enumerate(zip(self.code, self.execute(), strict=True), 1):
            cell["outputs"], cell["execution_count"] = found, count
            for output in found:
                if output["output_type"] == "execute_result":
                    output["execution_count"] = count
        text = json.dumps(self.content, indent=1, ensure_ascii=False) + "\n"
        self.path.write_text(text, encoding="utf-8")


def outputs(source: str, names: dict[str, Any], where: str) -> list[dict[str, Any]]:
    """What a cell prints, and the value of its last expression."""
    tree = ast.parse(source, where)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    said = io.StringIO()
    value = None
    with contextlib.redirect_stdout(said):
        exec(compile(tree, where, "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), where, "eval"), names)
    found: list[dict[str, Any]] = []
    if said.getvalue():
        found.append({"output_type": "stream", "name": "stdout", "text": said.getvalue().splitlines(keepends=True)})
    if value is not None and not source.rstrip().endswith(";"):
        found.append({"output_type": "execute_result", "metadata": {}, "data": shown(value), "execution_count": None})
    return found


def shown(value: Any) -> dict[str, Any]:
    """Text, and for what has one a picture: that of a figure, or of `_repr_html_`."""
    data: dict[str, Any] = {"text/plain": repr(value).splitlines(keepends=True)}
    if hasattr(value, "savefig"):
        data["text/plain"] = ["<Figure>"]
        data["image/png"] = png(value)
    elif hasattr(value, "_repr_html_"):
        html = value._repr_html_()
        if picture := PICTURE.match(html):
            data[picture[1]] = picture[2]
        else:
            data["text/html"] = html.splitlines(keepends=True)
    return data


def png(figure: Any) -> str:
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DPI)
    return base64.b64encode(file.getvalue()).decode()


def text_of(found: list[dict[str, Any]]) -> list[str]:
    """The lines that the outputs of a cell print."""
    lines: list[str] = []
    for output in found:
        lines += "".join(output.get("text", []) or output["data"]["text/plain"]).splitlines()
    return lines


if __name__ == "__main__":
    for name in sys.argv[1:]:
        Notebook(Path(name)).store()
        print(name, f"{Path(name).stat().st_size / 1000:.0f} kB")
