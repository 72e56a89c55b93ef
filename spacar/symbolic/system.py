"""A multibody system as it is written on paper: coordinates, frames, points, bodies, beams, loads, constraints.

`MultibodySystem.derive` turns it into equations of motion (`symbolic_equations.py`). Everything that is put in or
comes out is public; the vectors module works without it. Source: `symbolic.md`, sections 3 and 6.
"""

from typing import Any

from spacar.errors import UsageError
from spacar.symbolic.beams import make_beam, make_section
from spacar.symbolic.description import Description
from spacar.symbolic.symbolic_equations import SymbolicEquations, derive
from spacar.symbolic.system_parts import Beam, CrossSection, FrameOrSection, GeometricPoint, frame_at
from spacar.symbolic.unit_vectors import TIME


class MultibodySystem(Description):
    """A system in the inertial frame `N` with origin `O`.

    `gravity` is a vector, or its three measure numbers in N [m/s²] as expressions or texts (`("0", "-g", "0")`).

    >>> S = MultibodySystem(gravity=("0", "-g", "0"))
    >>> q, s = S.coordinate("q", speed="s")
    >>> m, L = S.parameters("m L")
    >>> B = S.frame("B", parent=S.N, axis=3, angle=q)
    >>> bob = S.particle("bob", S.point("P", S.O, L * B[1]), mass=m)
    >>> S.derive().explicit()
    (Matrix([[L**2*m]]), Matrix([[-L*g*m*cos(q(t))]]))
    """

    def beam(
        self, name: str, frame: FrameOrSection, root: GeometricPoint, length: Any, mass: Any,
        **properties: Any,
    ) -> Beam:  # fmt: skip
        """A beam along axis 1 of `frame` from `root`; the properties are those of `beams.make_beam`."""
        beam = make_beam(self, name, frame_at(frame), root, length, mass, **properties)
        self.beams.append(beam)
        return beam

    def section(self, beam: Beam, x: Any) -> CrossSection:
        """The cross-section of a beam at x: a place for loads, bodies and frames between root and tip."""
        return make_section(self, beam, self.expression(x))

    # -- derivation --------------------------------------------------------------------------------------------

    def derive(self, strategy: str = "held", recurrence: bool = True) -> SymbolicEquations:
        """Equations of motion by the `held` (readable) or `recursive` (lean) strategy.

        `recurrence=False` derives held equations without Z variables. Raises UsageError for a coordinate without
        kinematic equation, an unknown strategy, dependent constraints.
        """
        for q in self.coordinates:
            if q.diff(TIME) not in self.rates:
                raise UsageError(f"coordinate {q.func} has no kinematic equation: give it a speed or use kinematic()")
        return derive(self, strategy, recurrence)
