"""Transfer functions in the output, as OUTLEVEL asks (input-language.md note k8)."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from spacar.arrays import Array
from spacar.frame import Frame
from spacar.kinematics.kinematics import Kinematics
from spacar.kinematics.transfer import (
    configuration_transfer,
    second_order_transfer,
    third_order_transfer,
    velocity_transfer,
)

if TYPE_CHECKING:
    from spacar.stream import Run

FIRST, SECOND = 1, 2  # flags of the sbd level, and of the log level, which has more:
THIRD, GLOBAL_DEFORMATION = 4, 8
LARGEST_THIRD = 10_000_000  # numbers of a third order tensor; larger ones are refused


class FirstOrder(Protocol):
    """Transfer functions of the degrees of freedom, (nx, n) and (ne, n): W and We of rates, G and Ge of the
    configuration."""

    @property
    def W(self) -> Array: ...
    @property
    def We(self) -> Array: ...
    @property
    def G(self) -> Array: ...
    @property
    def Ge(self) -> Array: ...


class Placed(Protocol):
    """What is at a configuration, such as an evaluator."""

    @property
    def kinematics(self) -> Kinematics: ...


class _Transfer:
    """Those of the present configuration."""

    def __init__(self, k: Kinematics) -> None:
        self._k, self.W = k, velocity_transfer(k)
        self.G = configuration_transfer(k, self.W)

    @cached_property
    def We(self) -> Array:
        return self._k.sweep_rates(self.W)

    @cached_property
    def Ge(self) -> Array:
        return self._k.sweep_rates(self.G)


class TransferOutput:
    """Adds dx, de (flag 1) and d2x, d2e (flag 2) to frames; stationary modes have flag 1 by default.

    What only the log asks for goes to `frame.log`: dx de d2x d2e d3x d3e bigd. Tensors have a row for every coordinate
    or deformation and a column for every combination of degrees of freedom, the first index running fastest.
    """

    def __init__(self, run: Run) -> None:
        settings = run.mechanism.settings
        level = settings.sbd_level
        if level is None:
            level = FIRST if run.mode.stationary else 0
        self.level = FIRST | SECOND if level < 0 else level
        self.log = 15 if settings.log_level < 0 else settings.log_level
        n = run.mechanism.numbering
        if self.log & THIRD and max(n.nx, n.ne) * n.nkdof**3 > LARGEST_THIRD:
            self.log &= ~THIRD
            run.report.add(
                f"the third order transfer functions of {n.nkdof} degrees of freedom would have {n.nx * n.nkdof**3:,}"
                " numbers: they are left out"
            )

    @property
    def wanted(self) -> bool:
        """Whether anything is added."""
        return bool(self.level or self.log & (FIRST | SECOND | THIRD | GLOBAL_DEFORMATION))

    def add(self, frame: Frame, placed: Placed, known: FirstOrder | None = None) -> Frame:
        """The same frame with the transfer functions of the present configuration; `known` of a linearization there."""
        if self.log & GLOBAL_DEFORMATION:
            frame.log["bigd"] = placed.kinematics.sweep.gradient()
        if not self.level and not self.log & (FIRST | SECOND | THIRD):
            return frame
        if known is None:
            known = _Transfer(placed.kinematics)
        W, G = known.W, known.G
        if (self.level | self.log) & FIRST:
            frame.log["dx"], frame.log["de"] = G, known.Ge
        if self.level & FIRST:
            frame.dx, frame.de = G, known.Ge
            frame.dxc, frame.dec = W, frame.de if G is W else known.We
        if self.level & SECOND or self.log & (SECOND | THIRD):
            k = placed.kinematics
            d2x, d2e = second_order_transfer(k, G)
            flat = [A.reshape(len(A), -1, order="F") for A in (d2x, d2e)]
            if self.level & SECOND:
                frame.d2x, frame.d2e = flat
            if self.log & SECOND:
                frame.log["d2x"], frame.log["d2e"] = flat
            if self.log & THIRD:
                d3 = third_order_transfer(k, G, d2x)
                frame.log["d3x"], frame.log["d3e"] = (A.reshape(len(A), -1, order="F") for A in d3)
        return frame
