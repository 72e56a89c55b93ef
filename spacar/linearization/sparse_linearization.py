"""The descriptor system of a state: sums of element blocks, no transfer functions (theory-system.md 5.7).

Rows, after those of the state (ds_k/dt of the kinematic coordinates follows from dxd and dx; dqdd is a coordinate of
dxdd or a deformation d(edd)):

    accelerations (nx)  equilibrium -[M dxdd + ... + V^T dsigma] + df = 0;  fixed and input coordinates: P2 u - dxdd = 0
    positions (nx)      given values - dx = 0;  at the places of the calculable coordinates the rows h: given - V dx = 0
    velocities (nx)     given rates - dxd = 0;  at those of U the rows E: given rates - (V dxd + H1 dx) = 0
    stresses (ne)       fixed and input deformations: P2 u - d(edd) = 0;
                        others: S de + Sd ded + stress_x dx + stress_v dxd - s_u du - dsigma = 0

Nothing is inverted and no degree of freedom appears in a product, so that relative coordinates cost no digits.
"""

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import StressLaw
from spacar.errors import AnalysisError
from spacar.linearization.coefficients import Coefficients, structure
from spacar.linearization.descriptor import DescriptorSystem
from spacar.linearization.signals import DRIVING_SIGN, ORDER, Signal
from spacar.mechanism.numbering import Numbering, places_in


class _Places:
    """Where the rows and columns of the system are."""

    def __init__(self, n: Numbering) -> None:
        nx, ne = n.nx, n.ne
        self.n_states = n.nkddof + n.nddof
        at = self.n_states
        self.a, self.x, self.v, self.s = at, at + nx, at + 2 * nx, at + 3 * nx  # accelerations, ..., stresses
        self.size = at + 3 * nx + ne
        xs, es = n.x_class, n.e_class
        self.given_x = np.r_[0 : xs["fixed"].stop, xs["input"].start : xs["input"].stop]
        self.moving_x = np.setdiff1d(np.arange(nx), self.given_x)
        self.given_e = np.arange(es["input"].stop)
        # in the order of the state; behind its columns, rates of the dynamic ones
        parts = xs["dynamic"], es["dynamic"], xs["kinematic"], es["kinematic"]
        self.dynamic_x, self.dynamic_e, self.kinematic_x, self.kinematic_e = (np.arange(p.start, p.stop) for p in parts)
        ends = np.cumsum([p.stop - p.start for p in parts])
        self.q_x, self.q_e, self.k_x, self.k_e = np.split(np.arange(ends[-1]), ends[:-1])
        self.rate_x, self.rate_e = n.nkddof + self.q_x, n.nkddof + self.q_e


