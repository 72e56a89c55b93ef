"""How far a motion goes, and whether ERROR is small beside it.

ERROR has one absolute part for lengths [m] and rotations [rad]. Its default 1e-5 suits mechanisms that move by
centimetres; a resonator that moves by 1e-7 m is lost in it. Of each kind that the state contains, the largest span over
the output times of a coordinate or of a deformation in the state counts. A span below ROUNDED is rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spacar.errors import Report
from spacar.frame import Frame, StoredFrames
from spacar.integrators import METHODS
from spacar.mechanism import Mechanism

LENGTHS, ROTATIONS = "lengths", "rotations"
UNITS = {LENGTHS: "m", ROTATIONS: "rad"}
LARGEST = 0.01  # ERROR over the largest motion of its kind, above which the run is warned of
ROUNDED = 1e4 * float(np.finfo(float).eps)  # of the size of the model, or of a radian


class Extent:
    """Least and largest value of every coordinate and deformation so far."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.low: list[np.ndarray] = []
        self.high: list[np.ndarray] = []

    def take(self, block: Sequence[Frame]) -> None:
        """Go on with the frames of a block."""
        if not len(block):
            return
        columns = [
            block.column(name) if isinstance(block, StoredFrames) else np.array([getattr(f, name) for f in block])
            for name in ("x", "e")
        ]
        seen = [(c.min(axis=0), c.max(axis=0)) for c in columns if c is not None]
        if not self.low:
            self.low, self.high = [low.copy() for low, _ in seen], [high.copy() for _, high in seen]
        for (low, high), lowest, highest in zip(seen, self.low, self.high, strict=True):
            np.minimum(lowest, low, out=lowest)
            np.maximum(highest, high, out=highest)

    def sizes(self) -> dict[str, float]:
        """The largest motion of each kind that the state contains and that does not rest."""
        mechanism = self.mechanism
        n = mechanism.numbering
        if not self.low:
            return {}
        x, e = (high - low for low, high in zip(self.low, self.high, strict=True))
        is_position = np.zeros(n.nx, bool)
        is_position[n.positions.ravel()] = True
        in_x, in_e = np.zeros(n.nx, bool), np.zeros(n.ne, bool)
        for name in ("dynamic", "kinematic"):
            in_x[n.x_class[name]], in_e[n.e_class[name]] = True, True
        kinds = ((LENGTHS, mechanism.length, is_position, mechanism.is_length),
                 (ROTATIONS, 1.0, ~is_position, ~mechanism.is_length))  # fmt: skip
        found = {}
        for kind, size, own_x, own_e in kinds:
            if (in_x & own_x).any() or (in_e & own_e).any():
                most = max(float(x[own_x].max(initial=0.0)), float(e[own_e & in_e].max(initial=0.0)))
                if most > ROUNDED * size:
                    found[kind] = most
        return found

    def tell(self, report: Report) -> None:
        """Warn of an absolute ERROR that is large beside the motion."""
        settings = self.mechanism.settings
        if not METHODS[settings.integrator].variable_step:
            return
        for kind, most in self.sizes().items():
            if most < settings.atol / LARGEST:
                unit = UNITS[kind]
                report.add(
                    f"warning: ERROR allows {settings.atol:.3g} {unit} (its absolute part), and no motion of {kind} is"
                    f" larger than {most:.3g} {unit}: the result may be wrong by as much; take {1e-4 * most:.1g} or"
                    " less (--atol), or --accuracy, which counts in parts of the motion"
                )
