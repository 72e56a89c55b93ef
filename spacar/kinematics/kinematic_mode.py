"""Mode 0: classification, condition and the diagnosis of over- and under-constraints in the start configuration."""

from collections.abc import Iterator, Sequence

import numpy as np

from spacar.frame import Frame
from spacar.kinematics.constraint_condition import condition_number
from spacar.kinematics.constraint_matrices import ZERO
from spacar.kinematics.diagnosis import Diagnosis, diagnose
from spacar.kinematics.element_sweep import ElementSweep
from spacar.kinematics.kinematics import Kinematics
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.mechanism import Mechanism
from spacar.stream import Run

DECOMPOSED = 400  # unknowns up to which all singular values are computed
LARGEST_DENSE = 1_000_000  # numbers of bigd (8 MB); more are stored sparse


def check(run: Run) -> Iterator[Sequence[Frame]]:
    """One frame with `bigd`; the diagnosis goes to the report and, as a record, to header['diagnosis']."""
    mechanism = run.mechanism
    n = mechanism.numbering
    sweep = ElementSweep.at(mechanism)
    diagnosis = _large_and_regular(mechanism) or diagnose(mechanism)
    run.n_frames = 1
    run.header["condition"] = diagnosis.condition
    run.header["diagnosis"] = diagnosis
    for line in diagnosis.lines():
        run.report.add(line)
    V, entries = None, None
    if n.ne * n.nx <= LARGEST_DENSE:
        V = sweep.gradient()
    else:
        entries = np.column_stack((sweep.v_rows + 1.0, sweep.v_columns + 1.0, sweep.v_entries))
        run.report.add(
            f"the derivative of the deformations is stored as {len(entries)} rows (row, column, value) `bigds` instead"
            f" of the matrix `bigd` of {n.ne} x {n.nx}"
        )
    zero_x, zero_e = np.zeros(n.nx), np.zeros(n.ne)
    frame = Frame(
        t=0.0, x=mechanism.x0.copy(), xd=zero_x, xdd=zero_x, e=sweep.e.copy(), ed=zero_e, edd=zero_e,
        sig=zero_e, fx=zero_x, fxgrav=zero_x, fxtot=zero_x, bigd=V, bigds=entries,
    )  # fmt: skip
    yield (frame,)


def _large_and_regular(mechanism: Mechanism) -> Diagnosis | None:
    """The diagnosis without singular value decomposition (cubic cost), if the estimated condition says regular."""
    n = mechanism.numbering
    rows = len(n.velocity_equations)
    if rows <= DECOMPOSED or not (n.is_square and n.holonomic):
        return None
    kinematics = Kinematics(mechanism)
    try:
        kinematics.refresh()
    except SingularMatrixError:
        return None
    condition = condition_number(kinematics)
    if not condition < 1.0 / ZERO:
        return None
    return Diagnosis(rows, rows, 0, 0, (), (), (), (), np.zeros(0), condition)