class SparseLinearization:
    """Makes the descriptor system of every state of one mechanism: the parts that never change are made once."""

    def __init__(
        self, dynamics: Dynamics, inputs: Sequence[Signal], outputs: Sequence[Signal], moving: bool = True,
        free: StressLaw | None = None,
    ) -> None:  # fmt: skip
        """`moving`: may any state have velocities? At rest there are fewer entries. `free`: prescribed degrees of
        freedom are states too, with this law of their deformations (mode 3)."""
        k = dynamics.kinematics
        n = dynamics.numbering if free is None else dynamics.numbering.all_dynamic
        self.n, self.places = n, _Places(n)
        self.inputs, self.outputs = inputs, outputs
        self.E, self.U, self.h, self.c = k.E, k.U, k.h, k.c
        self.position_row = places_in(n.ne, self.h, self.places.x + self.c)
        self.velocity_row = places_in(n.ne, self.E, self.places.v + self.U)
        self._constant = self._given()
        self.B = self.input_matrix(inputs)
        self._widest = partial(structure, dynamics, moving, free)

    def __call__(self, c: Coefficients) -> DescriptorSystem:
        """The system of the state of these coefficients. A and C have the same places at all states."""
        A, C = map(_filled, self._patterns, (self._state_matrix(c), self._output_matrix(c)))
        return DescriptorSystem(A, self.B, C, self.places.n_states)

    def once(self, c: Coefficients) -> DescriptorSystem:
        """The same with the places that this state has."""
        return DescriptorSystem(self._state_matrix(c), self.B, self._output_matrix(c), self.places.n_states)

    @cached_property
    def _patterns(self) -> tuple[Any, Any]:
        widest = self._widest()
        return self._state_matrix(widest), self._output_matrix(widest)

    def _state_matrix(self, c: Coefficients) -> Any:
        p, n = self.places, self.n
        entries = Entries(self._constant)
        # accelerations: equilibrium
        rows, back = places_in(n.nx, p.moving_x, p.a + p.moving_x), c.V.T @ c.deformation_inertia
        stiffness = c.inertia_x + c.geometric + c.load_x + c.user_x + back @ c.second_x
        damping, mass = c.inertia_v + c.user_v + back @ c.second_v, c.M + back @ c.V
        for matrix, first in ((mass, p.a), (damping, p.v), (stiffness, p.x), (c.V.T, p.s)):
            entries.add(matrix, rows, first, -1.0)
        # positions and velocities
        entries.add(c.V, self.position_row, p.x, -1.0)
        entries.add(c.V, self.velocity_row, p.v, -1.0)
        entries.add(c.rate_x, self.velocity_row, p.x, -1.0)
        # stresses: accelerations of the given deformations, the law of the others
        rows = places_in(n.ne, p.given_e, p.s + p.given_e)
        second = ((c.V, p.a), (c.second_v, p.v), (c.second_x, p.x))
        for matrix, first in second:
            entries.add(matrix, rows, first, -1.0)
        active = np.arange(len(p.given_e), n.ne)
        rows = places_in(n.ne, active, p.s + active)
        entries.add(c.S @ c.V + c.Sd @ c.rate_x + c.stress_x, rows, p.x, 1.0)
        entries.add(c.Sd @ c.V + c.stress_v, rows, p.v, 1.0)
        # rates of the state
        rows = places_in(n.ne, p.dynamic_e, p.rate_e)
        for matrix, first in second:
            entries.add(matrix, rows, first, 1.0)
        rows = places_in(n.ne, p.kinematic_e, p.k_e)
        entries.add(c.V, rows, p.v, 1.0)
        entries.add(c.rate_x, rows, p.x, 1.0)
        return entries.matrix((p.size, p.size))

    def _given(self) -> tuple[list[Index], list[Index], list[Array]]:
        p, n = self.places, self.n
        entries = Entries()
        q = np.concatenate((p.q_x, p.q_e))
        entries.ones(q, np.concatenate((p.rate_x, p.rate_e)))  # d(dq)/dt = dqd
        entries.ones(p.k_x, p.v + p.kinematic_x)
        entries.ones(p.rate_x, p.a + p.dynamic_x)
        entries.ones(p.a + p.given_x, p.a + p.given_x, -1.0)
        others = np.setdiff1d(np.arange(n.nx), self.c)
        entries.ones(p.x + others, p.x + others, -1.0)
        entries.ones(p.x + p.dynamic_x, p.q_x)
        entries.ones(p.x + p.kinematic_x, p.k_x)
        others = np.setdiff1d(np.arange(n.nx), self.U)
        entries.ones(p.v + others, p.v + others, -1.0)
        entries.ones(p.v + p.dynamic_x, p.rate_x)
        for row, deformations, columns in (
            (self.position_row, p.dynamic_e, p.q_e), (self.position_row, p.kinematic_e, p.k_e),
            (self.velocity_row, p.dynamic_e, p.rate_e),
        ):  # fmt: skip
            there = row[deformations] >= 0  # a slip is no configuration
            entries.ones(row[deformations[there]], columns[there])
        active = np.arange(len(p.given_e), n.ne)
        entries.ones(p.s + active, p.s + active, -1.0)
        return entries.parts

    def input_matrix(self, inputs: Sequence[Signal]) -> Any:
        """B of these inputs, the same at all states."""
        p = self.places
        entries = Entries()
        for j, signal in enumerate(inputs):
            i = signal.index
            if signal.kind == "INPUTF":
                row, value = p.a + i, 1.0
            elif signal.kind == "INPUTS":
                row, value = p.s + i, -DRIVING_SIGN
            elif signal.kind.startswith("INX"):
                row, value = (p.x, p.v, p.a)[ORDER[signal.kind]] + i, 1.0
            else:
                first = (self.position_row[i], self.velocity_row[i], p.s + i)
                row, value = int(first[ORDER[signal.kind]]), 1.0
                if row < 0:  # the value of a slip: no configuration
                    continue
            entries.ones(np.array([row]), np.array([j]), value)
        return entries.matrix((p.size, len(inputs)))

    def _output_matrix(self, c: Coefficients) -> Any:
        p, n = self.places, self.n
        V, H1 = (c.V, p.v), (c.rate_x, p.x)
        second = ((c.V, p.a), (c.second_v, p.v), (c.second_x, p.x))
        places = {"OUTX": p.x, "OUTXP": p.v, "OUTXDP": p.a, "OUTS": p.s}
        maps: dict[str, tuple[tuple[Any, int], ...]] = {
            "OUTE": ((c.V, p.x),), "OUTEP": (V, H1), "OUTEDP": second,
        }  # fmt: skip
        if any(signal.kind == "OUTF" for signal in self.outputs):
            back = c.V.T @ c.deformation_inertia
            maps["OUTF"] = (
                (c.M + back @ c.V, p.a), (c.inertia_v + back @ c.second_v, p.v),
                (c.inertia_x + c.geometric + back @ c.second_x, p.x), (c.V.T, p.s),
            )  # fmt: skip
        entries = Entries()
        for j, signal in enumerate(self.outputs):
            if signal.kind in places:
                entries.ones(np.array([j]), np.array([places[signal.kind] + signal.index]))
                continue
            rows = places_in(n.nx if signal.kind == "OUTF" else n.ne, np.array([signal.index]), np.array([j]))
            for matrix, first in maps[signal.kind]:
                entries.add(matrix, rows, first, 1.0)
        return entries.matrix((len(self.outputs), p.size))


