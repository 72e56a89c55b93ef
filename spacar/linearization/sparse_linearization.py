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
from spacar.linear_systems.linear_system import compressed_sum, rows_of
from spacar.linearization.coefficients import Coefficients, structure
from spacar.linearization.descriptor import DescriptorSystem
from spacar.linearization.signals import DRIVING_SIGN, ORDER, Signal
from spacar.mechanism.numbering import Numbering, places_in

Term = tuple[Any, int]  # a matrix, and the first column of the system at which it stands


class Entries(list[tuple[Index, Index, Array]]):
    """Rows, columns and values of the parts of a sum; entries that happen to be zero stay in it."""

    def ones(self, rows: Index, columns: Index, value: float = 1.0) -> None:
        self.append((rows, columns, np.full(len(rows), value)))

    def add(self, row: Index, factor: float, *terms: Term) -> None:
        """factor x the matrices of the terms, their row i in row[i] (none where that is -1)."""
        from scipy.sparse import coo_array

        for matrix, first in terms:
            found = coo_array(matrix)
            rows = row[found.row]
            keep = np.flatnonzero(rows >= 0)
            self.append((rows[keep], first + found.col[keep].astype(np.int64), factor * found.data[keep]))


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
        self.given_e, self.active = np.arange(es["input"].stop), np.arange(es["input"].stop, ne)
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
        self.U, self.c = k.U, k.c
        self.position_row = places_in(n.ne, k.h, self.places.x + k.c)
        self.velocity_row = places_in(n.ne, k.E, self.places.v + k.U)
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
        entries.add(rows, -1.0, (mass, p.a), (damping, p.v), (stiffness, p.x), (c.V.T, p.s))
        # positions and velocities
        rate, second = self._rates(c)
        entries.add(self.position_row, -1.0, (c.V, p.x))
        entries.add(self.velocity_row, -1.0, *rate)
        # stresses: accelerations of the given deformations, the law of the others
        entries.add(places_in(n.ne, p.given_e, p.s + p.given_e), -1.0, *second)
        law_x, law_v = c.S @ c.V + c.Sd @ c.rate_x + c.stress_x, c.Sd @ c.V + c.stress_v
        entries.add(places_in(n.ne, p.active, p.s + p.active), 1.0, (law_x, p.x), (law_v, p.v))
        # rates of the state
        entries.add(places_in(n.ne, p.dynamic_e, p.rate_e), 1.0, *second)
        entries.add(places_in(n.ne, p.kinematic_e, p.k_e), 1.0, *rate)
        return compressed_sum(entries, (p.size, p.size))

    def _rates(self, c: Coefficients) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
        """d(ed) and d(edd)."""
        p = self.places
        return ((c.V, p.v), (c.rate_x, p.x)), ((c.V, p.a), (c.second_v, p.v), (c.second_x, p.x))

    def _given(self) -> Entries:
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
        entries.ones(p.s + p.active, p.s + p.active, -1.0)
        return entries

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
        return compressed_sum(entries, (p.size, len(inputs)))

    def _output_matrix(self, c: Coefficients) -> Any:
        p, n = self.places, self.n
        rate, second = self._rates(c)
        places = {"OUTX": p.x, "OUTXP": p.v, "OUTXDP": p.a, "OUTS": p.s}
        maps: dict[str, tuple[Term, ...]] = {"OUTE": ((c.V, p.x),), "OUTEP": rate, "OUTEDP": second}
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
            entries.add(rows, 1.0, *maps[signal.kind])
        return compressed_sum(entries, (len(self.outputs), p.size))


def _filled(pattern: Any, A: Any) -> Any:
    """A with the places of `pattern`, zeros where it has no entries; both in compressed rows."""
    from scipy.sparse import csr_array

    A.sort_indices()
    known, wanted = (rows_of(matrix) * A.shape[1] + matrix.indices for matrix in (pattern, A))
    places = np.minimum(np.searchsorted(known, wanted), max(len(known) - 1, 0))
    if len(wanted) and not np.array_equal(known[places], wanted):
        text = "the linearized equations have entries where those of the first state had none: a user function"
        text += " (USERSIG) has to return the same rows always, with zeros where nothing acts"
        raise AnalysisError(text, "user-function.rows")
    data = np.zeros(len(known))
    data[places] = A.data
    return csr_array((data, pattern.indices, pattern.indptr), A.shape)
