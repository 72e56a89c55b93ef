"""The modes: one row each, with all that other rooms ask about them. Imports nothing, so that anybody may ask.

What lies above its caller is named, not imported: analyses, pictures, result files, public calls. `spacar/__init__.py`
says where it is, and `registered` loads it when it is asked for.
"""

from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from typing import Any

from spacar.errors import UsageError


@dataclass(frozen=True)
class Mode:
    """One analysis.

    analysis         "module:function" of a generator (run: Run) -> Iterator[Sequence[Frame]]
    files            the result files that it fills, of "sbd", "sbm", "ltv"
    third            kind of its third block, "trajectory" or "linearization"; None: it uses none
    forces           uses the second block: masses, stiffness, loads
    timed            its steps are moments of a motion
    integrated       the motion is integrated from a start state: TIMESTEP, ERROR, INTEGRAT
    stationary       its steps are load steps of a static equilibrium or steady motion: ITERSTEP
    gives_setpoints  its result is a motion to linearize along; takes_setpoints: it linearizes along such a result
    linearized       gives the linearized equations, so their modes of vibration;  buckling: gives load multipliers
    wheels           wheels (non-holonomic constraints) are supported
    """

    number: int
    title: str
    analysis: str
    files: tuple[str, ...]
    third: str | None = None
    forces: bool = True
    timed: bool = False
    integrated: bool = False
    stationary: bool = False
    gives_setpoints: bool = False
    takes_setpoints: bool = False
    linearized: bool = False
    buckling: bool = False
    wheels: bool = False

    @property
    def nominal(self) -> bool:
        """Can its result be linearized along: a motion, or load steps?"""
        return self.gives_setpoints or self.stationary


MODES = {
    mode.number: mode
    for mode in (
        Mode(0, "kinematic check", "spacar.kinematics.kinematic_mode:check", ("sbd",), forces=False, wheels=True),
        Mode(1, "forward dynamics", "spacar.forward.motion:forward", ("sbd",),
             timed=True, integrated=True, wheels=True),
        Mode(2, "inverse dynamics", "spacar.inverse.inverse_modes:inverse", ("sbd", "ltv"),
             third="trajectory", timed=True, gives_setpoints=True),
        Mode(3, "linearization along set-points", "spacar.inverse.inverse_modes:along", ("sbd", "sbm", "ltv"),
             third="trajectory", timed=True, takes_setpoints=True, linearized=True),
        Mode(4, "forward dynamics with linearization", "spacar.linear.linear_modes:forward", ("sbd", "sbm", "ltv"),
             third="linearization", timed=True, integrated=True, linearized=True, wheels=True),
        Mode(7, "stationary solution, eigenvalues", "spacar.linear.linear_modes:vibration_and_buckling", ("sbd", "sbm"),
             stationary=True, linearized=True, wheels=True),
        Mode(8, "stationary solution, buckling", "spacar.linear.linear_modes:vibration_and_buckling", ("sbd", "sbm"),
             stationary=True, buckling=True),
        Mode(9, "stationary solution, state space", "spacar.linear.linear_modes:state_space_matrices",
             ("sbd", "sbm", "ltv"), third="linearization", stationary=True, linearized=True, wheels=True),
        Mode(10, "stationary solution, eigenvalues and buckling", "spacar.linear.linear_modes:vibration_and_buckling",
             ("sbd", "sbm"), stationary=True, linearized=True, buckling=True),
    )
}  # fmt: skip


def find_mode(number: int) -> Mode:
    """The mode of this number; a minus sign (no drawing) does not matter. Raises UsageError."""
    if not isinstance(number, Real) or abs(number) not in MODES:
        known = ", ".join(str(m) for m in MODES)
        old = number in (5, 6, -5, -6)
        hint = "; modes 5 and 6 were experimental in the original and are not provided" if old else ""
        raise UsageError(f"mode {number} does not exist; the modes are {known}{hint}", "usage.mode")
    return MODES[abs(number)]


_finders: list[Callable[[str], Any]] = []


def register(find: Callable[[str], Any]) -> Callable[[str], Any]:
    """From now on `find` gives what has a name; it raises ImportError where that is not installed."""
    _finders[:] = [find]
    return find


def registered(name: str) -> Any:
    """The function of this name. Raises ImportError where its package is not installed."""
    return _finders[0](name)
