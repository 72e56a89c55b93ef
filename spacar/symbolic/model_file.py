"""One reading of a TOML model file: its tables, the types of their keys, the names they claim.

Errors name the file, the table, the key, and what was expected. Keys: `model_tables.py`; meaning: `model_reader.py`.
"""

import hashlib
import sys
from pathlib import Path
from typing import Any, NoReturn

if sys.version_info >= (3, 11):
    import tomllib as toml
else:
    import tomli as toml

from spacar.errors import InputError, Message, UsageError
from spacar.symbolic.model_tables import KINDS, REFERENCES, SINGLE, TABLES, Key
from spacar.symbolic.name_rules import control_character, is_name
from spacar.symbolic.scalar_reader import meant


class ModelFile:
    """The file; `place` is where its reader is, for messages, `claimed` the names with their places."""

    def __init__(self, path: Path, data: bytes | None = None) -> None:
        self.data = data  # instead of what the file holds
        self.path, self.place, self.sha256 = path, "", ""
        self.claimed: list[tuple[str, str]] = []

    def fail(self, text: str, code: str = "input") -> NoReturn:
        raise InputError([Message("error", self.path.name, None, self.place, text, code)])

    # -- text and types ----------------------------------------------------------------------------------------

    def tables(self) -> dict[str, Any]:
        try:
            data = self.path.read_bytes() if self.data is None else self.data
            self.sha256 = hashlib.sha256(data).hexdigest()
            tables: dict[str, Any] = toml.loads(data.decode("utf-8").replace("\r\n", "\n"))
            text = control_character(tables)
        except ValueError as error:
            self.fail(f"cannot read the file: {error}", "syntax")
        except RecursionError:
            self.fail("cannot read the file: its lists or tables are nested too deep", "syntax")
        if text is not None:
            self.fail(f"{text!r} holds a control character", "syntax")
        for name in tables:
            if (name not in TABLES and name not in SINGLE) or name == "coordinate":
                known = [*(t for t in TABLES if t != "coordinate"), "parameters", "coordinates", "outputs"]
                self.fail(f"unknown table '{name}'{meant(name, known)}")
        return tables

    def table(self, tables: dict[str, Any], name: str) -> dict[str, Any]:
        """The one table of this name, empty without it."""
        self.place = f"[{name}]"
        row = tables.get(name, {})
        if not isinstance(row, dict):
            self.fail(f"must be one table, written [{name}]")
        return row

    def numbers(self, row: dict[str, Any], key: str, count: int) -> list[float]:
        """The list of so many numbers under a key, empty without it."""
        given = row.get(key, [])
        wrong = [v for v in given if isinstance(v, bool) or not isinstance(v, (int, float))]
        if wrong or len(given) not in (0, count):
            self.fail(f"key '{key}' must be a list of {count} numbers, not {given!r}")
        return list(map(float, given))

    def single(self, tables: dict[str, Any], name: str) -> dict[str, Any]:
        return self.checked(self.table(tables, name), TABLES[name])

    def rows(self, tables: dict[str, Any], name: str) -> list[dict[str, Any]]:
        rows = tables.get(name, [])
        self.place = f"[[{name}]]"
        if not isinstance(rows, list) or not all(isinstance(r, dict) for r in rows):
            self.fail(f"must be an array of tables, written [[{name}]]")
        for number, row in enumerate(rows, 1):
            self.place = label_of(name, row, number)
            self.checked(row, TABLES[name])
        return rows

    def checked(self, row: dict[str, Any], keys: dict[str, Key]) -> dict[str, Any]:
        for key in row:
            if key not in keys:
                self.fail(f"unknown key '{key}'" + (meant(key, keys) or f", expected one of {', '.join(keys)}"))
        for key, rule in keys.items():
            if key not in row:
                if rule.required:
                    self.fail(f"key '{key}' is missing ({rule.help})")
                continue
            words, types = KINDS[rule.kind]
            if not isinstance(row[key], types) or (isinstance(row[key], bool) and rule.kind != "flag"):
                self.fail(f"key '{key}' must be {words}, not {row[key]!r}")
        return row

    def guarded(self, make: Any, *arguments: Any) -> None:
        """Errors of the library with the place in front."""
        try:
            make(*arguments)
        except InputError:
            raise
        except UsageError as error:
            self.fail(str(error), error.code)

    def claim(self, name: str) -> None:
        """A name that is given at the present place."""
        if not is_name(name):
            self.fail(f"'{name}' is not a name (letters, digits and _)")
        # programs keep q1 and a parameter Q1 apart (the paper has both); within one kind such pairs are slips
        for known, where in self.claimed:
            alike = known.lower() == name.lower() and _kind_of(where) == _kind_of(self.place)
            if known == name or alike:
                same = "the same name" if known == name else f"'{known}', which differs only in case,"
                self.fail(f"the name '{name}' is already used: {same} stands in {where}", "name")
        self.claimed.append((name, self.place))


def label_of(table: str, row: dict[str, Any], number: int) -> str:
    """[[beam]] link2, or [[torque]] 2 for a table without a name."""
    name = row.get("name") if table in REFERENCES or table == "body" else None
    return f"[[{table}]] {name if isinstance(name, str) else number}"


def _kind_of(place: str) -> str:
    """Names of one kind must differ in more than case: parameters, geometry, or states and inputs."""
    table = place.strip("[").split("]")[0]
    return table if table == "parameters" else "geometry" if table in (*REFERENCES, "body") else "scalar"
