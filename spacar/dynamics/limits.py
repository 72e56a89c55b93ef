"""Elements outside the range of their theory, and wheels that lift off.

Checked at stored steps, not in every evaluation.
"""

from __future__ import annotations

from operator import itemgetter
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, Report
from spacar.frame import Frame
from spacar.kinematics.regularity import Regularity

if TYPE_CHECKING:
    from spacar.dynamics.evaluator import Evaluator
    from spacar.kinematics.element_sweep import ElementSweep

# A pull above this part of the largest normal force seen: a chosen bound, above the rounding of a difference of forces
# (eps times their ratio, up to 1e6), far below what matters to a contact.
LIFTED = 1e-9


class Limits:
    """Remembers which wheels were pressed on the ground; warnings go to the report."""

    def __init__(self, evaluator: Evaluator, report: Report) -> None:
        n = evaluator.model.mechanism.numbering
        # the stress of the normal mode is the force of the road, compression negative
        rolling = [rows for rows in n.types if rows.kind.normal_mode]
        found = sorted([(number, rows.kind) for rows in rolling for number in rows.numbers.tolist()], key=itemgetter(0))
        wheels, self.keywords = [number for number, _ in found], [kind.keyword for _, kind in found]
        self.pressed = bool(evaluator.model.loads.gravity.any())
        self.wheels = np.array(wheels, np.int64)
        self.rows = np.array([n.e_index(wheel, kind.normal_mode) for wheel, kind in found], np.int64)
        self.compression = np.zeros(len(wheels))
        self.report = report
        self.warned: set[int] = set()
        self.regularity = Regularity(evaluator.position_matrix())

    def check(self, evaluator: Evaluator, frame: Frame) -> None:
        """Raises AnalysisError 'element.range' or 'element.lift-off' with element, time and advice."""
        try:
            self.regularity.check(frame.t)
        except AnalysisError:
            self.check_elements(evaluator, frame)  # an element that has collapsed explains more
            raise
        self.check_elements(evaluator, frame)

    def check_elements(self, evaluator: Evaluator, frame: Frame) -> None:
        """As `check`, without asking whether the degrees of freedom determine the configuration."""
        if not evaluator.in_range():
            self._elements(evaluator.settled().sweep, frame)
        if len(self.rows):
            self._wheels(frame.t, frame.sig[self.rows])

    def _elements(self, sweep: ElementSweep, frame: Frame) -> None:
        for batch in sweep.strained:
            e, sigma = frame.e[batch.e], frame.sig[batch.e]
            for trouble in batch.family.troubles(sweep.configuration[batch.index], e, sigma):
                element = int(batch.family.numbers[trouble.index])
                text = f"element {element} ({batch.family.keyword}) at t = {frame.t:.9g}: {trouble.text}"
                if trouble.fatal:
                    raise AnalysisError(text, "element.range", element=element)
                if element not in self.warned:
                    self.warned.add(element)
                    self.report.add(f"warning: {text}")

    def _wheels(self, t: float, normal: Array) -> None:
        self.compression = np.maximum(self.compression, -normal)
        size = max(float(np.abs(normal).max()), float(self.compression.max()))
        for k in np.flatnonzero(normal > LIFTED * size):
            text = (
                f"element {self.wheels[k]} ({self.keywords[k]}) at t = {t:.9g}: the wheel leaves the ground,"
                f" its normal force would be a pull of {normal[k]:.6g} N; reduce speed or steering,"
                " or release its normal mode"
            )
            if self.pressed or self.compression[k] > LIFTED * size:
                raise AnalysisError(text, "element.lift-off", element=int(self.wheels[k]))
            if self.wheels[k] not in self.warned:
                # without gravity nothing in the model presses wheels on the ground: the lift-off may be meant
                self.warned.add(int(self.wheels[k]))
                self.report.add(f"warning: {text} (the model has no gravity)")
