"""Lets the tests import the modules of benchmarks/, whose models they share."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
