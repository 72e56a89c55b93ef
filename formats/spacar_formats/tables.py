"""Results as tables of pandas and xarray, which are extras: `pip install 'spacar[tables]'`.

Columns are called as in expressions: `x[6,1]`, `sig[2,3]`; units are in `attrs`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.arrays import Array
from spacar.calls import texts
from spacar.errors import UsageError
from spacar.expressions import Dimensions, evaluate, parse, unit_text
from spacar.mechanism.numbering import owners
from spacar.modes import find_mode
from spacar.result import E_VARIABLES, X_VARIABLES, Result
from spacar.simulation.response import Response
from spacar_formats.signal_tables import table_of

if TYPE_CHECKING:
    import pandas
    import xarray


MATRICES = ("m0", "c0", "d0", "k0", "n0", "g0")


def to_pandas(result: Result, expressions: Sequence[str] = ()) -> pandas.DataFrame:
    """One row a step, with the time (or load step) as index.

    expressions   columns; default: all coordinates, deformations, rates, forces and stresses that the mode computed

    Raises UsageError without pandas and for an expression that cannot be evaluated.
    """
    pandas = _extra("pandas")
    units = Dimensions.of(result.mechanism.numbering, find_mode(result.mode).stationary)
    if expressions:
        found = {text: evaluate(parse(text), result, units) for text in texts("an expression", expressions)}
    else:
        found = {
            f"{variable}[{a},{b}]": (column, units(variable, (a, b)))
            for variable, labels, values in variables(result)
            for (a, b), column in zip(labels, values.T, strict=True)
        }
    columns = {text: np.broadcast_to(np.asarray(value), len(result.frames)) for text, (value, _) in found.items()}
    names = {text: unit_text(unit) for text, (_, unit) in found.items()}
    timed = find_mode(result.mode).timed
    table = pandas.DataFrame(columns, index=pandas.Index(result.t, name="t" if timed else "load step"))
    table.attrs["units"] = {**names, "t": "s" if timed else ""}
    return table


def frame_of_rows(rows: Sequence[Mapping[str, Any]]) -> pandas.DataFrame:
    """A table of rows that have the same names. Raises UsageError without pandas."""
    return _extra("pandas").DataFrame(list(rows))


def frame_of_response(response: Response) -> pandas.DataFrame:
    """The signals of a simulation over t, columns (block, signal). Raises UsageError without pandas."""
    pandas, table = _extra("pandas"), table_of(response)
    names = pandas.MultiIndex.from_arrays([table.blocks, table.names], names=["block", "signal"])
    return pandas.DataFrame(table.values, index=pandas.Index(response.t, name="t"), columns=names)


def _extra(package: str) -> Any:
    try:
        return import_module(package)
    except ImportError:
        text = f"to_{package} needs {package}: pip install 'spacar[tables]'"
        raise UsageError(text, f"result.{package}-missing") from None


def to_xarray(result: Result) -> xarray.Dataset:
    """Variables over t and coordinate (node, number) or deformation (element, mode); matrices of the linearized
    equations over t, q and q2. Raises UsageError without xarray.
    """
    xarray = _extra("xarray")
    n = result.mechanism.numbering
    arrays: dict[str, Any] = {}
    for variable, _, values in variables(result):
        arrays[variable] = (("t", "deformation" if variable in E_VARIABLES else "coordinate"), values)
    for name in MATRICES:
        if result.frames and name in result.frames[0].matrices:
            arrays[name] = (("t", "q", "q2"), result[name])
    if result.frames and "eigval" in result.frames[0].matrices:
        arrays["frequency"] = (("t", "mode"), result.frequencies, {"units": "Hz"})
    x_owners, e_owners = owners(n.x_places, n.nx), owners(n.e_places, n.ne)
    places = {
        "t": ("t", result.t, {"units": "s" if find_mode(result.mode).timed else ""}),
        "coordinate": ("coordinate", [f"{a},{b}" for a, b in x_owners]),
        "node": ("coordinate", [a for a, _ in x_owners]),
        "deformation": ("deformation", [f"{a},{b}" for a, b in e_owners]),
        "element": ("deformation", [a for a, _ in e_owners]),
    }
    return xarray.Dataset(arrays, places, {"model": result.mechanism.deck.source, "mode": result.mode})


def variables(result: Result) -> Iterator[tuple[str, list[tuple[int, int]], Array]]:
    """Name, (node, coordinate) or (element, mode) of every column, values (steps, columns) of what was computed."""
    n = result.mechanism.numbering
    for names, labels in ((X_VARIABLES, owners(n.x_places, n.nx)), (E_VARIABLES, owners(n.e_places, n.ne))):
        for name in names:
            if result.frames and getattr(result.frames[0], name) is not None:
                yield name, labels, result[name]
