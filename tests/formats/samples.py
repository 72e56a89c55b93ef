"""Small result files for the tests of this folder, and the 512-byte vector of reference/files.md 8."""

from pathlib import Path

import numpy as np
from spacar_formats.sbf import SbfWriter

VECTOR = bytes.fromhex(
    """
89534246 0d0a1a0a 01000000 01010000 40000000 00000000 00010000 00000000
c0010000 00000000 20000000 00000000 02000000 00000000 db3d4c61 2a0e679f
4e580000 00000000 00000000 00000000 01000000 00000000 01000000 00000000
01000000 00000000 70000000 00000000 02000000 00000000 4c4e5000 00000000
00000000 00000000 01000000 00000000 02000000 00000000 02000000 00000000
a8000000 00000000 01000000 00000000 00000000 00000000 02000000 00000000
00000000 00000000 5449544c 45000000 00000000 00000000 03000000 00000000
01000000 00000000 05000000 00000000 f8000000 00000000 64656d6f 20000000
54444546 00000000 00000000 00000000 01000000 01000000 02000000 00000000
02000000 00000000 00000000 00000000 54000000 00000000 00000000 00000000
02000000 02000000 01000000 00000000 01000000 00000000 00000000 00000000
58000000 00000000 00000000 00000000 02000000 02000000 02000000 00000000
01000000 00000000 08000000 00000000 54444154 00000000 00000000 00000000
01000000 03000000 00000000 00000000 00000000 00000000 20000000 00000000
00000000 00000000 00000000 0000f03f 00000000 000004c0 01000000 fcde5d03
00000000 0000e03f 00000000 0000f43f 00000000 000000c0 02000000 cef4d00e
"""
)

LNP = np.array([[1, 2, 0, 0], [3, 0, 0, 0]])
M = np.array([[1.0, 2.0], [3.0, 4.0]])


def vector_file(path: Path) -> Path:
    """The example of the format description, written by our writer."""
    header = {"NX": 2, "LNP": np.array([[1, 2], [0, 0]]), "TITLE": "demo "}
    with SbfWriter(path, "sbd", header, {"T": (1, 1), "X": (2, 1)}) as out:
        out.append({"T": 0.0, "X": [1.0, -2.5]})
        out.append({"T": 0.5, "X": [1.25, -2.0]})
    return path


def sbd(path: Path, steps: int = 3, **header: object) -> Path:
    """A result of 2 nodes: t, x (3), fxt (3), dx (3 x 2, all different) at `steps` steps."""
    fixed = {"MODE": 1, "NX": 3, "LNP": LNP, "STIF": np.array([[1.5, 0.0]]), "ETYPE": ["PLBEAM", "PLTRUSS"]}
    variables = {"T": (1, 1), "X": (3, 1), "FXT": (3, 1), "DX": (3, 2)}
    with SbfWriter(path, "sbd", fixed | header, variables) as out:
        for k in range(steps):
            dx = 10 * k + np.arange(6.0).reshape(3, 2)
            out.append({"T": 0.1 * k, "X": np.arange(3.0) + k, "FXT": np.ones(3) * k, "DX": dx})
    return path


def sbm(path: Path, steps: int = 1) -> Path:
    with SbfWriter(path, "sbm", {"NDDOF": 2}, {"T": (1, 1), "M0": (2, 2), "LMULT": (2, 1)}) as out:
        for k in range(steps):
            out.append({"T": float(k), "M0": M + k, "LMULT": [np.inf, -2.0]})
    return path


def ltv(path: Path, feedthrough: int = 1, **header: object) -> Path:
    sizes = {"T": (1, 1), "A": (2, 2), "B": (2, 1), "C": (1, 2)} | ({"D": (1, 1)} if feedthrough else {})
    with SbfWriter(path, "ltv", {"DFT": feedthrough} | header, sizes) as out:
        for k in range(2):
            values = {"T": 0.5 * k, "A": [[0, 1], [-4 - k, -0.1]], "B": [[0], [1]], "C": [[1, 0]], "D": [[3.0]]}
            out.append({ident: values[ident] for ident in sizes})
    return path
