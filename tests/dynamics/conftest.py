"""Lets the dynamics tests import their shared helper (`reduced_form`) by name."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
