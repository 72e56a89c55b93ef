"""Quantities that studies keep: a named expression (spacar.expressions) that comes to one number, without its unit."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from spacar.errors import UsageError, shown
from spacar.expressions import Variables, evaluate, evaluate_cases, parse
from spacar.expressions.grammar import NOTHING_MORE, More
from spacar.result import Result


class Quantity(NamedTuple):
    """A checked expression; `name` heads its column."""

    name: str
    text: str

    def series(self, result: Result) -> np.ndarray:
        """Value over the stored steps, (steps,), or a single number as (1,). Raises UsageError."""
        return np.atleast_1d(evaluate(_parsed(self.text), result)[0])

    def numbers(self, variables: Variables, cases: int) -> list[float | complex | None] | None:
        """The numbers of all cases of `evaluate_cases`, None of a case that has to be told what is wrong, or of all."""
        try:
            values = evaluate_cases(_parsed(self.text), variables)
        except (UsageError, KeyError, OverflowError, RecursionError):
            return None
        if values.ndim > 1 and len(values) == 1:
            values = values[0]
        if values.ndim > 1:
            return None
        values = np.broadcast_to(values, (cases,))
        return [v if fine else None for v, fine in zip(values.tolist(), np.isfinite(values).tolist(), strict=True)]

    def number(self, result: Result) -> float | complex:
        """The single number that the expression is. Raises UsageError when it is a series or not finite."""
        return self.single(self.series(result), "study.quantity")

    def single(self, values: np.ndarray, code: str) -> float | complex:
        """The only one of its values. Raises UsageError with this code for a series and for what is not finite."""
        if values.size != 1:
            text = f"{self.text} has a value at each of {values.size} steps; add @end or a function such as max()"
            raise UsageError(text, code)
        value = values.item()
        if not np.isfinite(value):
            raise UsageError(f"{self.text} is {value}", code)
        return complex(value) if np.iscomplexobj(values) else float(value)


_parsed = lru_cache(maxsize=256)(parse)  # once for all cases


def quantity(text: str, more: More = NOTHING_MORE) -> Quantity:
    """The quantity of `EXPRESSION` or `NAME: EXPRESSION`; its form is checked now (`more`: as `parse`).

    Raises UsageError.
    """
    head, colon, tail = text.partition(":")
    name, expression = (head.strip(), tail.strip()) if colon else (text.strip(), text.strip())
    if not name:
        raise UsageError(f"the quantity '{text}' has no name before the colon", "study.quantity")
    if not name.isprintable() or name[0] in "=@":
        raise UsageError(f"the name {shown(name)!r} of a quantity begins with = or @ or has a control character",
                         "study.quantity")  # fmt: skip
    parse(expression, more)
    return Quantity(name, expression)
