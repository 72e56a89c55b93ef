"""Disagreements that are known: (seed of the case, relation) -> finding. Each is removed when the program is mended."""

KNOWN: dict[tuple[int, str], str] = {}
