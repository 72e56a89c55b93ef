"""DYN: equations of motion, accelerations, stresses and reactions (theory-system.md section 2)."""

from spacar.dynamics.array_evaluator import Dynamics

__all__ = ["Dynamics"]
