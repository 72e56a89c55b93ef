"""Independent definitions for the tests of the spatial elements: element by element, rotation matrices."""

from typing import Any

import numpy as np

G = np.array([0.3, -0.7, 9.81])


def rotation(lam: Any) -> Any:
    """R = Lambda-bar Lambda^T (3, 3), rows written out as in theory-spatial.md section 1."""
    l0, l1, l2, l3 = lam
    bar = np.array([[-l1, l0, -l3, l2], [-l2, l3, l0, -l1], [-l3, -l2, l1, l0]])
    body = np.array([[-l1, l0, l3, -l2], [-l2, -l3, l0, l1], [-l3, l2, -l1, l0]])
    return bar @ body.T


def turn(axis: Any, angle: float) -> Any:
    """Euler parameters of a rotation."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    return np.concatenate(([np.cos(angle / 2)], np.sin(angle / 2) * axis))


def reference(rng: Any, n: int, layout: str) -> Any:
    """Random positions ('x') and unit orientations ('l') of n elements at the start, (n_coordinates, n)."""
    parts = [rng.normal(size=(3, n)) if kind == "x" else np.eye(4)[:, :1].repeat(n, 1) for kind in layout]
    return np.concatenate(parts)


def moved(rng: Any, x0: Any, layout: str, angle: float = 0.5, shift: float = 0.3) -> Any:
    """x0 displaced and turned at random, |lambda| = 1."""
    x, row = x0.copy(), 0
    for kind in layout:
        if kind == "x":
            x[row : row + 3] += shift * rng.normal(size=(3, x.shape[1]))
            row += 3
        else:
            for k in range(x.shape[1]):
                x[row : row + 4, k] = turn(rng.normal(size=3), angle * rng.uniform(0.3, 1.0))
            row += 4
    return x


def rates(rng: Any, x: Any, layout: str) -> Any:
    """Random rates that respect the normalization."""
    v, row = rng.normal(size=x.shape), 0
    for kind in layout:
        size = 3 if kind == "x" else 4
        if kind == "l":
            lam = x[row : row + 4]
            v[row : row + 4] -= (v[row : row + 4] * lam).sum(0) * lam
        row += size
    return v


def chord_frame(d: Any, g: Any) -> Any:
    """Columns x', y', z' of a beam."""
    ex = d / np.linalg.norm(d)
    ez = np.cross(ex, g)
    ez /= np.linalg.norm(ez)
    return np.column_stack((ex, np.cross(ez, ex), ez))
