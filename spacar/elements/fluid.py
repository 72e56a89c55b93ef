"""What tubes in the plane and in space have in common: the numbers of their fluid."""

from __future__ import annotations

from typing import Any

import numpy as np

from spacar.arrays import Array


def flow_parameters(tube: Any) -> Array:
    """Mass flow and thrust a G U/l0 of a fluid; both again where it leaves at p, at q: (6, n)."""
    flow = tube.flow
    thrust = tube.shape_factor * flow**2 / (np.where(flow == 0.0, 1.0, tube.fluid) * tube.length)
    jets = tube.jet_p, tube.jet_q
    return np.stack([flow, *(flow * jet for jet in jets), thrust, *(thrust * jet for jet in jets)])
