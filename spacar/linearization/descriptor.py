"""The linearized equations of a large model as a sparse descriptor system (theory-system.md 5.7).

    dz/dt = A11 z + A12 w + B1 u        z = (ds, dqd), the state of (15)
        0 = A21 z + A22 w + B2 u        w = (dx, dxd, dxdd, dsigma), everything that follows
        y = C1 z + C2 w

Elimination of w gives A = A11 - A12 A22^-1 A21, B = B1 - A12 A22^-1 B2, C = C1 - C2 A22^-1 A21, D = -C2 A22^-1 B2: the
matrices of (15), full, while these have a number of entries proportional to the number of elements.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from spacar.arrays import EPS, Array
from spacar.errors import AnalysisError, UsageError
from spacar.linear_systems.linear_system import compressed

COLUMNS = 128  # right-hand sides at once
PROBES = 3  # of random signs: the chance that all three miss what rounding does
LARGEST_DENSE = 4.0  # GB of full matrices that are formed when somebody asks for them
TABLES = ("asp", "bsp", "csp")  # of A, B, C
MASSLESS = (
    "the linearized equations have no unique accelerations: a degree of freedom carries no mass (add XM or EM), or the"
    " degrees of freedom do not determine the motion (a dead point)"
)


@dataclass(frozen=True)
class DescriptorSystem:
    """A (n, n), B (n, inputs), C (outputs, n) sparse, n = n_states + number of w; the first n_states rows are rates."""

    A: Any
    B: Any
    C: Any
    n_states: int

    @classmethod
    def of_entries(cls, entries: dict[str, Array], n_states: int, n_inputs: int, n_outputs: int) -> DescriptorSystem:
        """From the TABLES (entries, 3): row, column (from 1) and value, as frames and files hold them. Raises
        ValueError."""
        n = int(entries["asp"][:, :2].max(initial=0.0))
        if n < n_states:
            raise ValueError(f"{n} rows for {n_states} states")
        tables = (entries[name].T if name in entries else np.zeros((3, 0)) for name in TABLES)
        shapes = (n, n), (n, n_inputs), (n_outputs, n)
        A, B, C = (
            compressed(i.astype(np.int64) - 1, j.astype(np.int64) - 1, value, shape)
            for (i, j, value), shape in zip(tables, shapes, strict=True)
        )
        return cls(A, B, C, n_states)

    def entries(self) -> dict[str, Array]:
        """The tables of `of_entries`."""
        matrices = zip(TABLES, (self.A.tocoo(), self.B.tocoo(), self.C.tocoo()), strict=True)
        return {name: np.column_stack((A.row + 1.0, A.col + 1.0, A.data)) for name, A in matrices}

    @cached_property
    def _following(self) -> Any:
        """Factors of A22. Raises AnalysisError when it is singular."""
        from spacar.linear_systems.sparse_factors import SparseFactors

        try:
            return SparseFactors(self.A[self.n_states :, self.n_states :])
        except RuntimeError:
            raise AnalysisError(MASSLESS, "dynamics.singular-mass") from None

    def follow(self, right: Array) -> Array:
        """w with A22 w = -right, right (w, k). Raises AnalysisError where the accelerations are not unique."""
        w = self._following.solve(-right)
        if not np.isfinite(w).all():
            raise AnalysisError(MASSLESS, "dynamics.singular-mass")
        return np.asarray(w)

    def state_space(self, steps: int = 1) -> tuple[Array, Array, Array, Array]:
        """A, B, C, D of (15), dense; `steps`: how many of them are asked for.

        Raises AnalysisError where the accelerations are not unique, UsageError when they would take more than 4 GB.
        """
        from scipy.sparse import hstack

        n, k = self.n_states, self.B.shape[1]
        size = 8e-9 * (n + k) * (n + self.C.shape[0]) * steps
        if size > LARGEST_DENSE:
            text = f"A, B, C, D of {n} states at {steps} steps would take {size:.1f} GB (more than {LARGEST_DENSE:g});"
            raise UsageError(f"{text} `bode`, `eigen` and `compliance` use the sparse form", "files.size")
        right = hstack((self.A[:, :n], self.B)).tocsc()
        out = np.zeros((n + self.C.shape[0], n + k))
        for first in range(0, n + k, COLUMNS):
            part = slice(first, min(first + COLUMNS, n + k))
            block = right[:, part].toarray()
            w = self.follow(block[n:])
            out[:n, part] = block[:n] + self.A[:n, n:] @ w
            out[n:, part] = self.C[:, n:] @ w
        out[n:, :n] += self.C[:, :n].toarray()
        return out[:n, :n], out[:n, n:], out[n:, :n], out[n:, n:]

    def effects(self, B: Any) -> tuple[Array, Array]:
        """Columns of the input matrix of (15) for these sparse columns B (n, k), and the rounding in them, both
        (n_states, k). The rounding is what errors of eps in every entry, with random signs, change in the solution.
        """
        n = self.n_states
        sizes, following = abs(self.A), self.A[:n, n:]
        right = B.toarray()
        w = self.follow(right[n:])
        uncertain = EPS * (sizes[n:, n:] @ np.abs(w) + np.abs(right[n:]))
        rounding = EPS * (sizes[:n, n:] @ np.abs(w) + np.abs(right[:n]))
        rng = np.random.default_rng(1)
        for _ in range(PROBES):
            signs = rng.choice((-1.0, 1.0), uncertain.shape)
            rounding = np.maximum(rounding, np.abs(following @ self.follow(signs * uncertain)))
        return right[:n] + following @ w, rounding

    def resolvent(self, s: complex) -> Callable[[Array], Array]:
        """b -> (s I - A)^-1 b with A of (15), both (n_states,): for `spacar.integrators.resolvent`. Raises RuntimeError
        where s is an eigenvalue."""
        from spacar.linear_systems.sparse_factors import SparseFactors

        factors = SparseFactors(self.shifted(s))

        def solve(b: Array) -> Array:
            right = np.zeros((self.A.shape[0], 1), np.result_type(b, s))
            right[: self.n_states, 0] = -b
            return np.asarray(factors.solve(right)[: self.n_states, 0])

        return solve

    def shifted(self, s: complex) -> Any:
        """A - s E in compressed columns, E being the identity of the state and zero elsewhere."""
        from scipy.sparse import dia_array

        ones = np.zeros((1, self.A.shape[0]))
        ones[0, : self.n_states] = 1.0
        return (self.A - s * dia_array((ones, [0]), self.A.shape)).tocsc()


def of_frame(state_space: dict[str, Array], header: Mapping[str, Any]) -> DescriptorSystem:
    """The system of a frame's TABLES, with the sizes NX, NU, NY of the run's header."""
    return DescriptorSystem.of_entries(state_space, *(int(header[k]) for k in ("NX", "NU", "NY")))


def dense_steps(systems: Iterable[DescriptorSystem], steps: int) -> dict[str, Array]:
    """A, B, C, D of every one of the `steps` systems, stacked. Raises as `DescriptorSystem.state_space`."""
    found = [system.state_space(steps) for system in systems]
    return {name: np.array([matrices[k] for matrices in found]) for k, name in enumerate("ABCD")}
