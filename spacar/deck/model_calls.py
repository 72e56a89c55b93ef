"""What a deck and a Model do themselves: `model.run(7)` is `spacar.run(7, model)`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

PUBLIC = "spacar"  # named, not imported: its calls lie above this room


class ModelCalls:
    """The public calls of spacar with this model.

    >>> import spacar
    >>> cantilever = spacar.read_deck("data/plbeam5.dat")
    >>> print(f"{cantilever.run(7).frequencies[0, 0]:.4f} Hz")
    0.1251 Hz
    """

    def run(self, mode: int, **options: Any) -> Any:
        """`spacar.run(mode, self, ...)`: a `Result`."""
        return import_module(PUBLIC).run(mode, self, **options)

    def flexure(self, **options: Any) -> Any:
        """`spacar.flexure(self, ...)`: a `Flexure`."""
        return import_module(PUBLIC).flexure(self, **options)

    def sensitivity(self, parameters: Sequence[str], quantities: Sequence[str], **options: Any) -> Any:
        """`spacar.sensitivity(self, ...)`: a `Sensitivity`."""
        return import_module(PUBLIC).sensitivity(self, parameters, quantities, **options)

    def sweep(self, change: Mapping[str, Any], results: str | Sequence[str], **options: Any) -> Any:
        """`spacar.sweep(self, ...)`: its rows."""
        return import_module(PUBLIC).sweep(self, change, results, **options)

    def trade(self, target: float = 1e-4, **options: Any) -> Any:
        """`spacar.trade(self, ...)`: a `TradeAnswer`."""
        return import_module(PUBLIC).trade(self, target, **options)
