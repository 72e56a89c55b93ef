"""The structures of steps in engine.h, which `spacar.compiled.compiled_stepper` fills."""

from __future__ import annotations

import ctypes

from spacar.compiled.interface import fields


class CStepper(ctypes.Structure):
    _fields_ = fields("Stepper")


class CAdams(ctypes.Structure):
    _fields_ = fields("Adams")


class CRungeKutta(ctypes.Structure):
    _fields_ = fields("RungeKutta")
