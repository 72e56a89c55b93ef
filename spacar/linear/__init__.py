"""LINEAR: linearized equations of motion, eigenvalues, buckling, state space (theory-system.md sections 4 to 6)."""

from spacar.linear.matrices import Linearization, linearize

__all__ = ["Linearization", "linearize"]
