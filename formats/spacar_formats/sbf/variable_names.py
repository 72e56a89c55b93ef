"""Names of variables: identifiers in the file, their MATLAB names, and the message for one that is not there.

Sources: reference/files.md section 4 (table and the rule that both names are accepted), messages.md section 2.
"""

from __future__ import annotations

from collections.abc import Container, Iterable

from spacar.errors import UsageError

MATLAB_NAMES = {"T": "time", "FXT": "fxtot", "RQ": "rxyzq", "KDEF": "kdform", "STIF": "estiff"}
_OTHER = {ident: name.upper() for ident, name in MATLAB_NAMES.items()}
_OTHER |= {name: ident for ident, name in _OTHER.items()}
_TRANSFER = {"DX", "DE", "D2X", "D2E", "DXC", "DEC"}


def matlab_name(ident: str, kind: str = "sbd") -> str:
    """Name of the variable in MATLAB: the table, otherwise small letters; an `.ltv` file uses capitals."""
    name = ident if kind == "ltv" else MATLAB_NAMES.get(ident, ident.lower())
    return name if name[0].isalpha() else "v" + name


def identifier(name: str) -> str:
    """Identifier in the file of a MATLAB name."""
    return next((ident for ident, full in MATLAB_NAMES.items() if full == name), name.upper())


def find(name: str, ids: Container[str]) -> str | None:
    """The identifier in the file that `name` stands for (any case, either of its names), None when absent."""
    ident = name.strip().upper()
    if ident in ids:
        return ident
    other = _OTHER.get(ident)
    return other if other is not None and other in ids else None


def not_found(name: str, ids: Iterable[str], file: str) -> UsageError:
    """The error for a variable that the file does not have, with the nearest name and what would store it."""
    from difflib import get_close_matches

    known = {ident.lower(): ident for ident in ids}
    known |= {full: ident for ident, full in MATLAB_NAMES.items() if ident in known.values()}
    text = f"ID not found: {name} in {file}"
    near = get_close_matches(name.strip().lower(), known, 1, 0.5)
    if name.strip().upper() in _TRANSFER:
        text += "; transfer functions are stored on request: OUTLEVEL 0 1 (dx, de), 0 2 (d2x, d2e) or 0 3 (all)"
    elif near:
        text += f"; nearest: {near[0]}"
    return UsageError(text, "files.id-not-found")
