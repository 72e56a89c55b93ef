"""Forward dynamics: integration of the equations of motion in time (mode 1; mode 4 linearizes its states)."""
