"""Loads, prescribed motion, start values and settings of the dynamics block."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import Deck
from spacar.deck.table_solvers import INTEGRATOR_ALIASES
from spacar.mechanism.mechanism import Drive, DriveState, Loads, Polynomial, SolverSettings, Start, UserSignal
from spacar.mechanism.numbering import Numbering

STARTS = "STARTDX", "STARTDE"
SETTINGS = {
    "TIMESTEP": ("duration", "n_steps"), "INTEGRAT": ("integrator", "step"), "ERROR": ("atol", "rtol"),
    "ITERSTEP": (
        "max_iterations", "load_steps", "tolerance", "store_every", "stationary_type", "initial_steps", "follow_path",
    ),
    "OUTLEVEL": ("log_level", "sbd_level"), "MODES": ("modes",),
}  # fmt: skip


def applied(rows: Iterable[Sequence[Any]], numbering: Numbering, kind: type = float) -> tuple[Array, Array, Index]:
    """Forces (nx,), global moments (n, 3) and their lambda rows (4, n) of XF, rows of a node and its numbers.

    Three numbers on a spatial orientation node are a global moment, four the forces dual to lambda
    (input-language.md section 5.2).
    """
    force: Array = np.zeros(numbering.nx, kind)
    moments, turned = [], []
    for node, *values in rows:
        row = numbering.x_places[node]
        if len(values) == 3 and not numbering.planar and numbering.role(node) == "orientation":
            moments.append(values)
            turned.append(row)
        else:
            for place, value in zip(row.tolist(), values, strict=False):
                if place >= 0:
                    force[place] += value
    if not moments:
        return force, np.zeros((0, 3), kind), np.zeros((4, 0), np.int64)
    return force, np.array(moments, kind), np.array(turned).T


def loads(deck: Deck, numbering: Numbering, prefix: str = "", kind: type = float) -> Loads:
    """Initial loads (prefix empty) or their increments (prefix DEL): XF, GRAVITY, ESIG, mass flow."""
    index, dimension = deck.index, 2 if numbering.planar else 3
    gravity: Array = np.zeros(dimension, kind)
    preload: Array = np.zeros(numbering.ne, kind)
    for given in index.rows("DELGRAV" if prefix else "GRAVITY", 2):
        given = given[:dimension]
        gravity[: len(given)] = given
    for number, *values in index.rows(f"{prefix}ESIG", 2):
        for place, value in zip(numbering.e_places[number].tolist(), values, strict=False):
            preload[place] = value
    forces = applied(index.rows(f"{prefix}XF", 2), numbering, kind)
    return Loads(*forces, gravity, preload, _flow(deck, numbering, prefix))


def _flow(deck: Deck, numbering: Numbering, prefix: str) -> dict[int, float]:
    if prefix:
        return {s.integer(0): s.real(1) for s in deck.of("DELOMF", block=2)}
    tubes = {n for rows in numbering.types if rows.kind.carries_flow for n in rows.numbers.tolist()}
    if not tubes:
        return {}
    return {s.integer(0): s.real(3) for s in deck.of("EM", block=2) if s.integer(0) in tubes and len(s.values) > 3}


def drive(deck: Deck, numbering: Numbering, x0: Array) -> Drive:
    """Prescribed motion: the polynomials of INPUTX and INPUTE, overridden by USERINP for the inputs that it gives."""
    x, e = _given(deck, numbering, x0, "input", ("INPUTX", "INPUTE"), 3)
    polynomial = Polynomial(x, e)
    given = deck.block(2).get("USERINP")
    if not given:
        return polynomial
    from spacar.mechanism.user_functions import UserDrive

    run = settings(deck)
    interval = run.duration / run.n_steps if run.duration and run.n_steps else 1.0
    return UserDrive.load(deck, given[-1], numbering, polynomial, interval)


def user_signal(deck: Deck, numbering: Numbering) -> UserSignal | None:
    given = deck.block(2).get("USERSIG")
    if not given:
        return None
    from spacar.mechanism.user_functions import load_user_signal

    return load_user_signal(deck, given[-1], numbering)


def start(deck: Deck, numbering: Numbering, x0: Array) -> Start:
    """Start values and rates of dynamic degrees of freedom, start values of kinematic ones (STARTDX, STARTDE)."""
    xm, em = _given(deck, numbering, x0, "dynamic", STARTS, 2)
    xk, ek = _given(deck, numbering, x0, "kinematic", STARTS, 1, np.nan)
    return Start(xm[:, 0], xm[:, 1], em[:, 0], em[:, 1], xk[:, 0], ek[:, 0])


def _given(
    deck: Deck, numbering: Numbering, x0: Array, name: str, keywords: tuple[str, str], width: int, e_value: float = 0.0
) -> list[Array]:
    """What statements `node coordinate values` and `element mode values` give to a class, (n, width) each.

    Without a statement: the reference configuration, deformations `e_value`, zero rates.
    """
    tables = []
    for keyword, of, places, before in (
        (keywords[0], numbering.x_class[name], numbering.x_places, x0[numbering.x_class[name]]),
        (keywords[1], numbering.e_class[name], numbering.e_places, e_value),
    ):
        table: Array = np.zeros((of.stop - of.start, width), x0.dtype)
        table[:, 0] = before
        for number, part, *values in deck.index.rows(keyword, 2) if len(table) else ():
            row = places.item(number, part - 1) - of.start
            if 0 <= row < len(table):
                values = values[:width]
                table[row, : len(values)] = values
        tables.append(table)
    return tables


def additional_drive(deck: Deck, numbering: Numbering, kind: type = float) -> DriveState | None:
    """Total increments of the start values (DELINPX, DELINPE), or None without any."""
    if deck.block(2).keys().isdisjoint(("DELINPX", "DELINPE")):
        return None
    zero: Array = np.zeros(numbering.nx, kind)
    x, e = (table[:, 0] for table in _given(deck, numbering, zero, "input", ("DELINPX", "DELINPE"), 1))
    return DriveState(x, 0 * x, 0 * x, e, 0 * e, 0 * e)


def settings(deck: Deck, **options: Any) -> SolverSettings:
    """TIMESTEP, INTEGRAT, ERROR, ITERSTEP, OUTLEVEL, MODES with defaults (input-language.md sections 4.2, 5.4, 5.5).

    options   fields that replace them; None: none
    """
    found: dict[str, Any] = {}
    for block in (deck.block(1), deck.block(2)):
        for keyword in SETTINGS.keys() & block.keys():
            found.update(zip(SETTINGS[keyword], block[keyword][-1].values, strict=False))
    if "integrator" in found:
        found["integrator"] = INTEGRATOR_ALIASES.get(found["integrator"], found["integrator"])
    found.update((name, value) for name, value in options.items() if value is not None)
    return SolverSettings(**found)
