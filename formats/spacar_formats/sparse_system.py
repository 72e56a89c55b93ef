"""The sparse linearized equations of a large model in an `.ltv` file (asp, bsp, csp; reference/files.md section 6)."""

from pathlib import Path

import numpy as np

from spacar.errors import UsageError
from spacar.linearization.descriptor import TABLES, DescriptorSystem
from spacar_formats.locate import open_result
from spacar_formats.sbf import SbfError, SbfFile


def is_sparse(file: SbfFile) -> bool:
    """Does an `.ltv` file hold the sparse form instead of A, B, C, D?"""
    return file.has("ASP") and not file.has("A")


def descriptor_of(file: SbfFile, step: int) -> DescriptorSystem:
    """The system of a step (from 1). Raises SbfError for places or numbers that cannot be."""
    tables = {name: file.array(name.upper(), step) for name in TABLES if file.has(name.upper())}
    try:
        if not all(np.isfinite(table).all() for table in tables.values()):
            raise ValueError("numbers that are not finite")
        return DescriptorSystem.of_entries(tables, *map(file.count, ("NX", "NU", "NY")))
    except (ValueError, KeyError) as error:
        raise SbfError(f"{file.path} is damaged: the sparse system of step {step} has {error}") from None


def descriptor_beside(path: Path, step: int) -> DescriptorSystem:
    """The system of a step (from 1) in the `.ltv` file beside a file of the same run.

    Raises UsageError when there is no such file or it has no sparse system.
    """
    found = path.with_suffix(".ltv")
    if not found.is_file():
        text = f"{found} not found: of a large model modes 4 and 9 store the linearized equations in it; run again"
        raise UsageError(text, "files.not-found")
    with open_result(found, "ltv", verify=False) as file:
        if not is_sparse(file):
            raise UsageError(f"{path} and {file.path} are of different runs; run again", "files.stale")
        return descriptor_of(file, step)
