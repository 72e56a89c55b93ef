"""What a deck and a result print of themselves in Python: ten lines, not all of their numbers."""

from __future__ import annotations

from collections import Counter
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.deck import ELEMENT_TYPES
from spacar.errors import SpacarError
from spacar.modes import find_mode

if TYPE_CHECKING:
    from spacar.deck import Deck
    from spacar.result import Result

MOST = 6  # numbers in a line
LINES = 10
DRAWING = "spacar_drawing"  # named, not imported: pictures lie above the core


def with_picture(text: str, maker: str, thing: Any) -> str:
    """HTML of a text, and the picture that a function of the drawing package makes of a thing, if it can."""
    from html import escape

    page = f'<pre style="font-family: monospace">{escape(text)}</pre>'
    try:
        return page + str(getattr(import_module(DRAWING), maker)(thing))
    except (ImportError, SpacarError):  # no matplotlib, or nothing that could be drawn
        return page


def deck_summary(deck: Deck) -> str:
    """Name, mode, elements, what each block holds, messages."""
    elements = Counter(s.keyword for s in deck.statements if s.keyword in ELEMENT_TYPES)
    purpose = "all modes" if deck.mode is None else f"mode {deck.mode}"
    lines = [f"Deck {deck.source}, checked for {purpose}", f"  elements    {_counted(elements)}"]
    for block, name in ((1, "kinematics"), (2, "dynamics"), (3, "third")):
        rest = Counter(s.keyword for s in deck.statements if s.block == block and s.keyword not in ELEMENT_TYPES)
        if rest:
            lines.append(f"  {name:<11} {_counted(rest)}")
    lines += [f"  {message}" for message in deck.messages[: LINES - len(lines)]]
    return "\n".join(lines)


def result_summary(result: Result) -> str:
    """Model, mode, steps, degrees of freedom, frequencies of the last step, warnings."""
    mode, numbering = find_mode(result.mode), result.mechanism.numbering
    n = len(result.frames)
    lines = [f"Result of {result.mechanism.deck.source}, mode {mode.number}: {mode.title}"]
    t = result.t
    span = f", t = {t[0]:.6g} to {t[-1]:.6g}{' s' * mode.timed}" if n > 1 else ""
    lines.append(f"  steps       {n}{span}")
    lines.append(f"  size        {numbering.nx} coordinates x, {numbering.ne} deformations e")
    plural = "s" * (numbering.ndof != 1)
    lines.append(f"  freedom     {numbering.ndof} degree{plural} of freedom, {numbering.nddof} of them dynamic")
    if n and "eigval" in result.frames[-1].matrices:
        lines.append(f"  frequencies {_numbers(result.frequencies[-1])} Hz (last step)")
    if n and "lmult" in result.frames[-1].matrices:
        lines.append(f"  multipliers {_numbers(np.ravel(result['lmult'][-1]))} (last step)")
    if "accuracy" in result.header:
        found, target = result.header["accuracy"], result.header["accuracy"].target
        estimate = f"{found.estimate:.2e} of the amplitudes" if np.isfinite(found.estimate) else "not known"
        lines.append(f"  accuracy    {estimate}" + (f", asked for {target:g}" if target is not None else ""))
    warnings = [line for line in result.report if line.startswith("warning")]
    room = LINES - 1 - len(lines)
    lines += [f"  {line}" for line in warnings[:room]]
    if len(warnings) > room:
        lines[-1] = f"  ... {len(warnings) - room + 1} more warnings in .report"
    lines.append("  result.node(6, 1), .element(1, 1), ['x'], .plot('x[6,1]'), .draw()")
    return "\n".join(lines)


def _counted(found: Counter[str]) -> str:
    words = [f"{n} {name}" if n > 1 else name for name, n in found.most_common()]
    return ", ".join(words[:12]) + (", ..." if len(words) > 12 else "") or "none"


def _numbers(values: np.ndarray) -> str:
    values = values[np.isfinite(values)]
    return ", ".join(f"{v:.6g}" for v in values[:MOST]) + (", ..." if len(values) > MOST else "") or "none"
