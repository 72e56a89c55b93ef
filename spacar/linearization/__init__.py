"""Linearized equations of motion about any motion: matrices, Jacobian (theory-system.md sections 4, 5)."""

from spacar.linearization.matrices import Linearization, linearize

__all__ = ["Linearization", "linearize"]
