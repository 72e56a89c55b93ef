"""What is compared, and how exactly: 64 eps times the condition times the scale of each kind of quantity.

The scale of a force is the largest of its kind, or the stiffness times the size of the mechanism; the condition is that
of the positions times that of the reduced mass (or stiffness) matrix, each measured by its own numbers.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

import spacar
from spacar.frame import E_FIELDS

from .model import Model
from .transformations import Back

EPS = float(np.finfo(float).eps)
KINDS = {"x": "x", "xd": "xd", "xdd": "xdd", "fxtot": "force", "e": "x", "ed": "xd", "edd": "xdd", "sig": "force"}


def quantities(model: Model, result: spacar.Result, back: Back | None = None) -> dict[tuple[str, int, str], np.ndarray]:
    """(node or element, its number in the first model, variable) -> (steps, coordinates or modes), as the first model
    has them. `model` is the first one."""
    back = back or Back()
    found = {}
    if not all(np.isfinite(np.asarray(result[variable])).all() for variable in KINDS):
        raise AssertionError("a result is not finite")
    for variable in KINDS:
        for kind, names in (("element", model.types), ("node", model.roles)):
            if (variable in E_FIELDS) != (kind == "element"):
                continue
            for n, what in names.items():
                if kind == "node":
                    raw = result.node(back.nodes.get(n, n), variable=variable)
                    found[kind, n, variable] = back.node(what, raw, variable == "x")
                else:
                    raw = result.element(back.elements.get(n, n), variable=variable)
                    found[kind, n, variable] = back.element(what, raw)
    return found


def scales(found: Iterable[dict], stiffness: float) -> dict[str, float]:
    """Largest value of each kind; of forces the stiffness at least."""
    sizes = {"x": 1.0, "xd": 1.0, "xdd": max(1.0, stiffness), "force": max(1.0, stiffness)}
    for values in found:
        for (_, _, variable), v in values.items():
            kind = KINDS[variable]
            sizes[kind] = max(sizes[kind], float(np.nanmax(np.abs(v), initial=0.0)))
    sizes["xd"] = max(sizes["xd"], 0.2 * sizes["xdd"])  # rates collect what accelerations are off by, for 0.2 s
    return sizes


def stiffness_of(model: Model) -> float:
    """Largest coefficient of the model (lengths are of order one)."""
    values = [abs(float(v)) for r in model.rows("ESTIFF", "ESIG") for v in r[2:]] + [abs(p.k) for p in model.pushes]
    values += [r[2] * v for r in model.rows("MATERIAL") for s in model.rows("SECTION") for v in s[3:]]
    return max(values, default=0.0)


def disagreement(a: dict, b: dict, condition: float, stiffness: float, error: float = 0.0) -> tuple[float, str]:
    """Largest difference over what is allowed, and where. `error` replaces 64 eps where an ERROR was asked."""
    sizes = scales((a, b), stiffness)
    worst, where = 0.0, ""
    for key, want in a.items():
        limit = max(64 * EPS * condition, error) * sizes[KINDS[key[2]]]
        got = b[key]
        if want.shape != got.shape:
            return np.inf, f"{key}: {got.shape} in place of {want.shape}"
        off = float(np.nanmax(np.abs(got - want), initial=0.0)) if limit else 0.0
        if limit and off / limit > worst:
            worst, where = off / limit, f"{' '.join(map(str, key))}: {off:.3g}, allowed {limit:.3g}"
    return worst, where
