"""The position of the start values is that of the branch of the reference configuration."""

import numpy as np
import pytest

import spacar

FIXED = {6: (0.038, -1.489, -1.179), 7: (-0.16, -0.653, -0.67)}


@pytest.mark.parametrize("compiled", [True, False])
def test_three_bars_that_are_nearly_in_a_plane(compiled: bool) -> None:
    """Newton's iteration ends at the mirror image; on the way the volume of the tetrahedron keeps its sign."""
    start, end, node = (0.056, -0.886, -0.964), (-0.0097, -0.8869, -1.0069), (0.407, -0.995, -1.384)
    rows = [("TRUSS", 1, 5, 1), ("TRUSS", 2, 6, 5), ("TRUSS", 3, 7, 5), ("X", 1, *start), ("X", 5, *node),
            *(("X", n, *at) for n, at in FIXED.items()), ("FIX", 6), ("FIX", 7), ("DYNX", 1), ("DYNE", 1),
            ("DYNE", 3)]  # fmt: skip
    law = [("XM", 1, 1.0), ("XM", 5, 1.0), *(("STARTDX", 1, i, at, 0.0) for i, at in enumerate(end, 1)),
           ("STARTDE", 1, 1, 0.0194, 0.0), ("STARTDE", 3, 1, -0.0467, 0.0)]  # fmt: skip
    result = spacar.run(1, spacar.Deck.build(rows, law), compiled=compiled)

    def volume(support: tuple[float, ...], node: np.ndarray) -> float:
        return float(np.linalg.det(np.subtract([support, FIXED[6], FIXED[7]], node)))

    assert volume(start, np.array(node)) * volume(end, result.node(5)[0]) > 0.0
