"""Deck to Mechanism: numbering, classification, element batches, loads, drives."""

from spacar.mechanism.build import build
from spacar.mechanism.layout import Batch
from spacar.mechanism.mechanism import DriveState, Loads, Mechanism, Polynomial, SolverSettings, Start
from spacar.mechanism.numbering import Numbering

__all__ = [
    "Batch", "DriveState", "Loads", "Mechanism", "Numbering", "Polynomial", "SolverSettings", "Start", "build",
]  # fmt: skip
