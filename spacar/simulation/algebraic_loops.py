"""Algebraic loops: blocks whose outputs depend on each other at the same time.

A loop is cut at as few blocks as a greedy choice finds (those with the fewest outputs into the loop). With v the
outputs of the cut blocks, everything else in the loop follows in order, and so do the outputs F(v) of the cut blocks;
Newton's method solves F(v) = v,

    (1 - dF/dv) dv = F(v) - v,

with a Jacobian by forward differences of sqrt(eps) of the size of the signals, kept as long as a correction is at most
a tenth of the one before. It ends when the correction, times theta/(1 - theta) with the contraction theta that is seen,
is below eps times what is summed in the inputs of the loop, or when it no longer becomes smaller and is below 100 times
that; more than MOST_ITERATIONS corrections or a singular 1 - dF/dv (a loop of gain one) are failures. The start is the
last solution.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.errors import AnalysisError
from spacar.simulation.blocks import Block

Needs = dict[str, list[str]]  # blocks whose outputs a block needs, by name

DIFFERENCE = EPS**0.5
MOST_ITERATIONS = 25
SLOW = 0.1  # contraction beyond which the Jacobian is computed again
FEW_DIGITS = 100.0  # units of rounding that a solution may be uncertain by


@dataclass
class Group:
    """Blocks that are evaluated together: one block, or an algebraic loop, whose `torn` blocks come last.

    tearing   numbers of the outputs of the torn blocks that go into the loop, among all outputs
    inputs    rows of the wiring that are inputs of the loop
    """

    blocks: tuple[Block, ...]
    torn: tuple[Block, ...] = ()
    tearing: Index = field(default_factory=lambda: np.zeros(0, np.int64))
    inputs: Index = field(default_factory=lambda: np.zeros(0, np.int64))
    loop: str = ""
    jacobian: Array | None = None

    def solve(self, t: float, y: Array, wiring: Array, sweep: Callable[[], None]) -> int:
        """Find the outputs of the loop and leave them in y, all outputs; returns the number of calls of `sweep`.

        sweep   evaluates the blocks of the loop once, from the values in y

        Raises AnalysisError 'simulation.algebraic-loop', and those of the blocks.
        """
        calls, last, v = 0, np.inf, y[self.tearing].copy()
        if not np.isfinite(v).all():
            v = np.zeros(len(v))

        def residual(at: Array) -> Array:
            nonlocal calls
            calls += 1
            y[self.tearing] = at
            try:
                sweep()
            except AnalysisError as error:
                if calls == 1 or error.code != "simulation.not-finite":
                    raise
                self._fail(t, f"the corrections go astray ({error})")
            return y[self.tearing] - at

        for _ in range(MOST_ITERATIONS):
            r = residual(v)
            size = float(np.max(np.abs(wiring[self.inputs]) @ np.abs(y), initial=0.0))
            size = max(size, float(np.max(np.abs(y[self.tearing]), initial=0.0)), float(np.max(np.abs(v))))
            if not np.isfinite(r).all():
                break
            if not r.any():
                return calls
            fresh = self.jacobian is None
            if self.jacobian is None:
                self.jacobian = -differences(residual, v, r, np.maximum(np.abs(v), size or 1.0))
            try:
                dv = np.linalg.solve(self.jacobian, r)
            except np.linalg.LinAlgError:
                self._fail(t, "it has the gain one, so that any value solves it or none")
            step = float(np.max(np.abs(dv)))
            if not np.isfinite(step) or (fresh and step > 1e-3 / EPS * max(size, 1e-300)):
                self._fail(t, "it has the gain one, so that any value solves it or none")
            v = v + dv
            theta = step / last  # zero after the first correction, from which no contraction is known
            done = 0.0 < theta < 1.0 and theta / (1.0 - theta) * step <= EPS * size
            if step <= EPS * size or done or (theta >= SLOW and step <= FEW_DIGITS * EPS * size):
                r = residual(v)
                if np.max(np.abs(r)) <= max(1e-6 * float(np.max(np.abs(v))), FEW_DIGITS * EPS * size):
                    return calls
                break
            if theta > SLOW and not fresh:
                self.jacobian = None
            last = step
        self.jacobian = None
        return self._fail(t, f"{MOST_ITERATIONS} corrections did not solve it, the last one was {last:.3g}")

    def _fail(self, t: float, why: str) -> int:
        text = (
            f"the algebraic loop {self.loop} has no solution at t = {t:.9g}: {why}; change a gain, or put a block with"
            " states, a unit delay or a sampled block with delay into it"
        )
        raise AnalysisError(text, "simulation.algebraic-loop")


def differences(function: Callable[[Array], Array], z: Array, start: Array, size: Array) -> Array:
    """d(function)/dz (n, m) at z (m,), where it is `start` (n,), by forward differences of sqrt(eps) of `size` (m,)."""
    out = np.empty((len(start), len(z)))
    for k in range(len(z)):
        moved = z.copy()
        moved[k] += DIFFERENCE * size[k]
        out[:, k] = (function(moved) - start) / (moved[k] - z[k])
    return out


def components(needs: Needs) -> list[list[str]]:
    """Strongly connected components, each after those it needs: the blocks of one reach the same blocks, and more than
    those of the components that it needs."""
    reach: dict[str, frozenset[str]] = {}
    for root in needs:
        seen, stack = {root}, [root]
        while stack:
            more = [other for other in needs[stack.pop()] if other not in seen]
            seen.update(more)
            stack += more
        reach[root] = frozenset(seen)
    found: dict[frozenset[str], list[str]] = {}
    for name in sorted(needs, key=lambda name: len(reach[name])):
        found.setdefault(reach[name], []).append(name)
    return list(found.values())


def one_loop(needs: Needs, members: list[str]) -> list[str]:
    """The names along one loop among these blocks, the first one again at the end."""
    trail, name = [], members[0]
    while name not in trail:
        trail.append(name)
        name = next(other for other in needs[name] if other in members)
    return [*trail[trail.index(name) :], name]


def torn_order(needs: Needs, members: list[str], sizes: dict[str, int]) -> tuple[list[str], list[str]]:
    """The blocks of a loop in an order of evaluation, and those at its end whose outputs must be guessed."""
    torn: list[str] = []
    while True:
        free = {n: [o for o in needs[n] if o in members and o not in torn] for n in members if n not in torn}
        parts = components(free)
        loops = [part for part in parts if len(part) > 1 or part[0] in free[part[0]]]
        if not loops:
            return [name for part in parts for name in part], torn
        torn.append(min((name for part in loops for name in part), key=lambda name: sizes[name]))
