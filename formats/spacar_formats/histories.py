"""Time histories as `.npz`, `.mat` or `.csv` files: what `spacar sim`, `ltv` and `mrltv` write."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from spacar.errors import UsageError
from spacar_formats.exports import to_csv, to_mat, to_npz


def export_signals(arrays: Mapping[str, np.ndarray], target: Path) -> None:
    """Arrays (steps,) or (steps, n) by name; in a `.csv` every column has the name and its number.

    Raises UsageError for another extension or a file that cannot be written.
    """
    suffix = target.suffix.lower()
    if suffix in (".npz", ".mat"):
        (to_npz if suffix == ".npz" else to_mat)({_name(k): np.asarray(v) for k, v in arrays.items()}, target)
    elif suffix == ".csv":
        table = {}
        for name, value in arrays.items():
            columns = np.asarray(value)
            if columns.ndim == 1:
                table[name] = columns
            else:
                table |= {f"{name}_{k + 1}": column for k, column in enumerate(columns.T)}
        to_csv(table, target)
    else:
        raise UsageError(f"cannot export to {target}: the extension must be .npz, .mat or .csv", "files.export")


def _name(text: str) -> str:
    """A name that MATLAB and Python accept for a variable."""
    clean = "".join(c if c.isalnum() or c == "_" else "_" for c in text)
    return clean if clean[:1].isalpha() else f"b_{clean}"
