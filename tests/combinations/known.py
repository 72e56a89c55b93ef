"""Disagreements that are known: (seed of the case, relation) -> finding. Each is removed when the program is mended."""

ARM = "rigid_tree.c takes the arm of a body from the reference, where DRPINBOD wants another one"
KNOWN: dict[tuple[int, str], str] = {(231, "as spatial"): ARM}
