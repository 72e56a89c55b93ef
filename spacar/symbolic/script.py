"""A model as a small Python script: it defines `system` and may define values, start, settings and outputs.

A script is a program of the user and runs as such. A TOML file runs nothing: only names and numbers that
`name_rules.py` checked enter text that is executed or compiled.
"""

import hashlib
import runpy
from dataclasses import dataclass, field
from pathlib import Path
from traceback import extract_tb
from typing import Any

import sympy as sp

from spacar.errors import BY_USERS, InputError, Message, SpacarError, type_and_text
from spacar.symbolic.system import MultibodySystem


@dataclass(frozen=True, eq=False)
class SymbolicModel:
    """A system with what a simulation needs: parameter `values`, `start`, `settings` of [simulate], `outputs`.

    `sha256` is that of the file when it was read.
    """

    path: Path
    system: MultibodySystem
    values: dict[str, float] = field(default_factory=dict)
    start: dict[str, float] = field(default_factory=dict)
    settings: dict[str, Any] = field(default_factory=dict)
    outputs: dict[str, sp.Expr] = field(default_factory=dict)
    declared: frozenset[str] = frozenset()
    sha256: str = ""


def read_script(path: Path) -> SymbolicModel:
    """Run the script; errors of any kind become one message with the line. Raises InputError."""
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    try:
        names = runpy.run_path(str(path), run_name="spacar_model")
    except SpacarError as error:
        raise InputError([Message("error", path.name, None, "", str(error))]) from None
    except BY_USERS as error:
        calls = extract_tb(error.__traceback__)
        line = next((call.lineno for call in reversed(calls) if call.filename == str(path)), None)
        raise InputError([Message("error", path.name, line, "", type_and_text(error))]) from None
    system = names.get("system")
    if not isinstance(system, MultibodySystem):
        text = "the script must define `system`, a spacar.symbolic.MultibodySystem"
        raise InputError([Message("error", path.name, None, "", text)])
    values, start, settings, outputs = (
        dict(names.get(key) or {}) for key in ("values", "start", "settings", "outputs")
    )
    return SymbolicModel(path, system, values, start, settings, outputs, sha256=digest)
