"""The form in which modes are stored and computed: decided here, for modes 3, 4, 7 to 10 and `flexure`.

Stored are reduced matrices and transfer functions up to LARGE degrees of freedom, of larger models the sparse form,
unless OUTLEVEL, MODES 0 or a large part of the modes is asked for: what a result contains does not depend on work.

Computed, where few modes are asked for, by the smaller count of operations, with n degrees of freedom, m modes:

    dense    DENSE n^3, most of it for the singular values of the factors of K and M (spacar.linear.graded)
    sparse   (SOLUTIONS + 5 m) (CALL + 8 entries of the factors) + SETUP of every condensed matrix

The constants were measured (docs/performance.md, "Sizes") in units of a nanosecond; both take the same time at 110 to
200 degrees of freedom, so that no jump is left.
"""

from __future__ import annotations

from collections.abc import Callable

from spacar.mechanism.mechanism import SolverSettings
from spacar.stationary.tangent import SparseTangent

LARGE = 200  # degrees of freedom above which no dense matrices are stored
SHARE = 4  # all modes together cost less than the lowest ones if these are more than one in four
DENSE, SOLUTIONS, CALL, SETUP = 10.0, 80.0, 1e5, 4e7
FILL = 3.0  # entries of the factors of a condensed matrix over those of the mixed one


def stores_sparse(n: int, settings: SolverSettings, wanted: int) -> bool:
    """Is the sparse form of n degrees of freedom stored, with the `wanted` modes?"""
    return n > LARGE and settings.sbd_level is None and settings.modes != 0 and wanted * SHARE <= n


def computes_sparse(n: int, wanted: int, tangent: Callable[[], SparseTangent]) -> bool:
    """Do the `wanted` lowest modes of n degrees of freedom take less work with the sparse tangent?"""
    solutions = SOLUTIONS + 5.0 * wanted
    dense = DENSE * float(n) ** 3
    if wanted * SHARE > n or dense < solutions * CALL:
        return False
    entries, condensed = tangent().factor_entries(FILL)
    return dense > solutions * (CALL + 8.0 * entries) + SETUP * condensed
