"""Spatial element types: a NumPy family, its SymPy definition beside it."""
