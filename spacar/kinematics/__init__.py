"""KIN: configuration, velocities, transfer functions (theory-system.md section 1)."""

from spacar.kinematics.kinematics import Kinematics
from spacar.kinematics.sweep import Sweep

__all__ = ["Kinematics", "Sweep"]
