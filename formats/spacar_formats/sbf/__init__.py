"""SBF, the container of the result files `.sbd`, `.sbm` and `.ltv` (reference/files.md section 8)."""

from spacar_formats.sbf.record_layout import MATLAB_NAMES, Record, SbfError, matlab_name
from spacar_formats.sbf.sbf_reader import SbfFile
from spacar_formats.sbf.sbf_writer import SbfWriter

__all__ = ["MATLAB_NAMES", "Record", "SbfError", "SbfFile", "SbfWriter", "matlab_name"]
