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

from spacar.arrays import Array
from spacar.errors import SpacarError

NUMPY_IMPORT = 0.07  # [s] on the machine on which the targets were measured
LONG = 0.3  # [s] a setting that takes longer is run once


@dataclass(frozen=True)
class Setting:
    """One way to solve a case: its name, the error asked for (None: a mesh decides), how to solve it, and whether the
    right-hand side is the compiled one."""

    label: str
    asked: float | None
    solve: Callable[[], Array]
    compiled: bool = False


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
    compiled: bool = False


@dataclass
class Measured:
    """All points of a case; `failed` are the settings that stopped, with the reason."""

    case: Case
    points: list[Point] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)

    @property
    def paths(self) -> tuple[bool, ...]:
        """`compiled` of the columns: the general path, and the compiled one where it was measured."""
        return tuple(sorted({False, *(p.compiled for p in self.points)}))

    def best(self, error: float, compiled: bool = False) -> Point | None:
        """The fastest point of the general or of the compiled path with at most this error."""
        good = [p for p in self.points if p.error <= error and p.compiled == compiled]
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
            result.failed.append(f"{setting.label}{mark(setting.compiled)}: {error}")
            continue
        result.points.append(
            Point(setting.label, setting.asked, relative_error(answer, reference), seconds, setting.compiled)
        )
    return result


def numpy_import(repeats: int = 7) -> float:
    """Median time of importing NumPy in a new process, less that of an empty process [s]."""
    code = "from time import perf_counter as c; a = c(); import numpy; print(c() - a)"
    runs = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(repeats)
    ]
    return median(float(r.stdout) for r in runs)


def mark(compiled: bool) -> str:
    return ", compiled" if compiled else ""


def lines(measured: Measured, machine: float) -> Iterator[str]:
    """The table of one case: best setting per level and path, targets scaled to this machine, what was missed."""
    yield f"== {measured.case.name}: {measured.case.title} (machine factor {machine:.2f})"
    for level in measured.case.levels:
        for compiled in measured.paths:
            best = measured.best(level, compiled)
            what = f"{1e3 * best.seconds:10.2f} ms  {best.label}, error {best.error:.1e}" if best else f"{'-':>13}"
            yield f"  error {level:.0e} {'compiled' if compiled else 'general ':8s} {what}"
    for target in measured.case.targets:
        for compiled in measured.paths:
            yield verdict(measured, target, machine, compiled)
    for reason in measured.failed:
        yield f"  stopped: {reason}"


def verdict(measured: Measured, target: Target, machine: float, compiled: bool = False) -> str:
    """One target and path: allowed time on this machine, ours, the ratio, met or MISSED."""
    allowed = target.seconds * target.factor * machine
    best = measured.best(target.error, compiled)
    times = f" ({target.factor:g} x {1e3 * target.seconds * machine:.2f})" if target.factor != 1.0 else ""
    head = f"  target {target.error:.1g}: {1e3 * allowed:.2f} ms{times}{mark(compiled)}"
    if best is None:
        return f"{head}, MISSED: error not reached"
    ratio = best.seconds / allowed
    return f"{head}, ours {1e3 * best.seconds:.2f} ms, ratio {ratio:.2f} {'met' if ratio <= 1.0 else 'MISSED'}"


def promise(measured: Measured) -> list[tuple[str, float, float]]:
    """(label, asked, obtained / asked) of every setting that was asked for an error."""
    return [(p.label + mark(p.compiled), p.asked, p.error / p.asked) for p in measured.points if p.asked is not None]
