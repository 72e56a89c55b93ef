"""The form in which modes are stored and computed: decided here, for modes 3, 4, 7 to 10 and `flexure`.

Reduced matrices and transfer functions up to LARGE degrees of freedom, of larger models the sparse form, unless
OUTLEVEL, MODES 0 or a large part of the modes is asked for. Work of order n^3 and work of order n are equal at 190 to
220 degrees of freedom (chains, plane and space frames; modes 7, 8, 10 and `flexure`; benchmarks/NOTES.md): no jump.
"""

from spacar.mechanism.mechanism import SolverSettings

LARGE = 200  # degrees of freedom above which no dense matrices are stored
SHARE = 4  # all modes together cost less than the lowest ones if these are more than one in four


def stores_sparse(n: int, settings: SolverSettings, wanted: int) -> bool:
    """Is the sparse form of n degrees of freedom stored, with the `wanted` modes?"""
    return n > LARGE and settings.sbd_level is None and settings.modes != 0 and wanted * SHARE <= n
