"""Divided beams with a release: a warning where the result depends on which part keeps it (`deck.rewrite.divide`).

The last part alone keeps the release of a beam; the other parts have dynamic deformations, which start at zero and, in
steady motion, stay constant. So what a displaced start or a prescribed rate makes of the released deformation lies in
the last part, and with the ends exchanged in the part at the other end.
"""

import numpy as np

from spacar.mechanism.mechanism import Mechanism, Polynomial
from spacar.modes import Mode


def released_parts(mechanism: Mechanism, mode: Mode) -> list[str]:
    """One sentence for every such beam; none where nothing is displaced or moves."""
    if not (_starts(mechanism) if mode.integrated else mode.stationary and _moves(mechanism)):
        return []
    n = mechanism.numbering
    calculable = n.e_class["calculable"]
    found = []
    for beam, parts in mechanism.deck.divided.items():
        first, last = n.e_places[parts[0]], n.e_places[parts[-1]]
        modes = np.flatnonzero((last >= calculable.start) & (last < calculable.stop) & (first < calculable.start)) + 1
        if len(modes):
            names = " ".join(map(str, modes))
            found.append(
                f"beam {beam} is divided and releases mode {names}: what the start or a prescribed rate makes of it"
                f" lies in its last part (element {parts[-1]}); with DYNE {beam} {names} all parts have their share"
            )
    return found


def _moves(mechanism: Mechanism) -> bool:
    if not isinstance(mechanism.drive, Polynomial):
        return True
    at = mechanism.drive.at(0.0)
    return bool(at.xd.any() or at.ed.any())


def _starts(mechanism: Mechanism) -> bool:
    start, x0, of = mechanism.start, mechanism.x0, mechanism.numbering.x_class
    if start.e_value.any() or start.e_rate.any() or start.x_rate.any() or _moves(mechanism):
        return True
    given = mechanism.drive.at(0.0)
    return bool((start.x_value != x0[of["dynamic"]]).any() or (given.x != x0[of["input"]]).any() or given.e.any())
