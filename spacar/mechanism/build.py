"""Assemble the Mechanism: read the classes and the start configuration from the deck, number, and gather the parts."""

from __future__ import annotations

from dataclasses import replace
from math import hypot
from typing import Any

import numpy as np

from spacar.arrays import Array, Index
from spacar.deck import ELEMENT_TYPES, Deck, coordinates_of
from spacar.deck.statement import number as real_number
from spacar.errors import InputError, Message
from spacar.mechanism import inputs, lumped_inertia
from spacar.mechanism.element_batches import element_batches, node_batches
from spacar.mechanism.layout import Batch
from spacar.mechanism.mechanism import Mechanism, Start
from spacar.mechanism.numbering import Numbering, number
from spacar.modes import find_mode

X_STATEMENTS = {"FIX": "fixed", "INPUTX": "input", "DYNX": "dynamic", "KINX": "kinematic"}
NO_ENTRIES = np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0)  # rows, columns, values
E_STATEMENTS = {"RLSE": "calculable", "INPUTE": "input", "DYNE": "dynamic", "KINE": "kinematic"}


def build(deck: Deck, mode: int = 1, **options: Any) -> Mechanism:
    """Mechanism of a checked deck. `options` override Settings fields. Raises InputError for impossible geometry."""
    analysis = find_mode(mode)
    if not analysis.forces:  # errors of the dynamics block are only warnings here: take nothing from it
        deck = replace(deck, statements=tuple(s for s in deck.statements if s.block == 1))
    elements = element_list(deck)
    if not elements:
        raise InputError([Message("error", deck.source, None, "", "the model has no elements")])
    x_class, e_class = classes(deck, elements)
    if analysis.takes_setpoints:
        # all degrees of freedom follow the nominal motion; the file may call them dynamic (files.md section 3)
        x_class, e_class = _prescribed(x_class), _prescribed(e_class)
    numbering = number(elements, x_class, e_class)
    x0 = reference_configuration(deck, numbering)
    batches = element_batches(deck, numbering, x0, options.get("beams") or "")
    batches += node_batches(numbering, lumped_inertia.lumped(deck, numbering, batches))
    loads = inputs.loads(deck, numbering, batches)
    levels = analysis.stationary or analysis.takes_setpoints  # load steps: they are computed, or linearized about
    stiffness, damping = _constitutive(batches) if deck.of("ESTIFF", "EDAMP", block=2) else (NO_ENTRIES, NO_ENTRIES)
    return Mechanism(
        deck=deck,
        numbering=numbering,
        x0=x0,
        batches=tuple(batches),
        loads=loads,
        additional=inputs.loads(deck, numbering, batches, "DEL") if levels else None,
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
    batches = element_batches(deck, n, x0, mechanism.settings.beams)
    batches += node_batches(n, lumped_inertia.lumped(deck, n, batches))
    additional = mechanism.additional is not None
    return replace(
        mechanism,
        deck=deck,
        x0=x0,
        batches=tuple(batches),
        loads=inputs.loads(deck, n, batches, kind=complex),
        additional=inputs.loads(deck, n, batches, "DEL", kind=complex) if additional else None,
        additional_drive=inputs.additional_drive(deck, n, complex),
        drive=inputs.drive(deck, n, x0),
        start=inputs.start(deck, n, x0),
        deformation_inertia=lumped_inertia.deformation_inertia(deck, n),
    )


def _prescribed(classes: dict[tuple[int, int], str]) -> dict[tuple[int, int], str]:
    return {key: "input" if name == "dynamic" else name for key, name in classes.items()}


def element_list(deck: Deck) -> list[tuple[int, str, tuple[int, ...]]]:
    """(number, keyword, nodes) of every element statement."""
    return [
        (int(s.values[0]), s.keyword, tuple(int(v) for v in s.values[1 : 1 + len(ELEMENT_TYPES[s.keyword].nodes)]))
        for s in deck.of(*ELEMENT_TYPES, block=1)
    ]


def classes(
    deck: Deck, elements: list[tuple[int, str, tuple[int, ...]]]
) -> tuple[dict[tuple[int, int], str], dict[tuple[int, int], str]]:
    """Classes of coordinates and deformations that statements give (input-language.md section 4.2, notes k5, k6), and
    those that differ from the defaults without a statement: warping coordinates are dynamic, the deformations that
    belong to them calculable (theory-warping.md section 1)."""
    kinds = {n: role for _, k, nodes in elements for n, role in zip(nodes, ELEMENT_TYPES[k].nodes, strict=True)}
    keyword = {n: k for n, k, _ in elements}
    planar = ELEMENT_TYPES[elements[0][1]].planar
    independent = {role: tuple(range(1, 1 + coordinates_of(role, planar))) for role in set(kinds.values())}
    if not planar:
        independent["orientation"] = (2, 3, 4)  # lambda0 follows from the normalization
    x_class: dict[tuple[int, int], str] = {}
    for s in deck.of(*X_STATEMENTS, block=1):
        node, *which = (int(v) for v in s.values)
        if node in kinds:
            for coordinate in which or independent[kinds[node]]:
                x_class[node, coordinate] = X_STATEMENTS[s.keyword]
    for node, role in kinds.items():
        if role == "warping":
            x_class.setdefault((node, 1), "dynamic")
    e_class: dict[tuple[int, int], str] = {}
    for s in deck.of(*E_STATEMENTS, block=1):
        element, *which = (int(v) for v in s.values)
        for mode in which or ELEMENT_TYPES[keyword[element]].classed:
            e_class[element, mode] = E_STATEMENTS[s.keyword]
    for element, word, _ in elements:
        e_class.update({(element, mode): "calculable" for mode in ELEMENT_TYPES[word].released})
    return x_class, e_class


def reference_configuration(deck: Deck, numbering: Numbering, kind: type = float) -> Array:
    """Positions of X, zero angles, Euler parameters (1, 0, 0, 0)."""
    x0: Array = np.zeros(numbering.nx, kind)
    if len(numbering.normalization):
        x0[numbering.lnp[numbering.normalization[:, 0] - 1, 0] - 1] = 1.0
    for s in deck.of("X", block=1):
        node, *values = s.values
        if node in numbering.kind:
            places = numbering.lnp[int(node) - 1].tolist()
            for place, value in zip(filter(None, places), values, strict=False):
                x0[place - 1] = real_number(value)
    return x0


def _size(numbering: Numbering, x0: Array) -> float:
    """Diagonal of the box around all position nodes; 1 when there are none."""
    if len(numbering.positions) < 2:
        return 1.0
    places = x0[numbering.positions].real
    extent = hypot(*(places.max(0) - places.min(0)))
    return extent if extent > 0.0 else 1.0


def _constitutive(batches: list[Batch]) -> list[tuple[Index, Index, Array]]:
    """Non-zero entries of S and of S_d of all elements as rows, columns, values."""
    found: tuple[list[Any], list[Any]] = ([], [])
    for batch in batches:
        if batch.family.n_deformations:
            for parts, S in zip(found, batch.family.stiffness(), strict=True):
                i, j, k = np.nonzero(S)
                if len(i):
                    parts.append((batch.e[i, k], batch.e[j, k], S[i, j, k]))
    return [tuple(map(np.concatenate, zip(*parts, strict=True))) if parts else NO_ENTRIES for parts in found]  # type: ignore
