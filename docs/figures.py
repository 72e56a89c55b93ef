"""Make all pictures of the documentation from the example models: `python docs/figures.py [FOLDER] [PICTURE ...]`.

Every picture is a list of command lines, the same that a user would type; they run in a temporary folder with copies of
the models in `data/`. Those of the gallery are the ones that `docs/gallery.md` shows. Without FOLDER the pictures go to
`docs/pictures`; with names of pictures only those are made. Those of the symbolic part: `docs/symbolic/figures.py`.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from spacar_cli.main import main

HERE = Path(__file__).parent
DATA = HERE.parent / "data"

# picture -> command lines; the last one writes it, {} stands for its name
FIGURES: dict[str, tuple[str, ...]] = {
    "crank.png": ("1 crank", "draw crank --strobe 9 --trace 3 -o {}"),
    "crank-numbers.png": ("1 crank", "draw crank --at 10 --numbers -o {}"),
    "crank.gif": ("1 crank --time 0.04188790204786391 --steps 60", "draw crank --frames 60 --dpi 70 --trace 3 -o {}"),
    "crank-plot.png": ("1 crank", "plot crank x[6,1] xdd[6,1] sig[1,1] -o {}"),
    "crankfl-path.png": ("1 crankfl", "plot crankfl x[6,2] x[3,2] -x x[6,1] -o {}"),
    "crankfl-deflection.png": ("1 crankfl", "plot crankfl (e[2,3]+e[3,2])/2 -o {}"),
    "lever.png": ("9 lever", "draw lever --numbers -o {}"),
    "lever-bode.png": ("9 lever", "bode lever -o {}"),
    "finger.png": ("7 finger", "draw finger --numbers -o {}"),
    "finger-mode.png": ("7 finger", "visual finger -o {}"),
    "cantilever-moment.png": ("7 plbeam5", "visual plbeam5 --diagram Mz -o {}"),
    "cantilever-modes.gif": ("7 plbeam5free", "visual plbeam5free --mode-number 2 --dpi 70 -o {}"),
    "symbols.png": (
        "7 plbeam5",
        "draw plbeam5 --symbols loads,reactions,axes --scale 0.6 -o {}",
    ),
    "section-stress.png": ("7 leafguide", "stress leafguide -e 1 --place 0 -o {}"),
    "lateral4-buckling.png": ("8 lateral4", "visual lateral4 -o {}"),
    "lateral4-stress.png": ("8 lateral4", "visual lateral4 --stress mises -o {}"),
    "robot.png": ("2 robotinv", "draw robotinv --strobe 7 -o {}"),
    "robot-moments.png": ("2 robotinv", "plot robotinv sig[1,1] sig[2,1] sig[3,1] -o {}"),
    "trike.png": ("1 trike3i", "draw trike3i --strobe 4 --trace 11 -o {}"),
    "cardan.png": ("1 cardan", "draw cardan --at 12 -o {}"),
    "square-constraints.png": ("0 square", "visual square -o {}"),
}

# A square with both diagonals: one bar too many.
SQUARE = """PLTRUSS 1 1 2
PLTRUSS 2 2 3
PLTRUSS 3 3 4
PLTRUSS 4 4 1
PLTRUSS 5 1 3
PLTRUSS 6 2 4
PLTRUSS 7 3 5
PLTRUSS 8 2 5
X 2 1. 0.
X 3 1. 1.
X 4 0. 1.
X 5 2. 1.
FIX 1
FIX 2 2
END
END
"""


def beam_order(path: Path) -> None:
    """Error of the tip of the S5 cantilever (reference/theory-beam-order4.md 1.1) over the elements, both measures."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np

    import spacar

    exact, counts = np.array((3.810897752359167, -8.404448390735478)), (5, 10, 20, 40, 80)
    figure, axes = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
    for beams, style in (("sine", "o-"), ("angle", "s-")):
        errors = []
        for n in counts:
            rows: list[tuple] = [("FIX", 1), ("FIX", 2)]
            dynamics: list[tuple] = [("XF", 2 * n + 1, 0.0, -14.0), ("ITERSTEP", 50, 10, 1e-12)]
            for k in range(1, n + 1):
                p = 2 * k - 1
                rows += [("PLBEAM", k, p, p + 1, p + 2, p + 3), ("DYNE", k, 2, 3), ("X", p + 2, 10.0 * k / n, 0.0)]
                dynamics += [("ESTIFF", k, 0.0, 102.0), ("EM", k, 1.0)]
            result = spacar.run(8, spacar.Deck.build(rows, dynamics), beams=beams)
            tip = np.array([result.node(2 * n + 1, i)[-1] for i in (1, 2)])
            errors.append(np.linalg.norm(tip - exact) / 10.0)
        axes.loglog(counts, errors, style, label=f"--beams {beams}")
    axes.set(xlabel="elements", ylabel="error of the end / length")
    axes.set_xticks(counts, [str(n) for n in counts])
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(path, dpi=110)


