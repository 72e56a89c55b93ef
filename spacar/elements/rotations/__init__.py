"""Rotations by Euler parameters, and local frames."""
