"""Which text of a model may go where: the white list between model files and text that is executed or compiled.

Names of parameters, states, inputs, frames, points and bodies are identifiers; outputs and titles are shown, never
executed. Generated text holds names and numbers only; what else a model says about itself stands in the comment
at the top of exported files, with every character that could end a comment or a string written as <U+XXXX>.
"""

import re
import unicodedata
from collections.abc import Iterator
from itertools import chain
from typing import Any

from spacar.errors import UsageError
from spacar.symbolic.ordered import OrderedProgram

LONGEST = 200
OUTPUT = re.compile(r"\w[\w .+\-()\[\]]*")  # also a part of file names: no separators
SHOWN = frozenset(" _.,:;()[]+-=<>'/|")  # beside letters and digits; neither quotes nor backslash nor * nor ?


def is_name(text: str) -> bool:
    """Letters, digits and _, in the form that Python itself gives to a name (NFKC), at most 200 characters."""
    return text.isidentifier() and len(text) <= LONGEST and unicodedata.normalize("NFKC", text) == text


def is_output(text: str) -> bool:
    """Letters, digits, blanks and _ . + - ( ) [ ], beginning with a letter, a digit or _."""
    return OUTPUT.fullmatch(text) is not None and len(text) <= LONGEST


def control_character(value: Any) -> str | None:
    """The first text in nested tables and lists that holds a control character, keys included; None when none does."""
    return next((text for text in _texts(value) if any(map(_is_control, text))), None)


def escaped(text: str) -> str:
    """The text with letters, digits and harmless signs as they are, anything else as <U+XXXX>."""
    return "".join(c if c.isalnum() or c in SHOWN else f"<U+{ord(c):04X}>" for c in text)


def check_names(program: OrderedProgram) -> None:
    """UsageError unless everything that generated text takes from the model is a name."""
    symbols = [*program.parameters, *program.state, *program.inputs]
    symbols += [s for s, _ in (*program.once, *program.step)]
    for s in symbols:
        if not is_name(s.name):
            raise UsageError(f"{s.name!r} is not a name (letters, digits and _) that a program can have", "name")
    for name in program.outputs:
        if not is_output(name):
            raise UsageError(f"{name!r} is not a name for an output (letters, digits, blanks and _.+-()[])", "name")


def _is_control(c: str) -> bool:
    return unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") or unicodedata.bidirectional(c) in BIDIRECTIONAL


BIDIRECTIONAL = ("LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI")
"""Marks that make text look other than it is."""


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, (dict, list)):
        for item in chain(*value.items()) if isinstance(value, dict) else value:
            yield from _texts(item)
