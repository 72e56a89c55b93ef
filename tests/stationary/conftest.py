"""Lets the tests of the linearization import their shared helpers (`nonlinear`, `models`) by name."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
