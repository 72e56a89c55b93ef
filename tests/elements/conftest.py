"""Lets the element tests import their shared helpers (`derivatives`, `spatial_truth`) by name."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
