"""Log section 5 for linearized systems: eigenvalues, load multipliers, compliances, matrices
(reference/files.md 2, 5)."""

from math import pi

import numpy as np

from spacar.frame import Frame
from spacar.mechanism.numbering import Numbering
from spacar_formats.log.model_sections import coordinates
from spacar_formats.log.text_layout import COLUMNS_IN_BLOCK, ShownUnits, matrix, real, table

MATRICES = {
    "m0": "reduced mass matrix M0", "c0": "velocity sensitivity matrix C0", "d0": "damping matrix D0",
    "k0": "structural stiffness matrix K0", "n0": "dynamic stiffening matrix N0", "g0": "geometric stiffness matrix G0",
    "b0": "input matrix B0", "ak0": "kinematic matrix AK0", "bk0": "kinematic matrix BK0",
}  # fmt: skip
KINEMATIC = ("ak0", "bk0")
STATE_SPACE = ("A", "B", "C", "D")
LARGEST = 40  # larger matrices are in the result file only


def eigenvalues(n: Numbering, frame: Frame) -> list[str]:
    """Eigenvalues by decreasing modulus, frequencies, damping ratios, and the normalized eigenvectors."""
    m = frame.matrices
    if "eigval" not in m:
        return []
    values = np.asarray(m["eigval"]).reshape(-1, 2)
    if not len(values):
        return ["No eigenvalues: the system has no dynamic degrees of freedom", ""]
    modulus = np.hypot(*values.T)
    order = np.argsort(-modulus, kind="stable")
    rows = []
    for k, i in enumerate(order, 1):
        re, im = values[i].tolist()
        size = float(modulus[i])
        rows.append([k, re, im, size, size / (2 * pi), f"{-re / size:.9f}" if size else "-"])
    heads = [
        "number", "real part [1/s]", "imaginary part [rad/s]", "modulus [rad/s]", "frequency [Hz]", "damping ratio",
    ]  # fmt: skip
    lines = ["Eigenvalues of the state matrix", "", *table(heads, rows), ""]
    if "eigvre" not in m:
        return lines
    vectors = (m["eigvre"] + 1j * m["eigvim"])[:, order]
    names = n.state_names
    label = names if len(names) == len(vectors) else []
    lines += ["Eigenvectors of the state (degrees of freedom and their rates), Euclidean norm 1", ""]
    for first in range(0, vectors.shape[1], COLUMNS_IN_BLOCK // 2):
        block = range(first, min(first + COLUMNS_IN_BLOCK // 2, vectors.shape[1]))
        parts = [part for i in block for part in (vectors[:, i].real, vectors[:, i].imag)]
        heads = [f"{kind} {i + 1}" for i in block for kind in ("real", "imaginary")]
        lines += matrix(np.array(parts).T, label, heads)
    return lines


def buckling(n: Numbering, frame: Frame) -> list[str]:
    """Load multipliers in their order (increasing modulus) and the normalized buckling modes."""
    m = frame.matrices
    if "lmult" not in m:
        return []
    values = np.ravel(m["lmult"])
    if np.all(np.isnan(values)) and len(values):
        return ["Load multipliers: none, see the warnings at the end", ""]
    rows = [[k, real(float(v)) if np.isfinite(v) else "infinite"] for k, v in enumerate(values, 1)]
    lines = ["Load multipliers (negative: the load reversed)", "", *table(["number", "load multiplier"], rows), ""]
    modes = m.get("bmode")
    if modes is None or not np.size(modes):
        return lines
    modes = np.asarray(modes).reshape(-1, len(values))
    known = np.flatnonzero(~np.isnan(modes).any(axis=0))
    if not len(known):
        return lines
    heads = [f"mode {k + 1}" for k in known]
    return [*lines, "Buckling modes, Euclidean norm 1", "", *matrix(modes[:, known], n.dynamic_names, heads)]


def compliances(n: Numbering, frame: Frame, metre: float) -> list[str]:
    """Directional nodal compliance of every coordinate, in the unit of length of the input."""
    if frame.xcompl is None:
        return []
    names, _ = coordinates(n)
    values = (ShownUnits.of(n, metre).compliances * frame.xcompl).tolist()
    rows = [[node, name, value] for (node, name), value in zip(names, values, strict=True)]
    title = "Directional nodal compliances: displacement of a coordinate by a unit force dual to it"
    return [title, "", *table(["node", "coordinate", "compliance"], rows), ""]


def matrices(n: Numbering, frame: Frame) -> list[str]:
    """The coefficient matrices and the state space matrices of a stationary state."""
    lines = []
    trivial = KINEMATIC if n.holonomic else ()  # identity and zero
    known = [
        (title, frame.matrices[name], n.dynamic_names)
        for name, title in MATRICES.items()
        if name in frame.matrices and name not in trivial
    ]
    known += [(f"state space matrix {k}", frame.state_space[k], []) for k in STATE_SPACE if k in frame.state_space]
    for title, value, names in known:
        if not np.size(value):
            continue
        lines.append(f"The {title}")
        if max(value.shape) > LARGEST:
            lines += [f"  {value.shape[0]} x {value.shape[1]}: see the result file", ""]
        else:
            lines += ["", *matrix(value, names if len(names) == len(value) else [])]
    return lines
