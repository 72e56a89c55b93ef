"""KIN: configuration, velocities, transfer functions (theory-system.md section 1)."""

from spacar.kinematics.element_sweep import ElementSweep
from spacar.kinematics.kinematics import Kinematics

__all__ = ["ElementSweep", "Kinematics"]
