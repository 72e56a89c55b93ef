"""SymPy to C: the functions of the elements, when the package is built."""
