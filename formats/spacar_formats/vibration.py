"""Eigenvalues of every step of an `.sbm` result, with the names of the degrees of freedom (reference/files.md 2, 5).

Modes 7 and 10 store eigenvalues and eigenvectors; for modes 3, 4 and 9 they are computed here from the stored matrices,

    A = [Bk0 Ak0; -M0^-1 (K0 + N0 + G0)  -M0^-1 (C0 + D0)]    (mode 3 stores no Ak0, Bk0: [0 I] in the first rows)

or the lowest ones from the sparse equations of a large model (`.ltv`).
"""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spacar.arrays import EPS
from spacar.deck import ELEMENT_TYPES
from spacar.errors import Report, UsageError
from spacar.linear.eigen import Modes, modes_of_matrices
from spacar.linear.lowest import WANTED, lowest_modes
from spacar_formats.locate import notes, open_result
from spacar_formats.sbf import SbfFile
from spacar_formats.sbf.record_layout import require
from spacar_formats.sparse_system import descriptor_beside

GROWS = 1e-6  # of the largest modulus: real parts beyond it are a growing motion, values that differ less a pair


@dataclass(frozen=True)
class Vibration:
    """values (n,) eigenvalues [rad/s] by decreasing modulus, vectors (states, n) of norm 1, of the step at time t."""

    t: float
    values: np.ndarray
    vectors: np.ndarray

    @property
    def damping(self) -> np.ndarray:
        """-Re/|lambda|: 1 without oscillation, negative for a growing motion, 0 for eigenvalue zero."""
        size = np.abs(self.values)
        return np.where(size > 0.0, -self.values.real / np.where(size > 0.0, size, 1.0), 0.0) + 0.0  # no -0

    def dominant(self, names: list[str]) -> list[str]:
        """The degree of freedom with the largest component of every eigenvector."""
        rows = np.argmax(np.abs(self.vectors[: len(names)]), axis=0) if len(names) else []
        return [names[int(k)] for k in rows]


def shown_order(values: np.ndarray) -> list[int]:
    """Indices of eigenvalues as they are shown: growing ones first (the fastest as mode 1), then by rising modulus,
    zero modes last; of a pair the one with positive imaginary part, or the growing one.

    A modulus below sqrt(n eps) of the largest is a zero mode. The squares of eigenvalues are those of M^-1 K, whose
    backward error is n eps of the largest one; what is smaller cannot be told from zero.
    """
    largest = np.max(np.abs(values), initial=0.0)
    zero = np.sqrt(len(values) * EPS) * largest

    def key(i: int) -> tuple[float, ...]:
        v = values[i]
        if abs(v) <= zero:
            return (2, -abs(v), -v.imag)
        if v.real > GROWS * largest:
            return (0, -v.real, -v.imag)
        return (1, round(abs(v) / largest, 9), -v.imag)

    return sorted(range(len(values)), key=key)


def mode_numbers(values: np.ndarray, order: list[int]) -> list[int]:
    """Number of the mode of each eigenvalue in the order: conjugates have the same one."""
    numbers: list[int] = []
    for place, i in enumerate(order):
        last = values[order[place - 1]] if place else None
        near = last is not None and abs(values[i] - np.conj(last)) <= GROWS * abs(values[i]) and values[i].imag < 0.0
        numbers.append((numbers[-1] if numbers else 0) + (not near))
    return numbers


def without_rounding(values: np.ndarray) -> np.ndarray:
    """Eigenvalues (n,) whose parts below n eps times the largest modulus are zero: what an undamped mode has of them is
    the rounding of the eigenvalue problem (backward error n eps |A|), and would be all that a picture shows."""
    limit = len(values) * EPS * float(np.max(np.abs(values), initial=0.0))
    real, imaginary = (np.where(np.abs(part) <= limit, 0.0, part) for part in (values.real, values.imag))
    return real + 1j * imaginary


