"""Controlled simulation, set-points and time-varying linear systems (the roles of SPASIM, LTV and their blocks)."""

from typing import Any

_HOME = {
    "Block": "blocks", "Constant": "signal_sources", "Continuous": "blocks", "DeadZone": "switching_blocks",
    "Diagram": "diagram", "Event": "response", "Function": "blocks", "Gain": "blocks", "Integrator": "control_blocks",
    "Linear": "blocks", "LookupTable": "switching_blocks", "Ltv": "setpoint_blocks", "PID": "control_blocks",
    "Product": "blocks", "Pulses": "signal_sources", "Quantizer": "switching_blocks", "Ramp": "signal_sources",
    "RateLimiter": "control_blocks", "ReferenceY0": "setpoint_blocks", "Relay": "switching_blocks",
    "Response": "response", "Sampled": "blocks", "Saturation": "switching_blocks", "Scope": "blocks",
    "SetpointSigma0": "setpoint_blocks", "SetpointU0": "setpoint_blocks", "Sine": "signal_sources",
    "Spasim": "plant", "StepSignal": "signal_sources", "Table": "signal_sources", "TimeSeries": "signal_sources",
    "TimeVarying": "time_varying", "TimesM0": "setpoint_blocks", "TransportDelay": "transport_delay",
    "as_control": "control_systems", "closed_loop": "engine", "computed_torque": "feedback",
    "proportional_derivative": "blocks", "reduce_modes": "reduction",
    "sampled_linear": "sampled_blocks", "sampled_pid": "sampled_blocks", "sampled_rate_limiter": "sampled_blocks",
    "sampled_transfer_function": "sampled_blocks", "simulate": "engine",
    "simulate_ltv": "propagation", "static_start": "feedback",
    "tracking_gains": "feedback", "transfer_function": "control_blocks", "unit_delay": "sampled_blocks",
    "with_gain": "feedback", "zero_order_hold": "sampled_blocks",
}  # fmt: skip
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    """Import lazily: setting up a linear system does not need the mechanism, and the other way round."""
    if name in _HOME:
        from importlib import import_module

        return getattr(import_module(f"spacar.simulation.{_HOME[name]}"), name)
    raise AttributeError(f"module 'spacar.simulation' has no attribute '{name}'")
