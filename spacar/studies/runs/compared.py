"""What the runs of a trade are compared by, the same variables in the same order for every model.

These are the expressions that the user gives; without them coordinates in motions, and in the stationary modes what
`spacar.studies.runs.result_quantities` says of the nodes that the user's model has.
"""

import ast
from collections.abc import Container, Sequence
from contextlib import suppress

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES, Deck
from spacar.errors import UsageError
from spacar.expressions.grammar import VECTORS, X_NAMES, indices, parse
from spacar.mechanism import build
from spacar.modes import find_mode
from spacar.result import Result
from spacar.studies.runs.quantities import Quantity
from spacar.studies.runs.result_quantities import Assessed, amplitudes, assessed
from spacar.studies.runs.rows import Row

GENERAL = ("eigenvalue", "load multiplier")  # words in the names of variables that belong to no node


def compared(deck: Deck, mode: int, variables: Sequence[Quantity], result: Result, fewer: bool = False) -> Assessed:
    """The variables that count in a result of `deck` or of one with more nodes, or (`fewer`) with fewer: then those of
    nodes that it does not have are nan, and all but coordinates in the plane when it is planar and the deck is not.
    Raises UsageError."""
    if variables:
        both = _common_coordinates(deck, result)
        values = np.full((len(variables), len(result.frames)), np.nan)
        for row, variable in zip(values, variables, strict=True):
            if both is not None and not _made_of(variable, both):
                continue
            with suppress(*[UsageError] * fewer):
                series = variable.series(result)
                if np.iscomplexobj(series):
                    text = f"{variable.text} is complex; compare real(), imag() or abs() of it"
                    raise UsageError(text, "study.trade")
                row[:] = series
        return Assessed(tuple(v.name for v in variables), values, amplitudes(values, find_mode(mode).stationary))
    numbering = build(deck, mode).numbering
    own = {numbering.x_name(i) for i in range(numbering.nx)}
    found = assessed(result.mechanism, mode, result.frames, (), stationary=True)
    shared = [n.removeprefix("reaction at ") in own or any(word in n for word in GENERAL) for n in found.names]
    here = np.flatnonzero(np.isfinite(found.amplitude) & np.array(shared, bool))
    return Assessed(tuple(found.names[i] for i in here), found.values[here], found.amplitude[here])


def _common_coordinates(deck: Deck, result: Result) -> set[tuple[int, ...]] | None:
    """Node and number of the coordinates that mean the same in a planar result and the spatial deck; None: all."""
    made = result.mechanism.numbering
    if made.planar == ELEMENT_TYPES[deck.of(*ELEMENT_TYPES, block=1)[0].keyword].planar:
        return None
    return {(node, c) for node, c in map(made.x_owner, range(made.nx)) if made.role(node) == "position"}


def _made_of(variable: Quantity, coordinates: Container[tuple[int, ...]]) -> bool:
    """Has an expression, apart from frequencies and multipliers, these coordinates and what belongs to them only?"""
    found = [v for v in ast.walk(parse(variable.text).tree) if isinstance(v, ast.Subscript)]
    names = [(v.value.id, indices(v, variable.text)) for v in found if isinstance(v.value, ast.Name)]
    return all(name in VECTORS or (name in X_NAMES and place in coordinates) for name, place in names)


def row_values(row: Row, names: Sequence[str]) -> Array:
    """Values of a finished row for these names, (variables, times), nan where there are none; no names: all of it."""
    values = np.array(row["values"])
    if not names or list(names) == row["names"]:  # of which two may be the same
        return values
    found, missing = dict(zip(row["names"], values, strict=True)), np.full(values.shape[1:], np.nan)
    return np.array([found.get(name, missing) for name in names])
