"""Straight chain of planar beams or tubes, assembled densely: the smallest mechanism with printed digits.

Coordinates (x, y, phi) of node k are 3k, 3k+1, 3k+2. Elongations can be rigid (multipliers) or elastic.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg

from spacar.elements.family import Family
from tests.elements.derivatives import evaluate, group, written


class Chain:
    def __init__(self, kind: Any, keyword: str, nodes: Any, **values: Any) -> None:
        nodes = np.asarray(nodes, float)
        self.n = n = len(nodes) - 1
        self.index = 3 * np.arange(n) + np.arange(6)[:, None]  # (6, n)
        self.x0 = np.zeros(3 * n + 3)
        self.x0[0::3] = nodes
        # one row of values serves all elements
        rows = {key: np.resize(np.atleast_2d(v), (n, np.shape(v)[-1])) for key, v in values.items()}
        self.family: Family = kind(group(keyword, self.x0[self.index], **rows))

    def vector(self, local: Any) -> Any:
        return np.bincount(self.index.ravel(), local.ravel(), len(self.x0))

    def matrix(self, local: Any) -> Any:
        """(6, 6, n) element matrices into one."""
        out = np.zeros((len(self.x0), len(self.x0)))
        np.add.at(out, (self.index[:, None], self.index[None]), local)
        return out

    def state(self, x: Any) -> tuple[Any, Any, Any]:
        return evaluate(self.family, x[self.index])

    def mass(self, x: Any) -> Any:
        return self.matrix(written(self.family.mass, (6, 6, self.n), float, self.state(x)[0]))

    def rigid_rows(self, x: Any) -> Any:
        """Gradients of the elongations, (n, coordinates)."""
        out = np.zeros((self.n, len(self.x0)))
        out[np.arange(self.n), self.index] = self.state(x)[2][0]
        return out

    def stiffness(self, x: Any, normal_force: Any) -> Any:
        """Tangent stiffness of the bending modes plus the geometric stiffness with the given sigma_1 (n,)."""
        c, e, V = self.state(x)
        S = self.family.stiffness()[0].copy()
        S[0] = 0.0
        sigma = np.einsum("abn,bn->an", S, e)
        sigma[0] = normal_force
        geometric = written(self.family.geometric_stiffness, (6, 6, self.n), float, c, sigma)
        return self.matrix(np.einsum("ain,abn,bjn->ijn", V, S, V) + geometric)

    def equilibrium(self, load: Any, free: Any, steps: int = 60) -> tuple[Any, Any]:
        """x and normal forces under the nodal forces `load`, with rigid elongations; Newton to round-off."""
        x, N = self.x0.copy(), np.zeros(self.n)
        for step in range(1, steps + 1):
            for _ in range(30):
                _, e, V = self.state(x)
                S = self.family.stiffness()[0]
                sigma = np.einsum("abn,bn->an", S, e)
                sigma[0] = N
                force = self.vector(np.einsum("ain,an->in", V, sigma)) - load * step / steps
                residual = np.concatenate((force[free], e[0]))
                rows = self.rigid_rows(x)[:, free]
                K = self.stiffness(x, N)[np.ix_(free, free)]
                kkt = np.block([[K, rows.T], [rows, np.zeros((self.n, self.n))]])
                change = np.linalg.solve(kkt, -residual)
                x[free] += change[: len(free)]
                N = N + change[len(free) :]
                if np.max(np.abs(change[: len(free)])) < 1e-12 * np.ptp(self.x0):
                    break
            else:
                raise AssertionError("Newton did not converge")
        return x, N

    def reduce(self, x: Any, free: Any, *matrices: Any) -> list[Any]:
        """Basis of the motions with rigid elongations, then the matrices on it."""
        basis = np.zeros((len(self.x0), len(free) - self.n))
        basis[free] = scipy.linalg.null_space(self.rigid_rows(x)[:, free])
        return [basis, *(basis.T @ A @ basis for A in matrices)]
