"""LINEAR: eigenvalues, buckling, state space of the linearized equations (theory-system.md sections 4 to 6)."""
