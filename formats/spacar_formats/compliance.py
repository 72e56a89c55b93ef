"""The compliance matrix of a node of a stored result: `spacar.linear.node_compliance` with the matrices of the files.

The stiffness is that of the dynamic degrees of freedom (mode 3: of all).
"""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from spacar.calls import Source, run
from spacar.errors import AnalysisError, UsageError
from spacar.linear.node_compliance import compliance_of, planar_maps, spatial_maps
from spacar.modes import find_mode
from spacar.result import Result
from spacar_formats.locate import notes, open_result
from spacar_formats.sparse_system import descriptor_beside


@dataclass(frozen=True)
class NodeCompliance:
    """fixed (6, 6), planar (3, 3): displacement and rotation along the global axes by force and moment; body: the same
    along the axes of the orientation node."""

    t: float
    position: int
    orientation: int
    fixed: np.ndarray
    body: np.ndarray

    @property
    def labels(self) -> tuple[list[str], list[str]]:
        if len(self.fixed) == 3:
            return ["ux", "uy", "phi"], ["Fx", "Fy", "M"]
        return [f"{k}{a}" for k in ("u", "phi") for a in "xyz"], [f"{k}{a}" for k in "FM" for a in "xyz"]


def node_compliance(
    name: Source | Result, node: int, orientation: int | None = None, step: int = 1
) -> tuple[NodeCompliance, list[str]]:
    """Compliance of position node `node` and its orientation node at a stored step (from 1), and warnings.

    name   of the files of a result; or a Result, or what a Deck or a Model gives in mode 7. Without `orientation` it
           is the node that an element has together with `node`

    Raises UsageError for a wrong node, step or a result without dx (OUTLEVEL 0 1), AnalysisError when the stiffness is
    singular.
    """
    if not isinstance(name, str | os.PathLike):
        result = name if isinstance(name, Result) else run(7, name)
        with TemporaryDirectory() as folder:
            result.save(Path(folder) / "result")
            return node_compliance(Path(folder) / "result", node, orientation, step)
    with open_result(name, "sbd") as sbd, open_result(Path(sbd.path).with_suffix(".sbm"), "sbm") as sbm:
        lnp, ln = sbd.array("lnp").astype(int), sbd.array("ln").astype(int)
        nxp, nep = (sbd.array(k).ravel().astype(int) for k in ("nxp", "nep"))
        _require(lnp, node, "position", sbd.path)
        partner = _orientation(lnp, ln, node) if orientation is None else orientation
        _require(lnp, partner, "orientation", sbd.path)
        columns = np.r_[nxp[2] + np.arange(nxp[3]), nxp[2] + nxp[3] + nep[2] + np.arange(nep[3])]
        if find_mode(sbd.count("MODE")).takes_setpoints:  # the prescribed ones have the matrices
            columns = np.arange(nxp[2] + nep[2])
        planar = lnp[partner - 1, 3] == 0
        turning = lnp[partner - 1, : 1 if planar else 4] - 1
        rows = np.r_[lnp[node - 1, : 2 if planar else 3] - 1, turning]
        x = sbd.array("x", step).ravel()
        t = sbd.time(step)
        warnings = [*notes(sbd), *notes(sbm)]
        if sbm.has("ktan"):  # of a large model
            compliance = _sparse(sbm.array("ktan", step), nxp, rows)
        elif not sbm.has("k0"):
            compliance = _of_system(Path(sbm.path), step, nxp, rows)
        else:
            transfer = sbd.array("dx", step)
            K = sum(sbm.array(k, step) for k in ("k0", "n0", "g0"))
            if max(columns, default=-1) >= transfer.shape[1] or np.shape(K) != (len(columns), len(columns)):
                raise UsageError(f"{sbd.path} and {sbm.path} do not fit together", "compliance.size")
            if not (np.isfinite(K).all() and np.isfinite(transfer).all() and np.isfinite(x).all()):
                raise UsageError(f"{sbd.path} or {sbm.path} has numbers that are not finite", "compliance.finite")
            compliance = compliance_of(np.asarray(K), transfer[:, columns][rows])
    fixed, body = (planar_maps if planar else spatial_maps)(x[turning])
    return NodeCompliance(t, node, partner, fixed @ compliance @ fixed.T, body @ compliance @ body.T), warnings


def _require(lnp: np.ndarray, number: int, what: str, path: Path) -> None:
    if not 1 <= number <= len(lnp) or not lnp[number - 1, 0] or _kind(lnp, number) != what:
        raise UsageError(f"node {number} is no {what} node of {path}", "compliance.node")


def _kind(lnp: np.ndarray, node: int) -> str:
    row = lnp[node - 1]
    if row[1] and not row[3]:
        return "position"
    spatial = bool(lnp[:, 2].any())
    return "warping" if spatial and not row[1] else "orientation"  # both have one entry, and a planar model no warping


def _orientation(lnp: np.ndarray, ln: np.ndarray, node: int) -> int:
    """The orientation node at the same end of an element."""
    found = set()
    for row in ln:
        for k in np.flatnonzero(row == node):
            following = int(row[k + 1]) if k + 1 < len(row) else 0
            if following and _kind(lnp, following) == "orientation":
                found.add(following)
    if len(found) == 1:
        return found.pop()
    reason = f"one of {', '.join(map(str, sorted(found)))}" if found else "no element has one at this node"
    raise UsageError(f"node {node}: name its orientation node ({reason})", "compliance.node")


def _of_system(path: Path, step: int, nxp: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """dx/df at rest of the degrees of freedom (dqd = dqdd = 0), from the sparse equations in the `.ltv` file beside:
    (K0 + N0 + G0)^-1 between its transfer functions."""
    system = descriptor_beside(path, step)
    n, nx = system.n_states, int(nxp.sum())
    given = (rows < nxp[0]) | ((rows >= nxp[:2].sum()) & (rows < nxp[:3].sum()))
    unit = np.zeros((system.A.shape[0], len(rows)))
    unit[n + rows, np.arange(len(rows))] = np.where(given, 0.0, -1.0)
    return _solved(system.A, unit, n + nx + rows)


def _sparse(entries: np.ndarray, nxp: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """dx/df of these coordinates from the tangent in mixed form (`ktan`, reference/files.md section 5)."""
    from scipy.sparse import coo_array

    first, second = nxp[0] + np.arange(nxp[1]), nxp[:3].sum() + np.arange(nxp[3])
    place = np.full(nxp.sum(), -1)
    place[np.r_[first, second]] = np.arange(nxp[1] + nxp[3])
    row, column = (entries[:, k].astype(np.int64) - 1 for k in (0, 1))
    A = coo_array((entries[:, 2], (row, column))).tocsc()
    moving = np.flatnonzero(place[rows] >= 0)
    out = np.zeros((len(rows), len(rows)))
    unit = np.zeros((A.shape[0], len(moving)))
    unit[place[rows[moving]], np.arange(len(moving))] = 1.0
    out[np.ix_(moving, moving)] = _solved(A, unit, place[rows[moving]])
    return out


def _solved(A: Any, unit: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """These rows of A^-1 unit. Raises AnalysisError for a singular stiffness."""
    from spacar.linear_systems.sparse_factors import SparseFactors

    with suppress(RuntimeError):
        found = np.asarray(SparseFactors(A).solve(unit)[rows])
        if np.isfinite(found).all():
            return found
    text = "the stiffness is singular (critical load or rigid motion): there is no compliance"
    raise AnalysisError(text, "compliance.singular")
