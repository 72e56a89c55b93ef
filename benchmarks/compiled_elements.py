"""Modes 4, 7 and 8 with elements in C and in NumPy, in turn: processor times and the share of the elements.

    python benchmarks/compiled_elements.py                      # cantilevers of 5, 50 and 300 beams
    python benchmarks/compiled_elements.py --sizes 5 --modes 7 --repeats 40

Clamped cantilevers with a tip load, planar and spatial, in the sine and in the angle measure. Every row is the smallest
processor time of a run in this process, from the built mechanism to the last frame, both in turn. Motions are those
of the compiled engine in both: only what statics and linearized equations ask of elements differs. The share of the
elements is what the functions of their families take, measured by a clock around each call in runs of its own.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import models

import spacar
from spacar.compiled import compiled_elements, compiled_evaluator
from spacar.deck.deck import parse_deck
from spacar.elements.family import Family

FUNCTIONS = (
    "strain", "convective_strain", "gradient_rate", "gradient_transport", "rate_gradient", "geometric_stiffness",
    "mass", "inertia_force", "inertia_gradient", "internal", "troubles",
)  # fmt: skip
STEP = "TIMESTEP 1e-9 1"


def text(space: str, measure: str, n: int) -> str:
    """A deck of n beams."""
    if space == "planar":
        deck = models.cantilever(n, load="-1. -1.", dynamics=(STEP,))
    else:
        deck = models.spatial_chain(n).replace("TIMESTEP 0.01 1", STEP)
    return deck.replace("END\nHALT", "ADEFORM\nEND\nHALT") if measure == "angle" else deck


def run(mode: int, deck: spacar.Deck, in_c: bool) -> float:
    """Processor time [s] of a run."""
    prepared = spacar.frames(mode, deck)
    callers = compiled_elements, compiled_evaluator
    kept = compiled_elements.with_compiled_elements
    for caller in callers if not in_c else ():
        vars(caller)["with_compiled_elements"] = lambda mechanism: mechanism
    begun = time.process_time()
    try:
        for _ in prepared:
            pass
        return time.process_time() - begun
    finally:
        for caller in callers:
            vars(caller)["with_compiled_elements"] = kept


def families() -> Iterator[type[Family]]:
    """All classes of families."""
    found: list[type[Family]] = [Family]
    for family in found:
        found += family.__subclasses__()
    return iter(dict.fromkeys(found))


@contextmanager
def clocked(spent: list[float]) -> Iterator[None]:
    """Adds the processor time of all functions of families to `spent`; those that they call are not counted twice."""
    kept: list[tuple[type[Family], str, Any]] = []
    inside = [False]

    def singularity_monitor(function: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any) -> Any:
            if inside[0]:
                return function(*arguments)
            inside[0] = True
            begun = time.process_time_ns()
            try:
                return function(*arguments)
            finally:
                spent[0] += 1e-9 * (time.process_time_ns() - begun)
                inside[0] = False

        return call

    for family in families():
        for name in FUNCTIONS:
            if name in vars(family):
                kept.append((family, name, vars(family)[name]))
                setattr(family, name, singularity_monitor(vars(family)[name]))
    try:
        yield
    finally:
        for family, name, function in kept:
            setattr(family, name, function)


def share(mode: int, deck: spacar.Deck, in_c: bool, repeats: int) -> float:
    """Smallest part of a run that the elements take."""
    parts = []
    for _ in range(repeats):
        spent = [0.0]
        with clocked(spent):
            whole = run(mode, deck, in_c)
        parts.append(spent[0] / whole)
    return min(parts)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+", default=[5, 50, 300])
    parser.add_argument("--modes", type=int, nargs="+", default=[4, 7, 8])
    parser.add_argument("--repeats", type=int, default=12)
    choices = parser.parse_args()
    print("space   measure beams mode   NumPy [ms]  C [ms]  ratio   elements NumPy  C")
    for space in ("planar", "spatial"):
        for measure in ("sine", "angle"):
            for n in choices.sizes:
                for mode in choices.modes:
                    deck = parse_deck(text(space, measure, n), mode=mode)
                    repeats = max(choices.repeats * 5 // n, 2)
                    times: dict[bool, float] = {False: float("inf"), True: float("inf")}
                    for _ in range(repeats + 1):
                        for in_c in times:
                            times[in_c] = min(times[in_c], run(mode, deck, in_c))
                    general, own = (share(mode, deck, c, min(repeats, 5)) for c in (False, True))
                    print(
                        f"{space:8}{measure:6}{n:7}{mode:5}{1e3 * times[False]:13.2f}{1e3 * times[True]:8.2f}"
                        f"{times[False] / times[True]:7.2f}{100 * general:14.0f} %{100 * own:5.0f} %", flush=True,
                    )  # fmt: skip


if __name__ == "__main__":
    main()
