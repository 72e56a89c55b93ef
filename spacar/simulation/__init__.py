"""Controlled simulation, set-points and time-varying linear systems (the roles of SPASIM, LTV and their blocks)."""

from typing import Any

_NAMES = {  # by the modules that have them
    "blocks": "Block Continuous Function Gain Linear Product Sampled Scope proportional_derivative",
    "control_blocks": "Integrator PID RateLimiter transfer_function", "control_systems": "as_control",
    "diagram": "Diagram", "engine": "closed_loop simulate",
    "feedback": "computed_torque static_start tracking_gains with_gain", "plant": "Spasim",
    "propagation": "simulate_ltv", "reduction": "reduce_modes", "response": "Event Response",
    "sampled_blocks": "sampled_linear sampled_pid sampled_rate_limiter sampled_transfer_function "
                      "unit_delay zero_order_hold",
    "setpoint_blocks": "Ltv ReferenceY0 SetpointSigma0 SetpointU0 TimesM0",
    "signal_sources": "Constant Pulses Ramp Sine StepSignal Table TimeSeries",
    "switching_blocks": "DeadZone LookupTable Quantizer Relay Saturation", "time_varying": "TimeVarying",
    "transport_delay": "TransportDelay",
}  # fmt: skip
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    """Import lazily: setting up a linear system does not need the mechanism, and the other way round."""
    if name in _HOME:
        from importlib import import_module

        return getattr(import_module(f"spacar.simulation.{_HOME[name]}"), name)
    raise AttributeError(f"module 'spacar.simulation' has no attribute '{name}'")
