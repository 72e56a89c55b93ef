"""Controlled simulation, set-points and time-varying linear systems (the roles of SPASIM, LTV and their
blocks).
"""

from __future__ import annotations

from typing import Any

_HOME = {
    "Block": "blocks", "Continuous": "blocks", "Diagram": "diagram", "Event": "engine", "Function": "blocks",
    "Gain": "blocks", "Linear": "blocks", "Ltv": "setpoint_blocks", "ReferenceY0": "setpoint_blocks",
    "Response": "engine", "Sampled": "blocks", "Saturation": "blocks",
    "SetpointSigma0": "setpoint_blocks", "SetpointU0": "setpoint_blocks",
    "Spasim": "plant", "Table": "time_tables", "TimeVarying": "time_varying", "TimesM0": "setpoint_blocks",
    "as_control": "control_systems", "closed_loop": "loop", "computed_torque": "feedback",
    "proportional_derivative": "blocks", "reduce_modes": "reduction", "simulate": "engine",
    "simulate_ltv": "propagation", "static_start": "feedback",
    "tracking_gains": "feedback", "with_gain": "feedback",
}  # fmt: skip
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    """Import lazily: setting up a linear system does not need the mechanism, and the other way round."""
    if name in _HOME:
        from importlib import import_module

        return getattr(import_module(f"spacar.simulation.{_HOME[name]}"), name)
    raise AttributeError(f"module 'spacar.simulation' has no attribute '{name}'")
