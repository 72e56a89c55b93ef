"""What a deck and a Model do themselves: `model.run(7)` is `spacar.run(7, model)`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from spacar.modes import registered


class ModelCalls:
    """The public calls of spacar with this model.

    >>> import spacar
    >>> cantilever = spacar.read_deck("data/plbeam5.dat")
    >>> print(f"{cantilever.run(7).frequencies[0, 0]:.4f} Hz")
    0.1251 Hz
    """

    def run(self, mode: int, **options: Any) -> Any:
        """`spacar.run(mode, self, ...)`: a `Result`."""
        return registered("run")(mode, self, **options)

    def flexure(self, **options: Any) -> Any:
        """`spacar.flexure(self, ...)`: a `Flexure`."""
        return registered("flexure")(self, **options)

    def sensitivity(self, parameters: Sequence[str], quantities: Sequence[str], **options: Any) -> Any:
        """`spacar.sensitivity(self, ...)`: a `Sensitivity`."""
        return registered("sensitivity")(self, parameters, quantities, **options)

    def sweep(self, change: Mapping[str, Any], results: str | Sequence[str], **options: Any) -> Any:
        """`spacar.sweep(self, ...)`: its rows."""
        return registered("sweep")(self, change, results, **options)

    def trade(self, target: float = 1e-4, **options: Any) -> Any:
        """`spacar.trade(self, ...)`: a `TradeAnswer`."""
        return registered("trade")(self, target, **options)
