"""The named quantities of a result of `spacar symbolic`, and the empty scene of one without points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array
from spacar_drawing.scene import Scene

if TYPE_CHECKING:
    from spacar_formats.sbf import SbfFile

GROUPS = {"Q": "QNAME", "S": "SNAME", "U": "UNAME", "Y": "YNAME"}


def named_columns(file: SbfFile) -> dict[str, Array]:
    """(steps,) by name: states, inputs and outputs of a result of `spacar symbolic`; of another result nothing."""
    named: dict[str, Array] = {}
    if "symbolic" in file.header.get("KIND", ""):
        for letter, names in GROUPS.items():
            if file.has(letter):
                values = np.asarray(file.get(letter)).reshape(file.steps, -1)
                named |= dict(zip((str(n) for n in file.header[names]), values.T, strict=True))
    return named


def nothing(title: str) -> Scene:
    """A moving scene without elements: mode 1 says that the steps are times."""
    none, whole = np.zeros((0, 0)), np.zeros((0, 0), int)
    return Scene(
        planar=True, mode=1, title=title, keywords=(), lnp=whole, le=whole, ln=whole, frame_p=none, frame_q=none,
        length=none, data=none, stiffness=none, damping=none, quadratic=whole, nxp=whole, nep=whole,
    )  # fmt: skip
