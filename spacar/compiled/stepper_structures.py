"""The structures of stepper.c, adams.c and runge_kutta.c, which `spacar.compiled.compiled_stepper` fills."""

from __future__ import annotations

import ctypes

from spacar.compiled.library import DOUBLES, INTEGER, NUMBER, POINTER
from spacar.integrators.adams import MAX_ORDER


class CStepper(ctypes.Structure):
    """`TakeSteps` of stepper.c."""

    _fields_ = [
        ("model", POINTER), ("at", POINTER), ("ask", POINTER), ("records", DOUBLES),
        ("scale", DOUBLES), ("atol", DOUBLES),
        *((name, INTEGER) for name in ("n", "capacity", "width", "look", "back", "most", "max_reductions")),
        *((name, NUMBER) for name in (
            "reduction", "rtol", "longest", "converged", "jump", "earliest", "latest", "half", "inside", "wide",
            "far", "share", "noise", "still", "t", "t_end", "until", "h", "error", "peak", "begin",
        )),
        ("sizes", NUMBER * 2),
        *((name, INTEGER) for name in ("recorded", "entered", "n_steps", "n_rhs", "n_rejected", "reductions")),
        ("lambda0", POINTER), ("half_turn", NUMBER), ("signs", NUMBER * 8), ("n_lambda0", INTEGER),
    ]  # fmt: skip


class CAdams(ctypes.Structure):
    """`Adams` of adams.c."""

    _fields_ = [
        ("memory", DOUBLES), ("gamma_star", DOUBLES),
        *((name, DOUBLES) for name in ("phi", "expected", "y", "y_new", "predicted", "d", "weight")),
        ("psi", NUMBER * (MAX_ORDER + 1)), ("h_old", NUMBER), ("h_min", NUMBER),
        *((name, INTEGER) for name in ("k", "order", "k_old", "equal", "starting", "rejections")),
    ]  # fmt: skip


class CRungeKutta(ctypes.Structure):
    """`RungeKutta` of runge_kutta.c."""

    _fields_ = [
        *((name, DOUBLES) for name in ("c", "a", "b", "errors", "K", "y", "y_new", "scaled")),
        *((name, NUMBER) for name in ("exponent", "smallest", "largest", "safety", "tiny", "h")),
        *((name, INTEGER) for name in ("stages", "rows", "estimated", "two")),
    ]  # fmt: skip
