"""spacar: analysis of planar and spatial mechanisms with rigid and flexible links.

>>> import spacar
>>> deck = spacar.Deck.build([("PLTRUSS", 1, 1, 2), ("X", 2, 1.0, 0.0), ("FIX", 1), ("FIX", 2, 2)])
>>> result = spacar.run(0, deck)
>>> int(result.mechanism.numbering.nx)
4
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from spacar.modes import register as _register

if TYPE_CHECKING:
    from spacar.calls import frames, run
    from spacar.deck import Deck, parse_deck, read_deck
    from spacar.deck.model import Model
    from spacar.frame import Frame
    from spacar.result import Result
    from spacar.sensitivities.sensitivity import Sensitivity, sensitivity
    from spacar.stream import Run
    from spacar.stroke import flexure
    from spacar.studies.study_calls import sweep, trade

__version__ = "1.0.0"
__all__ = [
    "Deck", "Frame", "Model", "Result", "Run", "Sensitivity",
    "flexure", "frames", "parse_deck", "read_deck", "run", "sensitivity", "sweep", "trade",
]  # fmt: skip

_HOME = {
    "Deck": "spacar.deck", "Model": "spacar.deck.model", "parse_deck": "spacar.deck", "read_deck": "spacar.deck",
    "Frame": "spacar.frame", "Result": "spacar.result", "Run": "spacar.stream", "frames": "spacar.calls",
    "run": "spacar.calls", "sweep": "spacar.studies.study_calls", "trade": "spacar.studies.study_calls",
    "flexure": "spacar.stroke",
    "Sensitivity": "spacar.sensitivities.sensitivity", "sensitivity": "spacar.sensitivities.sensitivity",
}  # fmt: skip

# What modules of the core ask `spacar.modes` for, because it lies above them.
_ABOVE = {
    **dict.fromkeys(
        ("draw", "animate", "plot", "stress", "inline_picture", "inline_model", "sweep_plot", "trade_plot",
         "response_plot", "sensitivity_plot", "flexure_plot", "flexure_page"), "spacar_drawing"),
    "StressDerivatives": "spacar_drawing.stress_numbers", "write_text": "spacar_formats.safety",
    "state_space_of": "spacar_formats.getss",
    **dict.fromkeys(("save_run", "save_result"), "spacar_formats.saving"),
    **dict.fromkeys(("to_pandas", "to_xarray", "frame_of_rows", "frame_of_response"), "spacar_formats.tables"),
    "accuracy": "spacar.studies.policies.accuracy:frames",
    "directional_compliances": "spacar.linear.buckling:directional_compliances",
    "without_rigid_parts": "spacar.dynamics.left_out:frames",
}  # fmt: skip


@_register
def _found(name: str) -> Any:
    """What has this name above the core, among the public names, or as an analysis, "module:function"."""
    from importlib import import_module

    module, _, other = ({**_HOME, **_ABOVE}.get(name) or name).partition(":")
    return getattr(import_module(module), other or name)


def __getattr__(name: str) -> Any:
    """Import lazily: `spacar --version` must not pay for NumPy."""
    if name in _HOME:
        found = globals()[name] = _found(name)
        return found
    raise AttributeError(f"module 'spacar' has no attribute '{name}'")


def __dir__() -> list[str]:
    """The public names, although they are imported when they are asked for."""
    return sorted([*__all__, *(name for name in globals() if name.startswith("__"))])
