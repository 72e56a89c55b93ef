"""loadsbd, loadsbm: all variables of a result file as named arrays (reference/files.md 4, 5 and 7)."""

import os
from collections.abc import Sequence

import numpy as np

from spacar_formats.locate import open_result
from spacar_formats.sbf import SbfFile, matlab_name


def loadsbd(name: str | os.PathLike[str], ids: Sequence[str] | None = None) -> dict[str, np.ndarray]:
    """The variables (all, or only `ids`) of the `.sbd` file `name` under their MATLAB names.

    Shapes as getfrsbf gives them: (rows, cols) for header variables and for a file of one step, else
    (steps, rows*cols), a step column after column; text is a 1-D array of strings. Raises as `getfrsbf`.
    """
    with open_result(name, "sbd") as file:
        return named_arrays(file, ids)


def loadsbm(name: str | os.PathLike[str], ids: Sequence[str] | None = None) -> dict[str, np.ndarray]:
    """As `loadsbd`, for the `.sbm` file: m0, c0, k0 ... of the linearized equations."""
    with open_result(name, "sbm") as file:
        return named_arrays(file, ids)


def named_arrays(file: SbfFile, ids: Sequence[str] | None) -> dict[str, np.ndarray]:
    """The variables of an open file of any kind under their MATLAB names."""
    wanted = file.ids if ids is None else [file.variable(ident).id for ident in ids]
    return {matlab_name(ident, file.kind): np.asarray(file.get(ident)) for ident in wanted}
