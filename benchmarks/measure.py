"""Time against error: settings of a case, their medians, and the table against the targets.

The clock runs from a parsed deck to the last frame: numbering, assembly, start position, integration, every output with
accelerations, stresses and reactions. The error of an answer is max |answer - reference| / max |reference|.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from statistics import median
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from spacar.errors import SpacarError

Array = NDArray[np.float64]
NUMPY_IMPORT = 0.07  # [s] on the machine on which the targets were measured
LONG = 1.0  # [s] a setting that takes longer is not repeated more than once


@dataclass(frozen=True)
class Setting:
    """One way to solve a case: what it is called, the error asked for (None: a mesh decides), how to solve it."""

    label: str
    asked: float | None
    solve: Callable[[], Array]


@dataclass(frozen=True)
class Target:
    """`seconds` at `error` on the machine of the targets, of which we may take `factor` times as much."""

    error: float
    seconds: float
    factor: float = 1.0


@dataclass(frozen=True)
class Case:
    """A row of the table. `settings` from cheap to dear; `reference` is solved once and not timed."""

    name: str
    title: str
    reference: Callable[[], Array]
    settings: Callable[[], Iterable[Setting]]
    targets: tuple[Target, ...] = ()
    levels: tuple[float, ...] = (1e-4, 1e-6, 1e-8, 1e-10)


@dataclass(frozen=True)
class Point:
    label: str
    asked: float | None
    error: float
    seconds: float


@dataclass
class Measured:
    """All points of a case; `failed` are the settings that stopped, with the reason."""

    case: Case
    points: list[Point] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)

    def best(self, error: float) -> Point | None:
        """The fastest point with at most this error."""
        good = [p for p in self.points if p.error <= error]
        return min(good, key=lambda p: p.seconds) if good else None


def relative_error(answer: Array, reference: Array) -> float:
    """max |answer - reference| / max |reference|."""
    return float(np.max(np.abs(answer - reference)) / np.max(np.abs(reference)))


def timed(solve: Callable[[], Array], repeats: int) -> tuple[Array, float]:
    """The answer and the median of the repeats; a long one is run once."""
    times: list[float] = []
    while len(times) < repeats and not (times and times[0] > LONG):
        begin = perf_counter()
        answer = solve()
        times.append(perf_counter() - begin)
    return answer, median(times)


def measure(case: Case, repeats: int) -> Measured:
    """All settings of a case; one that fails is recorded with its reason."""
    reference = case.reference()
    result = Measured(case)
    for setting in case.settings():
        try:
            answer, seconds = timed(setting.solve, repeats)
        except SpacarError as error:
            result.failed.append(f"{setting.label}: {error}")
            continue
        result.points.append(Point(setting.label, setting.asked, relative_error(answer, reference), seconds))
    return result


def numpy_import(repeats: int = 7) -> float:
    """Median time of importing NumPy in a new process, less that of an empty process [s]."""
    code = "from time import perf_counter as c; a = c(); import numpy; print(c() - a)"
    runs = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(repeats)
    ]
    return median(float(r.stdout) for r in runs)


def lines(measured: Measured, machine: float) -> Iterator[str]:
    """The table of one case: best setting per level, targets scaled to this machine, what was missed."""
    yield f"== {measured.case.name}: {measured.case.title} (machine factor {machine:.2f})"
    for level in measured.case.levels:
        best = measured.best(level)
        what = (
            f"{1e3 * best.seconds:10.2f} ms  {best.label}, error {best.error:.1e}" if best else "         - not reached"
        )
        yield f"  error {level:.0e} {what}"
    for target in measured.case.targets:
        yield verdict(measured, target, machine)
    for reason in measured.failed:
        yield f"  stopped: {reason}"


def verdict(measured: Measured, target: Target, machine: float) -> str:
    """One target: allowed time on this machine, ours, the ratio, met or MISSED."""
    allowed = target.seconds * target.factor * machine
    best = measured.best(target.error)
    times = f" ({target.factor:g} x {1e3 * target.seconds * machine:.2f})" if target.factor != 1.0 else ""
    head = f"  target {target.error:.1g}: {1e3 * allowed:.2f} ms{times}"
    if best is None:
        return f"{head}, MISSED: error not reached"
    ratio = best.seconds / allowed
    return f"{head}, ours {1e3 * best.seconds:.2f} ms, ratio {ratio:.2f} {'met' if ratio <= 1.0 else 'MISSED'}"


def promise(measured: Measured) -> list[tuple[str, float, float]]:
    """(label, asked, obtained / asked) of every setting that was asked for an error."""
    return [(p.label, p.asked, p.error / p.asked) for p in measured.points if p.asked is not None]
