"""The walk of one run: which files of the house `spacar 1 crank` calls, by room, in the order of the first call."""

from __future__ import annotations

import sys
from pathlib import Path
from types import FrameType
from typing import Any

HOUSE = Path(__file__).resolve().parents[1]
WORDS = ["1", "crank", "--quiet"]
WIDE = 4  # boxes in a row


def files_of_a_run(words: list[str] = WORDS) -> list[str]:
    """Files of ours whose functions a command calls, in the order of their first call; imports do not count."""
    from spacar_cli.main import main

    main(words)

    seen: dict[str, None] = {}

    def watch(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and frame.f_code.co_name != "<module>":
            seen.setdefault(frame.f_code.co_filename)

    sys.setprofile(watch)
    try:
        main(words)
    finally:
        sys.setprofile(None)
    inside = [Path(f) for f in seen if f.startswith(str(HOUSE)) and "/site-packages/" not in f]
    return [f.relative_to(HOUSE).as_posix() for f in inside if f.name not in ("walk.py", "__init__.py")]


def room(file: str) -> str:
    """The folder of a file as the guide names it: `deck`, `elements`, `spacar_formats` ..."""
    parts = file.split("/")
    if parts[0] != "spacar":
        return parts[1]
    return parts[1] if len(parts) > 2 else "spacar"


def rooms(files: list[str]) -> dict[str, list[str]]:
    """Files by room, both in their order."""
    found: dict[str, list[str]] = {}
    for file in files:
        found.setdefault(room(file), []).append(Path(file).stem)
    return found


def draw(path: Path) -> None:
    """One box a room, numbered in the order of the walk."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    files = files_of_a_run()
    boxes = list(rooms(files).items())
    rows = [boxes[k : k + WIDE] for k in range(0, len(boxes), WIDE)]
    heights = [2.6 + max(len(names) for _, names in row) for row in rows]
    figure, axes = plt.subplots(figsize=(8.5, 0.135 * sum(heights)))
    top = 0.0
    for k, row in enumerate(rows):
        for column, (name, names) in enumerate(row):
            axes.add_patch(plt.Rectangle((column, top), 0.94, heights[k] - 0.6, fill=False, ec="C0"))
            title = f"{k * WIDE + column + 1}  {name}"
            axes.text(column + 0.04, top + 0.3, title, va="top", size=8, weight="bold")
            axes.text(column + 0.04, top + 1.6, "\n".join(names), va="top", size=6.5, linespacing=1.12)
        top += heights[k]
    axes.set(xlim=(-0.02, WIDE), ylim=(top, -0.2))
    axes.axis("off")
    figure.savefig(path, dpi=110, bbox_inches="tight")
    from PIL import Image, PngImagePlugin

    told = PngImagePlugin.PngInfo()
    told.add_text("Description", "\n".join(files))  # for the test
    with Image.open(path) as picture:
        picture.convert("RGB").quantize(64, dither=Image.Dither.NONE).save(path, optimize=True, pnginfo=told)
    plt.close(figure)
