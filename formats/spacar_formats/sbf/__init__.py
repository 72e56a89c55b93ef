"""SBF, the container of the result files `.sbd`, `.sbm` and `.ltv` (reference/files.md section 8)."""

from spacar_formats.sbf.layout import Record, SbfError
from spacar_formats.sbf.names import MATLAB_NAMES, matlab_name
from spacar_formats.sbf.reader import SbfFile
from spacar_formats.sbf.writer import SbfWriter

__all__ = ["MATLAB_NAMES", "Record", "SbfError", "SbfFile", "SbfWriter", "matlab_name"]
