"""The files of user functions beside the input file: found, listed without running them, loaded.

What their functions are asked and answer is in `user_functions`. A missing file or function raises InputError.

A file is read for every model. The code made of its text is kept in the process for a few files, as an import keeps it:
the very same bytes at the same place are not compiled again. They are executed again, in a module of its own.
"""

import ast
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from hashlib import sha256
from os.path import exists
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

import numpy as np

from spacar.deck import Deck, Statement
from spacar.errors import BY_USERS, InputError, Message, type_and_text

STATEMENTS = {"USERSIG": "forces and stresses", "USERINP": "prescribed motion", "USERTRAJ": "trajectory"}


def function_file(deck: Deck, statement: Statement) -> Path:
    """The file `name.py` in the directory of the input file; nothing of it is run. Raises InputError without one."""
    name = str(statement.values[0])
    folder = deck.path.parent if deck.path else Path.cwd()
    for spelled in (name, name.lower()):
        path = folder / f"{spelled}.py"
        if exists(path):  # `Path.exists` raises where it may not look
            return path
    text = f"the function file {name}.py was not found in {folder.resolve()}"
    if exists(folder / f"{name}.m"):
        text += f"; {name}.m is there: write it in Python{_head(folder / f'{name}.m')}"
        text += f" (`spacar keywords {statement.keyword}`)"
    raise _refusal(deck, statement, text)


def model_digest(deck: Deck) -> str:
    """SHA-256 of the input file, and of the function files that it names. Raises InputError without one."""
    files = [function_file(deck, statement).read_bytes() for statement in deck.of(*STATEMENTS)]
    return sha256(b"".join((deck.data, *files))).hexdigest() if files else deck.sha256


def _head(path: Path) -> str:
    """The head of an M-file, and its end, as Python has them; nothing where there is none."""
    try:
        text = path.read_text("utf-8", "replace")
    except OSError:
        return ""
    found = re.search(r"^\s*function\s+\[?([\w\s,]+?)\]?\s*=\s*(\w+)\s*\(([\w\s,~]*)\)", text, re.MULTILINE)
    if found is None:
        return ""
    results, arguments = (", ".join(re.findall(r"\w+", part)) for part in found.group(1, 3))
    return f": `def {path.stem}({arguments}):` and at its end `return {results}`, indices from 0"


def listed_functions(deck: Deck) -> list[Message]:
    """What user functions the runs of a deck will call, found without importing them. InputError without a file."""
    found = []
    for statement in deck.of(*STATEMENTS):
        path = function_file(deck, statement)
        what = f"runs of this model execute {path} ({STATEMENTS[statement.keyword]}); it was not executed here"
        found.append(
            Message("information", deck.source, statement.line, statement.keyword, what, "user-function.listed")
        )
        if not _defines(path, {path.stem, str(statement.values[0])}):
            text = f"{path} does not seem to define a function {statement.values[0]}"
            found.append(Message("warning", deck.source, statement.line, statement.keyword, text, "user-function.name"))
    return found


def without_functions(deck: Deck) -> Deck:
    """The deck without the statements that name user functions: building it imports nothing."""
    return replace(deck, statements=tuple(s for s in deck.statements if s.keyword not in STATEMENTS))


def _defines(path: Path, names: set[str]) -> bool:
    """Whether the text of a file gives one of these names a value at its top level; true when it cannot be read."""
    try:
        body = ast.parse(path.read_bytes()).body
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        return True
    defined = {node.name for node in body if isinstance(node, (ast.FunctionDef, ast.ClassDef))}
    names_given = (n for node in body for n in ast.walk(node) if isinstance(n, ast.Name))
    defined |= {n.id for n in names_given if isinstance(n.ctx, ast.Store)}
    imports = [node for node in body if isinstance(node, (ast.Import, ast.ImportFrom))]
    defined |= {a.asname or a.name for node in imports for a in node.names}
    return bool(defined & names) or "*" in defined


def _refusal(deck: Deck, statement: Statement, reason: str) -> InputError:
    return InputError([Message("error", deck.source, statement.line, statement.keyword, reason, "input.user-function")])


@dataclass(frozen=True, eq=False)
class Loaded:
    """A function made from a user's file. No module is known under its name, so it travels (pickle, copy) as the
    statement that names it, and is loaded again where it arrives.

    breaks  times at which it jumps [s], from `breaks` of its module
    code    what was executed, of the text at `path`
    """

    function: Callable[..., Any]
    breaks: tuple[float, ...]
    deck: Deck
    statement: Statement
    path: Path
    code: CodeType

    def __call__(self, *arguments: Any) -> Any:
        return self.function(*arguments)

    def __reduce__(self) -> "tuple[Callable[..., Loaded], tuple[Any, ...]]":
        return load_function, (self.deck, self.statement)

    def anew(self) -> "Loaded":
        """It once more, from the text that was read, in a module of its own. Raises as `load_function`."""
        return _made(self.deck, self.statement, self.path, self.code)


def load_function(deck: Deck, statement: Statement) -> Loaded:
    """The function `name` of `name.py` in the directory of the input file."""
    refuse = partial(_refusal, deck, statement)
    path = function_file(deck, statement)
    return _made(deck, statement, path, _compiled(path, refuse))


def _made(deck: Deck, statement: Statement, path: Path, code: CodeType) -> Loaded:
    refuse, name = partial(_refusal, deck, statement), str(statement.values[0])
    own = vars(_executed(code, path, refuse))
    function = own.get(path.stem) or own.get(name)
    if not callable(function):
        raise refuse(f"{path} does not define a function {name}")
    breaks = _breaks(own["breaks"], path, refuse) if "breaks" in own else ()
    return Loaded(function, breaks, deck, statement, path, code)


def _breaks(given: Any, path: Path, refuse: Callable[[str], Exception]) -> tuple[float, ...]:
    try:
        times = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        times = np.full((1, 1), np.nan)
    if times.ndim != 1 or not np.isfinite(times).all():
        text = repr(given).splitlines()[0]
        text = text if len(text) < 80 else f"{text[:77]}..."
        raise refuse(f"breaks of {path} must be a list of times [s], numbers, not {text}")
    return tuple(float(t) for t in times)


def import_file(path: Path, refuse: Callable[[str], Exception]) -> ModuleType:
    """The module in a user's Python file, from its text as it stands now: no bytecode is kept beside a model. Raises
    what `refuse` makes of the reason why it cannot be loaded."""
    return _executed(_compiled(path, refuse), path, refuse)


@contextmanager
def _loading(path: Path, refuse: Callable[[str], Exception]) -> Iterator[None]:
    """A user's file may fail in any way."""
    try:
        yield
    except BY_USERS as error:
        raise refuse(f"{path} cannot be loaded: {type_and_text(error)}") from error


def _compiled(path: Path, refuse: Callable[[str], Exception]) -> CodeType:
    with _loading(path, refuse):
        return _code(path.read_bytes(), str(path))


_code = lru_cache(16)(partial(compile, mode="exec", dont_inherit=True))


def _executed(code: CodeType, path: Path, refuse: Callable[[str], Exception]) -> ModuleType:
    module = ModuleType(f"spacar_user_{path.stem}")
    module.__file__ = str(path)
    with _loading(path, refuse):
        exec(code, vars(module))
    return module
