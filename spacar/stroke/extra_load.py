"""The margin of one extra load alone: how much of it a state bears besides all that it carries (docs/flexures.md 3).

    (K + lambda dG) x = 0

K   stiffness at the state with all present loads, K0 + N0 + G0
dG  what a unit of the extra load adds to the geometric stiffness: Hs(d_sigma) and the gradient of its own moments. The
    stresses d_sigma are the linear answer of the state to the load, with the drive as it stands (held where it is
    prescribed), in the present configuration:  K dq = W^T df,  d_sigma = S V dx and the reactions of constraints

lambda is counted in the load that was given; the proportional multiplier (theory-system.md 6.5) multiplies all loads
and prestresses instead. For a column under a load P the extra load of the same place has lambda = P_cr - P.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.loaded_mechanism import moment_entries
from spacar.mechanism.numbering import Numbering
from spacar.stroke.driven_deck import Row


@dataclass(frozen=True)
class ExtraLoad:
    """force (nx,) [N, planar N m];  moments (n, 3) [N m] about global axes at the Euler parameters rows (4, n)."""

    force: Array
    rows: Index
    moments: Array

    @classmethod
    def of(cls, loads: Sequence[Row], n: Numbering) -> ExtraLoad:
        """The sum of all XF statements, rows of the dynamics block."""
        force, rows, moments = np.zeros(n.nx), [np.zeros((4, 0), np.int64)], [np.zeros((0, 3))]
        for _, node, *values in loads:
            places = n.lnp[int(node) - 1] - 1
            if not n.planar and n.kind[int(node)] == "orientation":
                rows.append(places[:4, None])
                moments.append(np.array([values], float))
            else:
                force[places[: len(values)]] += np.array(values, float)
        return cls(force, np.concatenate(rows, axis=1), np.concatenate(moments))

    def at(self, x: Array) -> Array:
        """df (nx,) at coordinates x (nx,)."""
        rows, columns, values = self.gradient_entries()
        return self.force + np.bincount(rows, values * x[columns], len(self.force))

    def gradient_entries(self) -> tuple[Index, Index, Array]:
        """d(df)/dx as rows, columns, values (16 n,)."""
        return moment_entries(self.rows, self.moments)
