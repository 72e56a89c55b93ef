"""Names of the states, inputs and outputs of a linearized system, for the log and the result files."""

from __future__ import annotations

from spacar.mechanism.numbering import Numbering


def dynamic_names(n: Numbering) -> list[str]:
    """The dynamic degrees of freedom."""
    return [n.q_names[i] for i in n.dynamic]


def state_names(n: Numbering) -> list[str]:
    """The state: configuration (dynamic degrees of freedom, kinematic coordinates), then velocities."""
    dynamic = dynamic_names(n)
    return [*dynamic, *n.k_names, *(f"d/dt {name}" for name in dynamic)]
