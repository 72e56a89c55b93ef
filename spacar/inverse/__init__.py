"""Inverse dynamics: trajectories (mode 2), and linearization along their result (mode 3)."""

from spacar.inverse.nominal import Nominal
from spacar.inverse.profile import IllegalProfile, Profile, make_profile

__all__ = ["IllegalProfile", "Nominal", "Profile", "make_profile"]
