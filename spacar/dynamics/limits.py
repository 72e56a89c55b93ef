"""Elements outside the range of their theory, and wheels that lift off.

Checked at stored steps, not in every evaluation.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array
from spacar.errors import AnalysisError, Report
from spacar.frame import Frame
from spacar.kinematics.constraint_matrices import ROUNDING
from spacar.kinematics.regularity import PositionMatrix

if TYPE_CHECKING:
    from spacar.dynamics.evaluator import Evaluator
    from spacar.dynamics.loaded_mechanism import Entries, LoadedMechanism
    from spacar.kinematics.element_sweep import ElementSweep

# A pull above this part of the largest normal force seen: a chosen bound, above the rounding of a difference of forces
# (eps times their ratio, up to 1e6), far below what matters to a contact.
LIFTED = 1e-9


class Limits:
    """What is looked at; warnings go to the report."""

    def __init__(self, evaluator: Evaluator, report: Report) -> None:
        self.wheels = Wheels(evaluator.model)
        self.evaluator, self.report = evaluator, report
        self.warned: set[int] = set()

    @cached_property
    def matrix(self) -> PositionMatrix:
        """Outputs that are passed in C are looked at there first."""
        return self.evaluator.position_matrix()

    def check(self, evaluator: Evaluator, frame: Frame) -> None:
        """Raises AnalysisError 'element.range' or 'element.lift-off' with element, time and advice."""
        try:
            self.matrix.check(frame.t)
        except AnalysisError:
            self.check_elements(evaluator, frame)  # an element that has collapsed explains more
            raise
        self.check_elements(evaluator, frame)

    def check_elements(self, evaluator: Evaluator, frame: Frame) -> None:
        """As `check`, without asking whether the degrees of freedom determine the configuration."""
        if not evaluator.in_range():
            self._elements(evaluator.numpy_evaluator().sweep, frame)
        if len(self.wheels.rows):
            for _, wheel, text in self.wheels.lifted(frame.t, frame.fxtot[:, None], frame.sig[:, None]):
                if wheel not in self.warned:
                    self.warned.add(wheel)
                    self.report.add(f"warning: {text}")

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


class Wheels:
    """The wheels of a model, or of several cases of it, with a normal force, and which of them were pressed on the
    ground.

    rows        of their normal forces in the stresses: forces of the road, compression negative
    stiffness   of every case, values (n, cases); None: that of the model
    """

    def __init__(self, model: LoadedMechanism, cases: int = 1, stiffness: Entries | None = None) -> None:
        self.model, self.gravity, n = model, model.loads.gravity, model.mechanism.numbering
        self.stiffness = stiffness
        rolling = [(rows.numbers.tolist(), rows.kind) for rows in n.types if rows.kind.normal_mode]
        self.found = sorted([(w, kind.keyword, kind.normal_mode) for numbers, kind in rolling for w in numbers])
        self.rows = np.array([n.e_index(w, mode) for w, _, mode in self.found], np.int64)
        self.compression = np.zeros((len(self.found), cases))

    def press(self, normal: Array) -> None:
        """Remember how they were pressed on the ground; normal: (wheels, cases)."""
        np.maximum(self.compression, -normal, out=self.compression)

    def rounding(self, force: Array, stress: Array) -> Array:
        """What the sign of a normal force is known to, (cases,) [N]: it is a sum of forces and stresses, and these come
        from deformations, which are known to ROUNDING of their sizes."""
        m = self.model.mechanism
        rows, columns, S = self.stiffness or self.model.law.stiffness
        elastic = np.abs(S).T * (m.deformation_scale[rows] * m.deformation_scale[columns] / m.length)
        forces = np.concatenate((force[m.numbering.positions.ravel()], stress[m.is_length]))
        return np.asarray(ROUNDING * (np.abs(forces).max(axis=0) + elastic.max(axis=-1, initial=0.0)))

    def lifted(self, t: float, force: Array, stress: Array) -> Iterator[tuple[int, int, str]]:
        """Case, element and what to say of wheels that are pulled; total external forces (nx, cases) and stresses (ne,
        cases) of the state.

        Raises AnalysisError 'element.lift-off' where something has pressed the wheel on the ground.
        """
        normal = stress[self.rows]
        self.press(normal)
        size = np.maximum(np.abs(normal), self.compression).max(axis=0, initial=0.0)
        pulled = normal > LIFTED * size
        if pulled.any():
            pulled &= normal > self.rounding(force, stress)
        if not pulled.any():
            return
        for k, case in np.argwhere(pulled):
            wheel, keyword, _ = self.found[k]
            text = (
                f"element {wheel} ({keyword}) at t = {t:.9g}: the wheel leaves the ground,"
                f" its normal force would be a pull of {normal[k, case]:.6g} N; reduce speed or steering,"
                " or release its normal mode"
            )
            if self.gravity.any() or self.compression[k, case] > LIFTED * size[case]:
                raise AnalysisError(text, "element.lift-off", element=wheel)
            # without gravity nothing in the model presses wheels on the ground: the lift-off may be meant
            yield int(case), wheel, f"{text} (the model has no gravity)"
