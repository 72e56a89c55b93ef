"""Source text of a program in Python, C, Fortran and LaTeX."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from spacar.errors import UsageError

if TYPE_CHECKING:
    from spacar.symbolic.program import Program

LANGUAGES = {"python": ".py", "c": ".c", "fortran": ".f90", "latex": ".tex"}
"""Languages and the endings of their files."""


def emit(program: Program, language: str, jacobian: bool = False) -> str:
    """Self-contained source text. UsageError for an unknown language, or a Jacobian where none is written."""
    if language not in LANGUAGES:
        raise UsageError(f"unknown language {language!r}: choose one of {', '.join(LANGUAGES)}")
    if jacobian and language not in ("python", "c"):
        raise UsageError(f"a Jacobian is written in python and c, not in {language}")
    text: str = import_module(f"spacar.symbolic.emit.{language}").source(program, jacobian)
    return text
