"""Released beam deformations without any stress law: a hinge or a slider in the model, often by mistake.

A warning when a mode of a beam or tube is released (RLSE) and neither ESTIFF, EDAMP nor ESIG gives it a stress,
although the motion can change it. It cannot where all nodes are fixed, or when the fixed deformations determine it
(`self_stress`), as after the cut of a redundant rigid frame. No warning either for measuring elements (a massless beam
with all modes released and no coefficient at all), with USERSIG (its function may give the stress), and for files
without a dynamics block.
"""

import numpy as np

from spacar.deck import ELEMENT_TYPES, Deck
from spacar.errors import Message
from spacar.kinematics.advice import SMALL, coefficient, full_deck
from spacar.kinematics.self_stress import redundancies
from spacar.mechanism.mechanism import Mechanism
from spacar.mechanism.rigid_parts import fixed_nodes

BEAMS = tuple(t.keyword for t in ELEMENT_TYPES.values() if t.shape == "beam")
LARGEST = 1000
"""More fixed deformations are not decomposed (cubic cost); every candidate is then reported."""


def lost_stiffness(deck: Deck, mechanism: Mechanism) -> list[Message]:
    """One warning for every RLSE that takes stiffness away; `deck` is the whole input."""
    found = _candidates(deck)
    if not found:
        return []
    free = _can_change(mechanism, [pair for pairs in found.values() for pair in pairs])
    messages = []
    for place, pairs in found.items():
        modes = [mode for element, mode in pairs if (element, mode) in free]
        if modes:
            statement = deck.statements[place]
            element = statement.integer(0)
            kind = ELEMENT_TYPES[mechanism.numbering.keyword[element]]
            names = ", ".join(f"{m} ({kind.modes[m - 1][0]})" for m in modes)
            text = f"releases mode {names} of a {kind.keyword} without ESTIFF for it: a hinge or slider in the model"
            messages.append(deck.message("warning", statement, text, 0, "input.released-without-stiffness"))
    return messages


def _candidates(deck: Deck) -> dict[int, list[tuple[int, int]]]:
    """Index of every RLSE on a beam -> its (element, mode) without a stress law."""
    keywords = {s.integer(0): s.keyword for s in deck.of(*BEAMS, block=1)}
    releases = [
        (k, s)
        for k, s in enumerate(deck.statements)
        if s.keyword == "RLSE" and s.block == 1 and s.integer(0) in keywords
    ]
    if not releases:
        return {}
    deck = full_deck(deck)
    if deck.of("USERSIG", block=2) or not any(s.block == 2 for s in deck.statements):
        return {}
    if any(m.code == "input.skipped-block" and m.severity == "warning" for m in deck.messages):
        return {}  # mode 0 with a dynamics block that could not be read
    laws = {name: {s.integer(0): s for s in deck.of(name, block=2)} for name in ("ESTIFF", "EDAMP", "ESIG", "EM")}
    modes_of: dict[int, set[int]] = {}
    for _, s in releases:
        modes_of.setdefault(s.integer(0), set()).update(_modes(s.integers(1), keywords[s.integer(0)]))
    found = {}
    for k, s in releases:
        element = s.integer(0)
        keyword = keywords[element]
        whole = len(modes_of[element]) == len(ELEMENT_TYPES[keyword].modes)
        if whole and not any(element in law for law in laws.values()):
            continue  # a measuring element
        stiff, damp, preload = (laws[name].get(element) for name in ("ESTIFF", "EDAMP", "ESIG"))
        pairs = [
            (element, mode)
            for mode in _modes(s.integers(1), keyword)
            if coefficient(stiff, keyword, mode) == 0.0
            and coefficient(damp, keyword, mode) == 0.0
            and (preload is None or preload.real(mode) == 0.0)
        ]
        if pairs:
            found[k] = pairs
    return found


def _modes(given: tuple[int, ...], keyword: str) -> tuple[int, ...]:
    return given or tuple(range(1, len(ELEMENT_TYPES[keyword].modes) + 1))


def _can_change(mechanism: Mechanism, pairs: list[tuple[int, int]]) -> set[tuple[int, int]]:
    """Those of the deformations that the fixed ones leave free, at the reference configuration."""
    n = mechanism.numbering
    fixed, held = np.arange(n.e_class["fixed"].stop), fixed_nodes(n)
    moving = {number for number, _, nodes in n.elements if not held[list(nodes)].all()}
    pairs = [pair for pair in pairs if pair[0] in moving]
    if len(fixed) > LARGEST or not pairs:
        return set(pairs)
    places = [n.e_index(*pair) for pair in pairs]
    held = redundancies(mechanism, np.concatenate((fixed, places)))[len(fixed) :]
    # Motions of the candidates that no redundancy forbids: the columns of `free`. A candidate without a share in any
    # of them is determined by the fixed deformations.
    left, s, _ = np.linalg.svd(held)
    free = left[:, int(np.sum(s > SMALL)) :]
    return {pair for pair, row in zip(pairs, free, strict=True) if np.linalg.norm(row) > SMALL}
