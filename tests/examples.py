"""The folder of the example models."""

from pathlib import Path

DATA = Path(__file__).resolve().parents[1] / "data"
