"""What is evaluated, and where an evaluator stands: both values that never change."""

from __future__ import annotations

from dataclasses import dataclass

from spacar.arrays import Array
from spacar.dynamics.forces import StressLaw
from spacar.mechanism.mechanism import Drive, Loads, Mechanism


@dataclass(frozen=True)
class LoadedMechanism:
    """A mechanism under loads and prescribed motion, with the stress law of its active deformations."""

    mechanism: Mechanism
    loads: Loads
    drive: Drive
    law: StressLaw

    @classmethod
    def of(cls, mechanism: Mechanism, loads: Loads | None = None, drive: Drive | None = None) -> LoadedMechanism:
        """`loads` and `drive` replace those of the mechanism."""
        loads = loads or mechanism.loads
        return cls(mechanism, loads, drive or mechanism.drive, StressLaw.of(mechanism, loads))


@dataclass(frozen=True, slots=True)
class Placement:
    """The configuration and the velocity of the last evaluated state: from here another evaluator can go on.

    x, xd (nx,); e (ne,) deformations, which also say on what branch the angles are; e_given (ne,) those that were
    prescribed. The arrays may be those of the evaluator: they hold until its next evaluation.
    """

    x: Array
    xd: Array
    e: Array
    e_given: Array
