"""A mass on a spring, undamped: x = 1 + 0.01 cos 20 t."""

OSCILLATOR = """
PLTRUSS 1 1 2   X 2 1. 0.   FIX 1   FIX 2 2   DYNE 1 1   END HALT
XM 2 0.5   ESTIFF 1 200.   STARTDE 1 1 0.01 0.   TIMESTEP 0.4 8   END END
"""