def read_vibrations(name: str | os.PathLike[str], lowest: int = WANTED) -> tuple[list[Vibration], list[str], list[str]]:
    """Eigenvalues of all steps, names of the configuration part of the state, warnings about the file. `lowest`: how
    many are computed of a large model that stores its equations sparse.

    Raises UsageError when the file is missing or holds neither eigenvalues nor matrices, AnalysisError for a singular
    mass matrix.
    """
    with open_result(name, "sbm") as file:
        stored = file.has("eigval")
        of_large = file.count("MODE") in (4, 9) and file.path.with_suffix(".ltv").is_file()
        sparse = not stored and not file.has("m0") and of_large
        if not stored and not file.has("m0") and not sparse:
            raise UsageError(f"{file.path} holds no eigenvalues and no matrices: run mode 7 or 10", "eigen.missing")
        report = Report()
        steps = []
        for k in range(1, file.steps + 1):
            if stored:
                parts = file.array("eigval", k)
                values = parts[:, 0] + 1j * parts[:, 1]
                vectors = file.array("eigvre", k) + 1j * file.array("eigvim", k)
            elif sparse:
                values, vectors, *_ = modes_of_sparse_system(file, k, report, lowest)
            else:
                values, vectors, *_ = modes_of_stored_matrices(file, k, report)
            steps.append(Vibration(file.time(k), values, vectors))
        if sparse:
            report.add(f"the {lowest} lowest modes of the sparse equations; --lowest N asks for N of them")
        told = [line.removeprefix("warning: ") for line in report.lines]
        return steps, names_beside(file.path), [*notes(file), *told]


def names_beside(path: Path) -> list[str]:
    """Dynamic degrees of freedom, then kinematic coordinates, from the `.sbd` beside; empty when there is none."""
    beside = path.with_suffix(".sbd")
    if not beside.is_file():
        return []
    with open_result(beside, "sbd", verify=False) as file:
        if any(not file.has(ident) for ident in ("NXP", "NEP", "LNP", "LE", "ETYPE")):
            return []
        nxp, nep = (file.array(k).ravel().astype(int) for k in ("nxp", "nep"))
        lnp, le, keywords = file.array("lnp"), file.array("le"), file.texts("etype")
        x_start, e_start = int(nxp[:2].sum()), int(nep[0])
        x = [_coordinate(lnp, i) for i in range(x_start + 1, x_start + nxp[2:].sum() + 1)]
        e = [_deformation(le, keywords, i) for i in range(e_start + 1, e_start + nep[2:].sum() + 1)]
        mode = file.count("MODE")
    if mode == 3:  # all degrees of freedom are prescribed and states
        return x + e
    x, e = x[nxp[2] :], e[nep[2] :]
    return x[: nxp[3]] + e[: nep[3]] + x[nxp[3] :] + e[nep[3] :]


def _coordinate(lnp: np.ndarray, i: int) -> str:
    found = np.argwhere(lnp == i)
    if not len(found):
        return f"coordinate {i}"
    node, k = (int(v) for v in found[0])
    count = int(np.count_nonzero(lnp[node]))
    name = "phi" if count == 1 else f"lambda{k}" if count == 4 else "xyz"[k]
    return f"node {node + 1} {name}"


def _deformation(le: np.ndarray, keywords: Sequence[str], i: int) -> str:
    found = np.argwhere(le == i)
    if not len(found):
        return f"deformation {i}"
    element, k = (int(v) for v in found[0])
    keyword = keywords[element]
    known = keyword in ELEMENT_TYPES and k < len(ELEMENT_TYPES[keyword].modes)
    what = f" {ELEMENT_TYPES[keyword].modes[k][0]}" if known else ""
    return f"element {element + 1} ({keyword}) e{k + 1}{what}"


def modes_of_stored_matrices(file: SbfFile, step: int, report: Report) -> Modes:
    """Modes of the matrices of a step. Raises SbfError when they hold numbers that are not finite."""
    M, C, D, K, N, G = (file.array(k, step) for k in ("m0", "c0", "d0", "k0", "n0", "g0"))
    finite = all(np.isfinite(part).all() for part in (M, C, D, K, N, G))
    require(finite, file.path, f"a matrix of step {step} holds numbers that are not finite")
    n, ns = K.shape
    kinematic = (file.array("ak0", step), file.array("bk0", step)) if file.has("ak0") else None
    ak0, bk0 = kinematic or (np.eye(ns, n), np.zeros((ns, ns)))
    return modes_of_matrices(M, C + D, K + N + G, ak0, bk0, report)


def modes_of_sparse_system(file: SbfFile, step: int, report: Report, wanted: int = WANTED, nx: int = 0) -> Modes:
    """Lowest modes of a large model of modes 4 and 9 from the `.ltv` beside; nx: the coordinates whose motions are
    wanted. Raises UsageError when there is no such file or it has no sparse system."""
    system, velocities = descriptor_beside(file.path, step), file.count("NDDOF")
    return lowest_modes(system, system.n_states - velocities, nx, report, min(wanted, velocities))
