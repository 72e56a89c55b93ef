"""Answers, their errors against `expected.json`, and the settings of every program that are tried."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np

EXPECTED = json.loads((Path(__file__).parent / "scenarios" / "expected.json").read_text())
LEVELS = {  # errors of the rows of the table
    "S1a": (1e-4, 1e-6, 1e-8), "S1b": (1e-4, 1e-6, 1e-8), "S3a": (1e-4, 1e-6, 1e-8, 1e-10),
    "S4": (1e-4, 1e-6, 1e-8, 1e-10), "S4c": (1e-4, 1e-6, 1e-8, 1e-10), "S5": (1e-4, 5e-6, 1e-6),
    "S8": (1e-4, 1e-6, 1e-8),
}  # fmt: skip
TITLES = {
    "S1a": "slider-crank, prescribed, reactions, 101 outputs", "S1b": "free slider-crank, 83 turns",
    "S3a": "double pendulum, 10 s", "S4": "manipulator, torques by a user function",
    "S4c": "manipulator, constant torques", "S5": "strongly bent cantilever", "S8": "three frequencies of a cantilever",
}  # fmt: skip
LENGTH = {"S3a": 2.0, "S4": 1.4, "S4c": 1.4, "S5": 10.0}
OURS = "spacar"


@dataclass(frozen=True)
class Setting:
    """One way to solve a scenario. `known`: the error for which a user would choose it beforehand (0: for any; None: no
    choice that one knows beforehand); `by_default`: our default command, with nothing but the accuracy."""

    program: str
    label: str
    solve: Callable[[], np.ndarray]
    known: float | None = None
    by_default: bool = False


def error(name: str, answer: np.ndarray) -> float:
    """As `what` of the scenario in expected.json defines it."""
    e = EXPECTED[name]
    if name == "S1a":
        reference = np.array(e["a"], float)
        return float(np.abs(answer - reference)[1:].max() / np.abs(reference).max())
    if name == "S1b":
        return float(np.abs(answer - np.array(e["phi"], float)).max())
    if name == "S8":
        return float(np.abs(answer / np.array(e["omega"], float) - 1.0).max())
    end = e["elastica"] if name == "S5" else e["tip"][-1]
    return float(np.linalg.norm(answer - np.array(end, float)) / LENGTH[name])


def settings(name: str) -> Iterator[Setting]:
    """All that are tried: ours first; programs that are not installed are left out."""
    yield from _ours(name)
    if find_spec("exudyn"):
        yield from _exudyn(name)
    if find_spec("pinocchio"):
        yield from _pinocchio(name)


def missing() -> list[str]:
    """Programs that are not installed."""
    return [name for name, module in (("Exudyn", "exudyn"), ("Pinocchio", "pinocchio")) if not find_spec(module)]


def _ours(name: str) -> Iterator[Setting]:
    side = import_module("spacar_side")
    if name == "S5":
        for n in (40, 72, 80):
            yield Setting(OURS, f"{n} elements", partial(side.bent, n))
        for n in (6, 8, 10, 14, 15, 20, 22, 25):
            known = {10: 1e-4, 15: 5e-6, 25: 1e-6}.get(n)  # by the errors of theory-beam-order4.md
            yield Setting(OURS, f"{n} elements, ADEFORM", partial(side.bent, n, True), known, by_default=True)
    elif name == "S8":
        for n in (5, 10, 13, 20, 40, 45, 80, 130):
            yield Setting(OURS, f"{n} elements", partial(side.frequencies, n), by_default=True)
    elif name == "S1a":
        yield Setting(OURS, "default", partial(side.answer, name, None, None), 0.0, by_default=True)
    else:
        for k in range(3 if name == "S1b" else 1, 13):
            run = partial(side.answer, name, 10.0**-k, None)
            yield Setting(OURS, f"default, ERROR 1e-{k}", run, 10.0**-k, by_default=True)
        for code in (155, 853):
            for k in range(4 if name == "S1b" else 1, 11):  # what reaches no level is not tried
                yield Setting(OURS, f"INTEGRAT {code}, ERROR 1e-{k}", partial(side.answer, name, 10.0**-k, code))


def _exudyn(name: str) -> Iterator[Setting]:
    side = import_module("exudyn_side")
    of = partial(Setting, "Exudyn")
    if name == "S1a":
        for steps, known in ((1000, 1e-4), (3000, None), (8000, 1e-6), (80000, 1e-8)):
            yield of(f"generalized alpha, {steps} steps", partial(side.crank, steps), known)
    elif name in ("S3a", "S4", "S4c"):
        outputs, solve = (10, side.pendulum) if name == "S3a" else (14, partial(side.arm, constant=name == "S4c"))
        for steps in (50, 80, 120, 250, 350, 500, 1000, 2000) if name == "S3a" else (14, 28, 42, 56, 84, 112):
            yield of(f"tree, RK67, {steps} steps", partial(solve, side.fixed(steps)))
        for k in range(3, 12):
            yield of(f"tree, DOPRI5, 1e-{k}", partial(solve, side.variable(10.0**-k, outputs)), 10.0**-k)
    elif name == "S5":
        for n, parts, axial, tolerance in (
            (20, 1, 1e6, 1e-8), (30, 1, 1e6, 1e-8), (40, 1, 1e6, 1e-8), (40, 2, 1e6, 1e-8), (60, 1, 3e6, 1e-10),
            (80, 2, 1e7, 1e-8), (80, 1, 1e7, 1e-10), (160, 1, 1e8, 1e-12),
        ):  # fmt: skip
            label = f"{n} ANCF cables, EA {axial:g}, {parts} load steps, tolerance {tolerance:g}"
            yield of(label, partial(side.bent, n, parts, axial, tolerance), {20: 1e-4}.get(n))
    elif name == "S8":
        for n in (10, 13, 20, 40, 45, 80, 130):
            yield of(f"{n} ANCF cables, sparse eigenvalue solver", partial(side.frequencies, n, 1e6))


def _pinocchio(name: str) -> Iterator[Setting]:
    if name not in ("S1b", "S3a", "S4", "S4c"):
        return
    side = import_module("pinocchio_side")
    solve = {"S1b": side.crank, "S3a": side.pendulum}.get(name) or partial(side.arm, constant=name == "S4c")
    what = "angle by hand" if name == "S1b" else "aba"
    for k in range(4, 13):
        yield Setting("Pinocchio", f"{what}, LSODA, 1e-{k}", partial(solve, 10.0**-k), 10.0**-k)


PROGRAMS = {OURS: _ours, "Exudyn": _exudyn, "Pinocchio": _pinocchio}
