"""Source text of a program in Python, C, Fortran and LaTeX."""

from collections.abc import Callable
from importlib import import_module

from spacar.errors import UsageError
from spacar.symbolic.emit.scalars import header
from spacar.symbolic.name_rules import check_names
from spacar.symbolic.ordered import OrderedProgram

LANGUAGES = {"python": ".py", "c": ".c", "fortran": ".f90", "latex": ".tex"}
"""Languages and the endings of their files."""


def emit(program: OrderedProgram, language: str, jacobian: bool = False, headed: bool = True) -> str:
    """Self-contained source text; `headed` with what the file says about itself, for files that are exported.

    Text that this process executes or compiles has no header: it holds names and numbers only. UsageError for an
    unknown language, a Jacobian where none is written, or a name that a program cannot have.
    """
    if language not in LANGUAGES:
        raise UsageError(f"unknown language {language!r}: choose one of {', '.join(LANGUAGES)}")
    if jacobian and language == "latex":
        raise UsageError("a Jacobian is written in python, c and fortran, not in latex")
    check_names(program)
    source: Callable[..., str] = import_module(f"spacar.symbolic.emit.{language}").source
    return source(program, jacobian, header(program) if headed else [])
