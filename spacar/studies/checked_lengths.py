"""The checks of a deck that depend on lengths (`spacar.deck.checks_geometry`), of all cases of a study at once.

The bounds are a little narrower, MARGIN for rounding: a case beyond them gets a deck of its own, whose checks decide
and say what is wrong.
"""

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES, Deck
from spacar.deck.checks_geometry import PARALLEL, ZERO_LENGTH, least_length
from spacar.mechanism import Mechanism

MARGIN = 1e-9


def placed_well(mechanism: Mechanism, deck: Deck, x0: Array) -> NDArray[np.bool_]:
    """Cases whose elements have lengths and directions that a deck may have; x0: (nx, cases)."""
    n = mechanism.numbering
    well: NDArray[np.bool_] = np.ones(x0.shape[1], bool)
    well &= np.isfinite(x0).all(axis=0)
    places = x0[n.positions]  # (nodes, components, cases)
    if not len(places):
        return well
    least = ZERO_LENGTH * (1.0 + MARGIN) * (places.max(axis=0) - places.min(axis=0)).max(axis=0)
    for s in deck.of(*ELEMENT_TYPES, block=1):
        kind = ELEMENT_TYPES[s.keyword]
        ends = [s.integer(i) for i, role in enumerate(kind.nodes, 1) if role == "position"]
        if len(ends) < 2 or ends[0] == ends[1]:
            continue
        p, q = (x0[n.lnp[end - 1][n.lnp[end - 1] > 0] - 1] for end in ends[:2])
        chord = q - p
        length = np.sqrt((chord * chord).sum(axis=0))
        direction = None
        if kind.direction is not None:
            first, count, role = kind.direction
            direction = np.array(s.reals(first - 1, count)) if len(s.values) >= first - 1 + count else None
        if kind.length == "always" or (kind.length == "with direction" and direction is not None):
            well &= length > least
        least_chord = (1.0 + MARGIN) * least_length(s)
        if least_chord:
            well &= length > least_chord
        if direction is not None and role != "axis":
            well &= ~(length > least) | ~(_sine(chord, length, direction) < (1.0 + MARGIN) * PARALLEL)
    return well


def _sine(chord: Array, length: Array, direction: Array) -> Array:
    """Of the angles between chords (components, cases) and a direction (components,)."""
    size = float(np.abs(direction).max())
    a = np.zeros((3, chord.shape[1]))
    with np.errstate(all="ignore"):
        a[: len(chord)] = chord / length
    b = np.zeros(3)
    b[: len(direction)] = direction / size / np.linalg.norm(direction / size)
    return np.asarray(np.linalg.norm(np.cross(a.T, b), axis=-1))