def robot_loop(path: Path) -> None:
    """The closed loop of the manipulator with its scopes."""
    for line in ("2 robotinv --quiet", "3 robotinvlin --quiet", "sim robotsim"):
        main(line.split())
    main([*["draw", "robotsim_sim", "--trace", "8", "--frames", "24", "--dpi", "48", "--fps", "8", "-o"], str(path)])


def flexure_curves(path: Path) -> None:
    """The guide of the chapter on flexures over its stroke, as `spacar flexure -o` draws it."""
    import spacar

    spacar.flexure(DATA / "leafguide.dat", move="7x=+-10").plot(path, dpi=90)


def flexure_stroke(path: Path) -> None:
    """The same guide at five states of its stroke."""
    import spacar

    study = spacar.flexure(DATA / "leafguide.dat", move="7x=+-10", steps=4)
    study.result.draw(path, strobe=5, view="xy", traces=[7], title="", dpi=90)


def optimized_guide(path: Path) -> None:
    """The example of sensitivity.md: the leaf before and after, the lowest frequency over the stroke, and the cost."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    import optimize_guide as example

    import spacar

    exact, differences = example.Guide(), example.Guide(exact=False)
    best = example.found_parameters(exact, example.optimize(exact))
    example.optimize(differences)
    figure, (leaf, stroke, cost) = plt.subplots(1, 3, figsize=(9.5, 3.6), layout="constrained", width_ratios=(1, 2, 2))
    for p, colour, word, side in ((exact.start, "C7", "start", -4.0), (best, "C0", "optimum", 4.0)):
        heights = np.concatenate(([0.0], p[example.PARTS : -2], [example.HEIGHT]))
        for t, a, b in zip(p[: example.PARTS], heights, heights[1:], strict=False):
            leaf.fill_betweenx([a, b], side - t / 2, side + t / 2, color=colour, lw=0)
        leaf.text(side, -6, word, ha="center", va="top", fontsize=8)
        lowest = [f"frequency[1]@{k}" for k in range(1, 6)]
        f = spacar.sensitivity(exact.deck, exact.names, lowest, at=p).values
        stroke.plot(np.linspace(0.0, example.STROKE, 5), f, "o-", color=colour, label=word)
    leaf.set(xlim=(-8, 8), ylim=(-14, 102), ylabel="height (mm)", xticks=[], title="thickness x 1")
    stroke.set(xlabel="displacement (mm)", ylabel="first unwanted frequency (Hz)", ylim=(0, None))
    for model, word in ((exact, "exact derivatives"), (differences, "differences")):
        counts, values = zip(*model.course, strict=True)
        cost.step(counts, values, where="post", label=f"{word}: {model.analyses}")
    cost.set(xscale="log", xlabel="analyses", ylabel="lowest frequency (Hz)", ylim=(0, None))
    for axes in (stroke, cost):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    figure.savefig(path, dpi=110)


def walk_of_a_run(path: Path) -> None:
    """The picture of the developer guide: rooms and files of one run."""
    import walk

    walk.draw(path)


def viewer(path: Path) -> None:
    """The page of `spacar view` in Chromium; without Chromium the picture that there is stays."""
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        print(f"{path.name}: left as it is, no Chromium found")
        return
    main(["1", "trike3v", "--quiet"])
    main(["view", "trike3v"])
    subprocess.run(
        [
            browser, "--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader", "--hide-scrollbars", "--window-size=900,560", f"--screenshot={path}",
            f"{Path('trike3v_view.html').resolve().as_uri()}#step=40&node=5",
        ],
        check=True, timeout=300, capture_output=True,
    )  # fmt: skip


def editor(path: Path) -> None:
    """One step of the story of the tutorial in `spacar edit` (Chromium, and playwright of PyPI)."""
    sys.path.insert(0, str(HERE.parent))
    from tests.editor.story import draw_story

    draw_story(path)


# picture -> function that writes it
DRAWN: dict[str, Callable[[Path], None]] = {
    "beam-order.png": beam_order,
    "flexure-curves.png": flexure_curves,
    "flexure-stroke.png": flexure_stroke,
    "optimized-guide.png": optimized_guide,
    **dict.fromkeys(("edit-new.png", "edit-error.png", "edit-free.png", "edit-plays.png"), editor),
    "robotsim-loop.gif": robot_loop,
    "view.png": viewer,
    "walk.png": walk_of_a_run,
}


class Entry(NamedTuple):
    """One example of the gallery: its picture, the command lines and the Python that make it."""

    example: str
    picture: str
    commands: tuple[str, ...]
    script: str


def gallery(page: Path = HERE / "gallery.md") -> list[Entry]:
    """The entries of the gallery page, one a third-level heading."""
    entries = []
    for section in re.split(r"^### ", page.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
        name = section.split("\n", 1)[0].strip()
        picture = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", section)[0]
        blocks = dict(re.findall(r"^```(sh|python)\n(.*?)^```", section, flags=re.MULTILINE | re.DOTALL))
        commands = tuple(blocks.get("sh", "").strip().splitlines())
        entries.append(Entry(name, picture, commands, blocks.get("python", "")))
    return entries


def pictures() -> set[str]:
    """Names of all pictures that this script makes."""
    return set(FIGURES) | set(DRAWN) | {Path(entry.picture).name for entry in gallery() if entry.commands}


def make_gallery(folder: Path, chosen: list[str]) -> list[str]:
    """Write the pictures of the gallery that FIGURES does not make; returns the command lines that failed."""
    failed = []
    for entry in gallery():
        name = Path(entry.picture).name
        if name in FIGURES or not entry.commands or (chosen and name not in chosen):
            continue
        for line in entry.commands:
            words = shlex.split(line)[1:]
            if words[0] in ("draw", "plot", "visual"):
                words += ["--dpi", "90"]
            if main([*words, "--quiet"] if words[0].isdigit() else words):
                failed.append(line)
        if entry.script:
            import matplotlib

            matplotlib.use("Agg")
            exec(compile(entry.script, name, "exec"), {})
        shutil.copy(name, folder / name)
    return failed


def with_few_colours(path: Path) -> None:
    """The picture again with 192 colours, where that is smaller: plots lose nothing that the eye sees."""
    from PIL import Image

    smaller = path.with_suffix(".few.png")
    with Image.open(path) as picture:
        if picture.mode == "P":
            return
        picture.convert("RGB").quantize(192, dither=Image.Dither.NONE).save(smaller, optimize=True)
    least = min(path, smaller, key=lambda p: p.stat().st_size)
    least.replace(path)
    smaller.unlink(missing_ok=True)


def make(folder: Path, chosen: list[str]) -> list[str]:
    """Write all pictures, or the chosen ones; returns the command lines that failed."""
    failed = []
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as name:
        os.chdir(name)
        folders = (DATA, DATA / "published")
        for model in (*(p for f in folders for p in f.glob("*.*")), *(DATA / "symbolic").glob("*.dat")):
            shutil.copy(model, name)
        Path("square.dat").write_text(SQUARE)
        ran = set()
        for picture, (run, draw) in FIGURES.items():
            if chosen and picture not in chosen:
                continue
            commands = [run] if run not in ran else []
            ran = {r for r in ran if r.split()[1] != run.split()[1]} | {run}  # another run of this model replaces it
            for line in (*commands, draw.format(folder / picture)):
                words = line.split()
                if words[0] in ("draw", "plot", "visual") and "--dpi" not in words:
                    words += ["--dpi", "110"]
                if main([*words, "--quiet"] if words[0].isdigit() else words):
                    failed.append(line)
        for picture, write in DRAWN.items():
            if not chosen or picture in chosen:
                write(folder / picture)
        failed += make_gallery(folder, chosen)
        os.chdir(before)
    for picture in folder.glob("*.png"):
        if not chosen or picture.name in chosen:
            with_few_colours(picture)
    return failed


if __name__ == "__main__":
    target = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else HERE / "pictures"
    target.mkdir(parents=True, exist_ok=True)
    sys.exit("\n".join(make(target, sys.argv[2:])) or 0)
