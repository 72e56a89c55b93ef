"""Output times that are computed when they are asked for: a billion of them need no memory."""

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
        return self._at(np.arange(first, last))

    def _at(self, numbers: np.ndarray) -> np.ndarray:
        """Times with these numbers from 0."""
        times = numbers * self.step
        times += self.start
        times[numbers == self.n] = self.end
        return times

    @overload
    def __getitem__(self, i: int) -> float: ...
    @overload
    def __getitem__(self, i: slice) -> list[float]: ...
    def __getitem__(self, i: int | slice) -> float | list[float]:
        if isinstance(i, slice):
            found: list[float] = self._at(np.arange(*i.indices(len(self)))).tolist()
            return found
        k = i + len(self) if i < 0 else i
        if not 0 <= k < len(self):
            raise IndexError(i)
        return self._one(k)

    def _one(self, k: int) -> float:
        return self.end if k == self.n else k * self.step + self.start


@dataclass(frozen=True)
class RemainingTimes(EvenTimes):
    """`first`, then the even times from number `skip` on, which is later."""

    first: float = 0.0
    skip: int = 1

    def __len__(self) -> int:
        return self.n - self.skip + 2

    def _at(self, numbers: np.ndarray) -> np.ndarray:
        times = super()._at(numbers + (self.skip - 1))
        times[numbers == 0] = self.first
        return times

    def _one(self, k: int) -> float:
        return super()._one(k + self.skip - 1) if k else self.first
