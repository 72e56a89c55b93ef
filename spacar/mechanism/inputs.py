"""Loads, prescribed motion, start values and settings of the dynamics block."""

from __future__ import annotations

from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES, Deck
from spacar.deck.statement import number
from spacar.deck.table_solvers import INTEGRATOR_ALIASES
from spacar.mechanism.mechanism import Batch, Drive, DriveState, Loads, Polynomial, SolverSettings, Start, UserSignal
from spacar.mechanism.numbering import Numbering

STARTS = "STARTDX", "STARTDE"

def loads(deck: Deck, numbering: Numbering, batches: list[Batch], prefix: str = "", kind: type = float) -> Loads:
    """Initial loads (prefix empty) or their increments (prefix DEL): XF, GRAVITY, ESIG, mass flow.

    Three numbers on a spatial orientation node are a global moment, four the forces dual to lambda
    (input-language.md section 5.2).
    """
    force: Array = np.zeros(numbering.nx, kind)
    moments, rows = [], []
    for s in deck.of(f"{prefix}XF", block=2):
        node, values = int(s.values[0]), [number(v) for v in s.values[1:]]
        spatial_orientation = not numbering.planar and numbering.kind[node] == "orientation"
        if spatial_orientation and len(values) == 3:
            moments.append(values)
            rows.append(numbering.lnp[node - 1] - 1)
        else:
            size = int(np.count_nonzero(numbering.lnp[node - 1]))
            for coordinate, value in enumerate(values[:size], 1):
                force[numbering.x_index(node, coordinate)] += value
    dimension = 2 if numbering.planar else 3
    gravity: Array = np.zeros(dimension, kind)
    for s in deck.of("GRAVITY" if not prefix else "DELGRAV", block=2):
        given = [number(v) for v in s.values[:dimension]]
        gravity[: len(given)] = given
    preload: Array = np.zeros(numbering.ne, kind)
    for s in deck.of(f"{prefix}ESIG", block=2):
        for mode, stress in enumerate(s.values[1:], 1):
            preload[numbering.e_index(int(s.values[0]), mode)] = number(stress)
    if prefix:
        flow = {int(s.values[0]): number(s.values[1]) for s in deck.of("DELOMF", block=2)}
    else:
        tubes = {n for n, k, _ in numbering.elements if ELEMENT_TYPES[k].carries_flow}
        flow = {
            int(s.values[0]): number(s.values[3])
            for s in deck.of("EM", block=2)
            if int(s.values[0]) in tubes and len(s.values) > 3
        }
    return Loads(
        force=force,
        moment=np.array(moments, kind).reshape(-1, 3),
        moment_rows=np.array(rows, np.int64).reshape(-1, 4).T,
        gravity=gravity,
        preload=preload,
        flow=flow,
    )


def drive(deck: Deck, numbering: Numbering, x0: Array) -> Drive:
    """Prescribed motion: the polynomials of INPUTX and INPUTE, overridden by USERINP for the inputs that it gives."""
    polynomial = Polynomial(*_given(deck, numbering, x0, "input", ("INPUTX", "INPUTE"), 3))
    user = deck.last("USERINP", block=2)
    if user is None:
        return polynomial
    from spacar.mechanism.user_functions import UserDrive

    return UserDrive.load(deck, user, numbering, polynomial, settings(deck))


def user_signal(deck: Deck, numbering: Numbering) -> UserSignal | None:
    """The function of USERSIG, wrapped."""
    statement = deck.last("USERSIG", block=2)
    if statement is None:
        return None
    from spacar.mechanism.user_functions import load_user_signal

    return load_user_signal(deck, statement, numbering)


def start(deck: Deck, numbering: Numbering, x0: Array) -> Start:
    """Start values and rates of dynamic degrees of freedom, start values of kinematic ones (STARTDX, STARTDE)."""
    xm, em = _given(deck, numbering, x0, "dynamic", STARTS, 2)
    xk, ek = _given(deck, numbering, x0, "kinematic", STARTS, 1, np.nan)
    return Start(xm[:, 0], xm[:, 1], em[:, 0], em[:, 1], xk[:, 0], ek[:, 0])


def _given(
    deck: Deck, numbering: Numbering, x0: Array, name: str, keywords: tuple[str, str], width: int, e_value: float = 0.0
) -> tuple[Array, Array]:
    """What statements `node coordinate values` and `element mode values` give to a class, (n, width) each.

    Without a statement: the reference configuration, deformations `e_value`, zero rates.
    """
    places, finds = (numbering.x_class[name], numbering.e_class[name]), (numbering.x_index, numbering.e_index)
    x, e = (np.zeros((rows.stop - rows.start, width), x0.dtype) for rows in places)
    x[:, 0], e[:, 0] = x0[places[0]], e_value
    for keyword, table, rows, find in zip(keywords, (x, e), places, finds, strict=True):
        if not len(table):
            continue
        for s in deck.of(keyword, block=2):
            i = find(s.integer(0), s.integer(1))
            if rows.start <= i < rows.stop:
                values = [number(v) for v in s.values[2 : 2 + width]]
                table[i - rows.start, : len(values)] = values
    return x, e


def additional_drive(deck: Deck, numbering: Numbering, kind: type = float) -> DriveState | None:
    """Total increments of the start values (DELINPX, DELINPE), or None without any."""
    statements = deck.of("DELINPX", "DELINPE", block=2)
    if not statements:
        return None
    xr, er = numbering.x_class["input"], numbering.e_class["input"]
    x, e = np.zeros(xr.stop - xr.start, kind), np.zeros(er.stop - er.start, kind)
    for s in statements:
        a, b, value = int(s.values[0]), int(s.values[1]), number(s.values[2])
        if s.keyword == "DELINPX":
            x[numbering.x_index(a, b) - xr.start] = value
        else:
            e[numbering.e_index(a, b) - er.start] = value
    return DriveState(x, 0 * x, 0 * x, e, 0 * e, 0 * e)


def settings(deck: Deck, **options: Any) -> SolverSettings:
    """TIMESTEP, INTEGRAT, ERROR, ITERSTEP, OUTLEVEL, MODES with defaults (input-language.md sections 4.2, 5.4, 5.5).

    options   fields that replace them; None: none
    """
    names = {
        "TIMESTEP": ("duration", "n_steps"),
        "INTEGRAT": ("integrator", "step"),
        "ERROR": ("atol", "rtol"),
        "ITERSTEP": (
            "max_iterations", "load_steps", "tolerance", "store_every", "stationary_type", "initial_steps",
            "follow_path",
        ),
        "OUTLEVEL": ("log_level", "sbd_level"),
        "MODES": ("modes",),
    }  # fmt: skip
    found: dict[str, Any] = {}
    for keyword, fields in names.items():
        statement = deck.last(keyword)
        if statement is not None:
            found.update(zip(fields, statement.values, strict=False))
    if "integrator" in found:
        found["integrator"] = INTEGRATOR_ALIASES.get(found["integrator"], found["integrator"])
    found.update((name, value) for name, value in options.items() if value is not None)
    return SolverSettings(**found)
