"""Bodies that tumble: Euler parameters as dynamic coordinates through any attitude.

Of the four Euler parameters of a node three are coordinates (DYNX: lambda1, lambda2, lambda3), and the fourth follows
from lambda.lambda = 1. Its rate goes with the reciprocal of its value, so these coordinates end where it is zero, with
the usual choice at a rotation of 180 degrees. The largest of four numbers whose squares add up to one is at least 1/2:
when the dependent one has fallen below LEAST, the largest one takes its place from the last accepted step on. This is a
change of coordinates (of charts): configuration, velocity and their continuation stay, and frames hold the coordinates
in the order of the model, whatever chart they are computed in.

Applied to nodes all of whose three parameters are dynamic, in models without user functions (these know coordinates by
their places). Otherwise the motion ends at half a turn with a message (`spacar.kinematics.regularity.HalfTurns`).
Transfer functions and linearized equations are those of the model's own degrees of freedom
(`spacar.forward.motion.motion`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import Statement
from spacar.dynamics.loaded_mechanism import Moving
from spacar.frame import X_FIELDS, Frame, StoredFrames
from spacar.mechanism import Mechanism, build
from spacar.mechanism.numbering import Numbering

LEAST = 0.4  # of the dependent Euler parameter; the largest one is at least 0.5


class ChartEnds(Exception):
    """Raised after an accepted step; caught where the next chart is made."""


def tumbling_nodes(mechanism: Mechanism) -> tuple[int, ...]:
    """Nodes whose lambda1, lambda2 and lambda3 are all dynamic, where charts may change."""
    n, where = mechanism.numbering, mechanism.numbering.x_class["dynamic"]
    if n.planar or where.start == where.stop or mechanism.user_signal is not None:
        return ()
    dynamic = {n.x_owner(i) for i in range(where.start, where.stop)}
    free = {node for node, c in dynamic if n.kind[node] == "orientation"}
    return tuple(sorted(node for node in free if all((node, c) in dynamic for c in (2, 3, 4))))


@dataclass(frozen=True)
class Chart:
    """A choice of the dependent Euler parameter (1 to 4) of each tumbling node, as a mechanism.

    at   (nx,) where the coordinates of the model are in x of this mechanism
    """

    mechanism: Mechanism
    dependent: Mapping[int, int]
    at: Index

    @classmethod
    def of(cls, given: Mechanism, dependent: Mapping[int, int]) -> Chart:
        """The mechanism with these dependent parameters; `given` itself where all of them are 1."""
        if all(c == 1 for c in dependent.values()):
            return cls(given, dependent, np.arange(given.numbering.nx))
        deck = replace(given.deck, statements=tuple(_in_chart(given.deck.statements, dependent)))
        made = build(deck, 1, beams=given.settings.beams)
        n, m = given.numbering, made.numbering
        at = np.array([m.x_index(*n.x_owner(i)) for i in range(n.nx)], np.int64)
        return cls(replace(made, settings=given.settings, deck=given.deck), dependent, at)

    def suited(self, x: Array) -> dict[int, int] | None:
        """Better dependent parameters at x (nx,) of this chart, None while this one serves."""
        n, found = self.mechanism.numbering, dict(self.dependent)
        for node, c in self.dependent.items():
            if abs(x[n.x_index(node, c)]) < LEAST:
                found[node] = 1 + int(np.argmax([abs(x[n.x_index(node, k)]) for k in (1, 2, 3, 4)]))
        return None if found == dict(self.dependent) else found

    def view(self, frame: Frame) -> Frame:
        """A frame of this chart with the coordinates in the order of the model."""
        return replace(frame, **{name: getattr(frame, name)[self.at] for name in X_FIELDS})

    def views(self, block: Sequence[Frame]) -> Sequence[Frame]:
        if not isinstance(block, StoredFrames):
            return [self.view(frame) for frame in block]
        kept = block.variables
        ordered = {name: kept[name][:, self.at] for name in X_FIELDS}
        return StoredFrames(block.t, kept | ordered, block.statistics, block.lost)

    def state(self, frame: Frame, y: Array, n: Numbering) -> Array:
        """The state of this chart at a `frame` in the order of the model; y, n: state and numbering of another chart.

        Only x dynamic and its rates differ.
        """
        x, xd = np.empty_like(frame.x), np.empty_like(frame.xd)
        x[self.at], xd[self.at] = frame.x, frame.xd
        out, mine = y.copy(), self.mechanism.numbering.x_class["dynamic"]
        k = mine.stop - mine.start
        rates = n.nkddof
        out[:k], out[rates : rates + k] = x[mine], xd[mine]
        return out

    def moving(self, frame: Frame) -> Moving:
        """Where an evaluator of this chart goes on from a frame in the order of the model."""
        x, xd, xdd = np.empty((3, len(frame.x)))
        x[self.at], xd[self.at], xdd[self.at] = frame.x, frame.xd, frame.xdd
        return Moving(frame.t, x, xd, xdd, frame.e.copy())


def _in_chart(statements: tuple[Statement, ...], dependent: Mapping[int, int]) -> list[Statement]:
    """The statements with DYNX for the other parameters of the tumbling nodes. Their start values, which belong to the
    first chart, are left out."""
    found = []
    for s in statements:
        node = s.values[0] if s.values else None
        if s.keyword not in ("DYNX", "STARTDX") or node not in dependent:
            found.append(s)
    for node, c in dependent.items():
        origin = next(s for s in statements if s.keyword == "DYNX" and s.values[0] == node)
        others = tuple(k for k in (1, 2, 3, 4) if k != c)
        found.append(origin._replace(values=(node, *others), place=()))
    return found


class ChartWatch:
    """Watches the dependent parameters after accepted steps. When one is too small the step after it is not taken: the
    next chart goes on from `t`, `y`, up to which all outputs have been given."""

    def __init__(self, chart: Chart) -> None:
        self.chart = chart
        self.next: dict[int, int] | None = None
        self.t, self.y = 0.0, np.zeros(0)

    def check(self, t: float, y: Array, x: Array) -> None:
        """Raises ChartEnds."""
        if self.next is not None:
            raise ChartEnds
        self.next = self.chart.suited(x)
        if self.next is not None:
            self.t, self.y = t, y.copy()
