"""Assemble the Mechanism: number, read the start configuration from the deck, and gather the parts."""

from dataclasses import replace
from math import hypot
from typing import Any

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import Deck
from spacar.errors import InputError, Message
from spacar.mechanism import inputs, lumped_inertia
from spacar.mechanism.element_batches import element_batches, node_batches
from spacar.mechanism.element_rows import element_rows, value_rows
from spacar.mechanism.layout import Batch
from spacar.mechanism.mechanism import NO_ENTRIES, Mechanism, Start
from spacar.mechanism.numbering import Numbering, number
from spacar.modes import find_mode


def build(deck: Deck, mode: int = 1, **options: Any) -> Mechanism:
    """Mechanism of a checked deck. `options` override Settings fields. Raises InputError for impossible geometry."""
    analysis = find_mode(mode)
    if not analysis.forces:  # errors of the dynamics block are only warnings here: take nothing from it
        deck = replace(deck, statements=tuple(s for s in deck.statements if s.block == 1))
    types = element_rows(deck)
    if not types:
        raise InputError([Message("error", deck.source, None, "", "the model has no elements")])
    # along set-points all degrees of freedom follow them; the file may call them dynamic (files.md section 3)
    numbering = number(deck, types, prescribed=analysis.takes_setpoints)
    x0 = reference_configuration(deck, numbering)
    batches = element_batches(deck, numbering, x0, options.get("beams") or "")
    node_batches(batches, numbering, lumped_inertia.lumped(deck, numbering, batches))
    loads = inputs.loads(deck, numbering)
    levels = analysis.stationary or analysis.takes_setpoints  # load steps: they are computed, or linearized about
    stiffness, damping = _constitutive(batches)
    return Mechanism(
        deck=deck,
        numbering=numbering,
        x0=x0,
        batches=tuple(batches),
        loads=loads,
        additional=inputs.loads(deck, numbering, "DEL") if levels else None,
        additional_drive=inputs.additional_drive(deck, numbering),
        drive=inputs.drive(deck, numbering, x0),
        start=inputs.start(deck, numbering, x0) if not analysis.takes_setpoints else Start(*6 * (np.zeros(0),)),
        user_signal=inputs.user_signal(deck, numbering),
        deformation_inertia=lumped_inertia.deformation_inertia(deck, numbering),
        stiffness=stiffness,
        damping=damping,
        settings=inputs.settings(deck, **options),
        length=_size(numbering, x0),
    )


def along(mechanism: Mechanism, deck: Deck) -> Mechanism:
    """The mechanism with the numbers of a deck that differs by a direction (`spacar.deck.directed`): complex arrays,
    in the numbering of the real one. For the derivatives of element quantities; no analysis runs on it: `stiffness` and
    `damping` stay the real ones."""
    n = mechanism.numbering
    x0 = reference_configuration(deck, n, complex)
    batches = element_batches(deck, replace(n, types=tuple(element_rows(deck))), x0, mechanism.settings.beams)
    node_batches(batches, n, lumped_inertia.lumped(deck, n, batches))
    additional = mechanism.additional is not None
    return replace(
        mechanism, deck=deck, x0=x0, batches=tuple(batches), loads=inputs.loads(deck, n, kind=complex),
        additional=inputs.loads(deck, n, "DEL", kind=complex) if additional else None,
        additional_drive=inputs.additional_drive(deck, n, complex), drive=inputs.drive(deck, n, x0),
        start=inputs.start(deck, n, x0), deformation_inertia=lumped_inertia.deformation_inertia(deck, n),
    )  # fmt: skip


def reference_configuration(deck: Deck, numbering: Numbering, kind: type = float) -> Array:
    """Positions of X, zero angles, Euler parameters (1, 0, 0, 0)."""
    x0: Array = np.zeros(numbering.nx, kind)
    if len(numbering.turning):
        x0.put(numbering.euler[0], 1.0)
    for nodes, values in value_rows(deck, "X", 1, kind):
        x0.put(numbering.x_places.take(nodes, 0)[:, : values.shape[1]], values)
    return x0


def _size(numbering: Numbering, x0: Array) -> float:
    """Diagonal of the box around all position nodes; 1 when there are none."""
    extent = hypot(*np.ptp(x0.real.take(numbering.positions), 0)) if len(numbering.positions) else 0.0
    return extent if extent > 0.0 else 1.0


def _constitutive(batches: list[Batch]) -> list[tuple[Index, Index, Array]]:
    """Non-zero entries of S and of S_d of all elements as rows, columns, values."""
    found = [NO_ENTRIES], [NO_ENTRIES]
    for batch in batches:
        if batch.family.n_deformations:
            for parts, S in zip(found, batch.family.constitutive, strict=True):
                if np.count_nonzero(S):
                    places, m = S.ravel().nonzero()[0], len(S)
                    rows, columns = batch.e.repeat(m, 0), batch.e[None].repeat(m, 0)
                    parts.append((rows.take(places), columns.take(places), S.take(places)))
    each = (zip(*parts, strict=True) for parts in found)
    return [(np.concatenate(rows), np.concatenate(columns), np.concatenate(values)) for rows, columns, values in each]