def _filled(pattern: Any, A: Any) -> Any:
    """A with the places of `pattern`, zeros where it has no entries; both in compressed rows."""
    from scipy.sparse import csr_array

    A.sort_indices()
    rows, width = np.arange(A.shape[0]), A.shape[1]
    known = np.repeat(rows, np.diff(pattern.indptr)) * width + pattern.indices
    wanted = np.repeat(rows, np.diff(A.indptr)) * width + A.indices
    places = np.minimum(np.searchsorted(known, wanted), max(len(known) - 1, 0))
    if len(wanted) and not np.array_equal(known[places], wanted):
        text = "the linearized equations have entries where those of the first state had none: a user function"
        text += " (USERSIG) has to return the same rows always, with zeros where nothing acts"
        raise AnalysisError(text, "user-function.rows")
    data = np.zeros(len(known))
    data[places] = A.data
    return csr_array((data, pattern.indices, pattern.indptr), A.shape)


class Entries:
    """A growing list of (row, column, value)."""

    def __init__(self, parts: tuple[list[Index], list[Index], list[Array]] | None = None) -> None:
        self.parts = ([], [], []) if parts is None else (list(parts[0]), list(parts[1]), list(parts[2]))

    def ones(self, rows: Index, columns: Index, value: float = 1.0) -> None:
        self._append(rows, columns, np.full(len(rows), value))

    def add(self, matrix: Any, row: Index, first_column: int, factor: float) -> None:
        """factor x matrix, its row i in row[i] (none where that is -1), its columns from `first_column` on."""
        from scipy.sparse import coo_array

        found = coo_array(matrix)
        rows = row[found.row]
        keep = np.flatnonzero(rows >= 0)
        self._append(rows[keep], first_column + found.col[keep].astype(np.int64), factor * found.data[keep])

    def _append(self, rows: Index, columns: Index, values: Array) -> None:
        for part, new in zip(self.parts, (rows, columns, values), strict=True):
            part.append(new)

    def matrix(self, shape: tuple[int, int]) -> Any:
        """The sum of all, in compressed rows; entries that happen to be zero stay."""
        from scipy.sparse import coo_array

        if not self.parts[0]:
            return coo_array(shape).tocsr()
        rows, columns, values = (np.concatenate(part) for part in self.parts)
        out = coo_array((values, (rows, columns)), shape).tocsr()
        out.sort_indices()
        return out
