"""Time of pictures of long cantilevers: with numbers, a frame of an animation, the page (docs/performance.md).

    python benchmarks/pictures.py [beams ...]

A cantilever of n spatial and of n planar beams is bent into a quarter of a circle by its coordinates, without analysis.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
from spacar_drawing.mechanism_picture import Extras, picture, series
from spacar_drawing.picture_source import PictureSource, source_of_result

from spacar.deck.deck import parse
from spacar.mechanism import build


def cantilever(n: int, planar: bool) -> str:
    """The deck of n beams along x, 1 m long, all deformations dynamic."""
    word, more, stiff = ("PLBEAM", "", "1e6 100.") if planar else ("BEAM", "  0. 0. 1.", "1e6 10. 100. 100.")
    zero = "0." if planar else "0. 0."
    lines = [f"{word} {k + 1} {2 * k + 1} {2 * k + 2} {2 * k + 3} {2 * k + 4}{more}" for k in range(n)]
    lines += [f"X {2 * k + 1} {k / n:.12g} {zero}" for k in range(n + 1)]
    lines += ["FIX 1", "FIX 2", *(f"DYNE {k + 1}" for k in range(n)), "END", "HALT"]
    lines += [f"EM {k + 1} 1." for k in range(n)] + [f"ESTIFF {k + 1} {stiff}" for k in range(n)]
    return "\n".join([*lines, "END", "END", ""])


def bent(n: int, planar: bool, steps: int = 3) -> PictureSource:
    """A result whose last step is the quarter of a circle; the first one is straight."""
    mechanism = build(parse(cantilever(n, planar), f"cantilever{n}", 1), 1)
    lnp, xs = mechanism.numbering.lnp, []
    for s in np.linspace(0.0, 1.0, steps):
        bend = 0.5 * np.pi * s
        x = np.array(mechanism.x0, float)
        along = np.linspace(0.0, 1.0, n + 1)
        phi = bend * along
        place = np.stack((np.sin(phi), 1 - np.cos(phi)), axis=1) / bend if bend else np.stack((along, 0 * along), 1)
        for k in range(n + 1):
            x[lnp[2 * k, :2] - 1] = place[k]
            turn = lnp[2 * k + 1]
            if planar:
                x[turn[0] - 1] = phi[k]
            else:
                x[turn - 1] = [np.cos(phi[k] / 2), 0.0, 0.0, np.sin(phi[k] / 2)]
        xs.append(x)
    frames = [SimpleNamespace(value={"t": float(k), "x": x}.get) for k, x in enumerate(xs)]
    result: Any = SimpleNamespace(mode=1, mechanism=mechanism, frames=frames)
    return source_of_result(result)


def timed(call: Callable[[], Any]) -> float:
    begun = time.process_time()
    call()
    return time.process_time() - begun


def main(sizes: list[int]) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    print("processor seconds: picture, picture with numbers, one frame of an animation")
    for n in sizes:
        for planar in (True, False):
            source = bent(n, planar)
            numbers = {"node_numbers": True, "element_numbers": True}

            def still(source: PictureSource = source, **extras: Any) -> None:
                FigureCanvasAgg(picture(source, Extras(**extras), [3], [], False)).draw()

            plain, numbered = timed(still), timed(lambda: still(**numbers))  # noqa: B023
            shown = series(source, Extras(), [1, 2, 3], [], False)
            moving = shown.moving()
            FigureCanvasAgg(moving.figure)

            def frame(k: int) -> None:
                moving.show(*shown.pictures(k))  # noqa: B023
                moving.draw()  # noqa: B023

            frame(0)
            one = timed(lambda: [frame(k % 3) for k in range(3)]) / 3
            print(f"{n:6d} {'planar' if planar else 'spatial':8s} {plain:8.2f} {numbered:8.2f} {one:8.3f}", flush=True)


if __name__ == "__main__":
    main([int(v) for v in sys.argv[1:]] or [50, 200, 1000])
