"""Options of a run that replace what the deck says: the fields of Settings, checked as the deck's numbers are."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from numbers import Integral, Real
from typing import Any

from spacar.deck.table_solvers import INTEGRATOR_ALIASES, INTEGRATORS, alias_note
from spacar.errors import UsageError
from spacar.mechanism import SolverSettings
from spacar.modes import Mode

POSITIVE = ("atol", "rtol", "step", "duration", "n_steps")
BEAMS = ("angle", "sine")  # measures of the deformations of beams and tubes
LARGEST = {"rtol": 1.0, "n_steps": 10**15}  # an error of 100 %; times that still differ


def checked_options(options: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The options as `SolverSettings` takes them, None left out, and what the log must say about them.

    Raises UsageError for an unknown option, a value of the wrong type, one that is not positive or not finite where it
    must be, and an integration method that does not exist.
    """
    types = _types()
    found, notes = {}, []
    for name, value in options.items():
        if name not in types:
            raise UsageError(f"there is no option '{name}'; the options are {', '.join(types)}", "usage.option")
        if value is None:
            continue
        found[name] = _converted(name, value, types[name])
        if name in POSITIVE and not 0 < found[name] < float("inf"):
            raise UsageError(f"the option {name} = {value!r} must be positive and finite", "usage.option")
        if name == "modes" and found[name] < 0:
            raise UsageError(f"the option modes = {value!r} must not be negative (0: all)", "usage.option")
        if name in LARGEST and found[name] > LARGEST[name]:
            raise UsageError(f"the option {name} = {value!r} is at most {LARGEST[name]:g}", "usage.option")
        if name == "beams" and found[name] not in BEAMS:
            raise UsageError(f"the option beams = {value!r} is one of {', '.join(BEAMS)}", "usage.option")
        if name == "integrator":
            found[name], note = integrator(found[name])
            notes += [note] if note else []
    return found, notes


@cache
def _types() -> dict[str, str]:
    """Type of every option, in words."""
    return {f.name: str(f.type).removesuffix(" | None") for f in fields(SolverSettings)}


def _converted(name: str, value: Any, kind: str) -> Any:
    """The value as a number of the wanted kind; NumPy's numbers are numbers too."""
    if kind == "float" and type(value) is float:
        return value
    if kind == "str":
        right = isinstance(value, str)
    elif kind == "bool":
        right = type(value).__name__ in ("bool", "bool_")
    else:
        right = isinstance(value, Real if kind == "float" else Integral) and not isinstance(value, bool)
    if not right:
        wanted = {"bool": "True or False", "int": "a whole number", "float": "a number", "str": "a word"}[kind]
        raise UsageError(f"the option {name} = {value!r} must be {wanted}, not {type(value).__name__}", "usage.option")
    return {"bool": bool, "int": int, "float": float, "str": str}[kind](value)


def integrator(code: int, subject: str = "integrator type") -> tuple[int, str | None]:
    """The integration method of this code, and the note on an alias (the sentence of INTEGRAT). Raises UsageError."""
    if code in INTEGRATOR_ALIASES:
        return INTEGRATOR_ALIASES[code], alias_note(code)
    if code not in INTEGRATORS:
        known = ", ".join(map(str, sorted((*INTEGRATORS, *INTEGRATOR_ALIASES))))
        raise UsageError(f"{subject} {code} does not exist; the methods are {known}", "usage.integrator")
    return code, None


def check_modes(mode: Mode, wanted: int | None) -> None:
    """Raises UsageError when modes of vibration are asked for of a mode that stores only matrices along a motion."""
    if mode.takes_setpoints and wanted:
        text = f"mode {mode.number} computes no modes of vibration: the option modes = {wanted} can only be 0"
        raise UsageError(f"{text} (A, B, C, D and reduced matrices of a model of any size)", "usage.option")
