"""Derivatives of stationary quantities with respect to numbers of the deck (docs/sensitivity.md)."""
