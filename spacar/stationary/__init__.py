"""STATIO: static equilibrium and steady motion under stepwise loading (theory-system.md section 6)."""

from spacar.stationary.loading import LoadLevel, LoadProgram
from spacar.stationary.solution import StationarySolver

__all__ = ["LoadLevel", "LoadProgram", "StationarySolver"]
