"""Transfer functions in the output, as OUTLEVEL asks (keywords.md note k8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from spacar.frame import Frame
from spacar.kinematics.kinematics import Kinematics
from spacar.kinematics.second_order import second_order_transfer
from spacar.kinematics.transfer import configuration_transfer, velocity_transfer

if TYPE_CHECKING:
    from spacar.modes import Run

FIRST, SECOND = 1, 2  # flags of the sbd level


class TransferOutput:
    """Adds dx, de (flag 1) and d2x, d2e (flag 2) to frames; modes 7 to 10 have flag 1 by default."""

    def __init__(self, run: Run) -> None:
        settings = run.mechanism.settings
        level = settings.sbd_level
        if level is None:
            level = FIRST if run.mode.number in (7, 8, 9, 10) else 0
        self.level = FIRST | SECOND if level < 0 else level

    def add(self, frame: Frame, k: Kinematics) -> Frame:
        """The same frame with the transfer functions of the present configuration."""
        if not self.level:
            return frame
        W = velocity_transfer(k)
        G = configuration_transfer(k, W)
        if self.level & FIRST:
            frame.dx, frame.de = G, k.sweep_rates(G)
            frame.dxc, frame.dec = W, k.sweep_rates(W)
        if self.level & SECOND:
            d2x, d2e = second_order_transfer(k, G)
            frame.d2x = d2x.reshape(len(d2x), -1, order="F")
            frame.d2e = d2e.reshape(len(d2e), -1, order="F")
        return frame
