"""Output times that are computed when they are asked for: a billion of them need no memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import overload

import numpy as np

from spacar.errors import UsageError

MOST_STEPS = 10**15
"""So many equal parts of an interval are still told apart in double precision (2^53 = 9e15), sums included."""


@dataclass(frozen=True)
class EvenTimes(Sequence[float]):
    """start + i (end - start)/n, i = 0 ... n, the last one exactly `end` [s]: the numbers of np.linspace.

    Raises UsageError for times that do not increase.
    """

    start: float
    end: float
    n: int

    def __post_init__(self) -> None:
        differ = 0 < self.n <= MOST_STEPS and self.start < self.start + self.step and self.end - self.step < self.end
        if not differ:
            raise UsageError(
                f"{self.n} output steps from {self.start:.9g} s to {self.end:.9g} s: times that differ are needed, and "
                f"at most {MOST_STEPS:.0e}",
                "integrator.times",
            )

    @cached_property
    def step(self) -> float:
        return (self.end - self.start) / self.n

    def __len__(self) -> int:
        return self.n + 1

    def part(self, first: int, last: int) -> np.ndarray:
        """(last - first,) the times from number `first` to before `last`, 0 <= first <= last <= their number."""
        times = np.arange(float(first), last)
        times *= self.step
        times += self.start
        if last > self.n:
            times[self.n - first :] = self.end
        return times

    @overload
    def __getitem__(self, i: int) -> float: ...
    @overload
    def __getitem__(self, i: slice) -> list[float]: ...
    def __getitem__(self, i: int | slice) -> float | list[float]:
        if isinstance(i, slice):
            numbers = np.arange(*i.indices(self.n + 1))
            times = numbers * self.step + self.start
            times[numbers == self.n] = self.end
            found: list[float] = times.tolist()
            return found
        k = i + self.n + 1 if i < 0 else i
        if not 0 <= k <= self.n:
            raise IndexError(i)
        return self.end if k == self.n else k * self.step + self.start


@dataclass(frozen=True)
class RemainingTimes(EvenTimes):
    """`first`, then the even times from number `skip` on, which is later."""

    first: float = 0.0
    skip: int = 1

    def __len__(self) -> int:
        return self.n - self.skip + 2

    def part(self, first: int, last: int) -> np.ndarray:
        return np.array(self[first:last], float)

    @overload
    def __getitem__(self, i: int) -> float: ...
    @overload
    def __getitem__(self, i: slice) -> list[float]: ...
    def __getitem__(self, i: int | slice) -> float | list[float]:
        if isinstance(i, slice):
            a, b, step = i.indices(len(self))
            if a > 0 and step > 0:
                return super().__getitem__(slice(a + self.skip - 1, b + self.skip - 1, step))
            return [self[k] for k in range(a, b, step)]
        k = i + len(self) if i < 0 else i
        if not 0 <= k < len(self):
            raise IndexError(i)
        return self.first if k == 0 else float(super().__getitem__(k + self.skip - 1))
