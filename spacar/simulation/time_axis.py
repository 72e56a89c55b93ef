"""The time axis of a simulation, cut at every sampling time and at every break of a block.

Values next to a cut are those of the side on which the integration works: a piece is evaluated `shift` inside its
cuts, a few roundings of the largest time. Cuts nearer than four of these are one.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spacar.simulation.blocks import Block

EPS = float(np.finfo(float).eps)


class TimeAxis:
    """`cuts`: times from the first to the last one [s], each with the blocks that are sampled there. Piece k lies
    between cuts k and k + 1. `shift` [s], see above.
    """

    def __init__(self, first: float, last: float, blocks: Sequence[Block]) -> None:
        self.shift = 4.0 * EPS * max(abs(first), abs(last), last - first)
        found: list[tuple[float, Block | None]] = [(first, None), (last, None)]
        for block in blocks:
            found += [(t, None) for t in (*block.breaks, *block.breaks_until(first, last)) if first < t < last]
            if block.period is not None:
                period, offset = block.period, block.offset
                k0 = int(np.ceil((first - offset) / period - 1e-9))
                k1 = int(np.floor((last - offset) / period + 1e-9))
                found += [(min(max(offset + k * period, first), last), block) for k in range(k0, k1 + 1)]
        found.sort(key=lambda pair: pair[0])
        self.cuts: list[tuple[float, list[Block]]] = []
        for t, b in found:
            if not self.cuts or not self.same(t, self.cuts[-1][0]):
                self.cuts.append((t, []))
            if b is not None:
                self.cuts[-1][1].append(b)
        self.cuts[-1] = (last, self.cuts[-1][1])

    def same(self, t: float, other: float) -> bool:
        """Are two times one?"""
        return abs(t - other) <= 4.0 * self.shift

    def window(self, k: int) -> tuple[float, float]:
        """Where the blocks are evaluated in piece k: a little inside its cuts, but not inside the ends of the time."""
        low = self.cuts[k][0] + (self.shift if 0 < k < len(self.cuts) - 1 else 0.0)
        if k + 1 >= len(self.cuts):
            return low, low
        return low, self.cuts[k + 1][0] - (self.shift if k + 2 < len(self.cuts) else 0.0)

    def cut(self, k: int, t: float) -> float:
        """Cut at t, behind cut k. Returns the time of the cut: t, or that of an existing cut at the same time."""
        for place in range(k + 1, len(self.cuts)):
            other = self.cuts[place][0]
            if self.same(t, other):
                return other
            if other > t:
                self.cuts.insert(place, (t, []))
                return t
        return t  # behind the end
