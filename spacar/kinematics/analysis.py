"""Mode 0: classification, condition and the diagnosis of over- and under-constraints in the start configuration."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from spacar.frame import Frame
from spacar.kinematics.diagnosis import diagnose
from spacar.kinematics.sweep import Sweep
from spacar.modes import Run


def check(run: Run) -> Iterator[Frame]:
    """One frame with `bigd`; the diagnosis goes to the report and, as a record, to header['diagnosis']."""
    mechanism = run.mechanism
    n = mechanism.numbering
    sweep = Sweep(mechanism)
    sweep.strain(mechanism.x0)
    V = sweep.gradient()
    diagnosis = diagnose(mechanism, V)
    run.n_frames = 1
    run.header["condition"] = diagnosis.condition
    run.header["diagnosis"] = diagnosis
    for line in diagnosis.lines():
        run.report.add(line)
    zero_x, zero_e = np.zeros(n.nx), np.zeros(n.ne)
    yield Frame(
        t=0.0, x=mechanism.x0.copy(), xd=zero_x, xdd=zero_x, e=sweep.e.copy(), ed=zero_e, edd=zero_e,
        sig=zero_e, fx=zero_x, fxgrav=zero_x, fxtot=zero_x, bigd=V,
    )  # fmt: skip
