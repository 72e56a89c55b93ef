"""One reading of a TOML model file: its tables, the types of their keys, the names they claim.

Errors name the file, the table, the key, and what was expected. Reader, checks and help use the table of keys: what is
required, of which type. Meaning: `model_reader.py`.
"""

import hashlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

if sys.version_info >= (3, 11):
    import tomllib as toml
else:
    import tomli as toml

from spacar.errors import InputError, Message, UsageError
from spacar.symbolic.name_rules import control_character, is_name
from spacar.symbolic.scalar_reader import meant

TomlTable = dict[str, Any]


@dataclass(frozen=True)
class Key:
    """One key: accepted types in words (`kind`), required or not, what it is."""

    kind: str
    help: str
    required: bool = True


KINDS: dict[str, tuple[str, Any]] = {
    "text": ("a text", str), "name": ("a name", str), "number": ("a number", (int, float)),
    "integer": ("an integer", int), "flag": ("true or false", bool),
    "expression": ("an expression (text or number)", (str, int, float)), "vector": ("a list of 3 expressions", list),
    "expressions": ("a list of expressions", list),
    "shapes": ('a number of default shapes, a family ("pinned 3") or a list of expressions in x', (int, str, list)),
    "axes": ("2, 3 or [2, 3]", (int, list)),
    "stiffness": ("an expression, or one for each bending direction", (str, int, float, list)),
    "turn": ('1, 2, 3 or a sequence such as "321"', (int, str)),
    "angles": ("an expression, or a list of them for a sequence", (str, int, float, list)), "list": ("a list", list),
    "table": ("a table", dict),
}  # fmt: skip


_may = partial(Key, required=False)
_NAME = Key("name", "name")
_IN = _may("name", "frame of the measure numbers (N)")

TABLES: dict[str, dict[str, Key]] = {
    "system": {"title": _may("text", "title"), "gravity": _may("vector", "gravity in N [m/s²]")},
    "simulate": {
        "time": _may("number", "end of the simulation [s]"), "steps": _may("integer", "number of output steps"),
        "integrator": _may("text", "lsoda, radau or dop853"), "rtol": _may("number", "relative tolerance"),
        "atol": _may("number", "absolute tolerance of all states"),
    },
    "coordinate": {
        "speed": _may("name", "speed that is its derivative"),
        "start": _may("number", "value at t = 0, kept when loops are assembled"),
        "guess": _may("number", "value from which a loop is assembled"),
        "speed_start": _may("number", "speed at t = 0"),
    },
    "speed": {"name": _NAME, "start": _may("number", "value at t = 0")},
    "kinematic": {"coordinate": Key("name", "coordinate"), "rate": Key("expression", "its derivative")},
    "frame": {
        "name": _NAME, "parent": Key("name", "frame or section"),
        "axis": Key("turn", "axis of the parent, 1 to 3, or a sequence of moving axes"),
        "angle": Key("angles", "angle [rad], a list for a sequence"),
        "symbol": _may("text", "letter of its unit vectors"),
    },
    "attitude": {
        "name": _NAME, "parent": Key("name", "frame or section"),
        "quaternion": Key("name", "letter of four coordinates: e makes e0, e1, e2, e3"),
        "speed": Key("name", "letter of three speeds: w makes w1, w2, w3, the angular velocity in the frame [rad/s]"),
        "start": _may("list", "quaternion at t = 0, scaled to length one (1, 0, 0, 0)"),
        "speed_start": _may("list", "angular velocity at t = 0 [rad/s]"),
        "symbol": _may("text", "letter of its unit vectors"),
    },
    "point": {
        "name": _NAME, "base": Key("name", "point"), "offset": Key("vector", "vector from the base [m]"), "in": _IN,
    },
    "beam": {
        "name": _NAME, "frame": Key("name", "frame, axis 1 along the beam"), "root": Key("name", "point"),
        "length": Key("expression", "length [m]"),
        "mass": Key("expression", "mass per length [kg/m], may depend on x"),
        "EI": _may("stiffness", "bending stiffness [N m²], may depend on x"),
        "bends": _may("axes", "unit vectors of deflection"), "field": _may("shapes", "assumed field"),
        "damping": _may("expression", "γ [N s]"),
        "damping_boundary": _may("flag", "natural boundary condition of the damping"),
        "foreshortening": _may("flag", "shortening by bending"), "twist": _may("shapes", "torsion field"),
        "GJ": _may("expression", "torsion stiffness [N m²]"),
        "polar": _may("expression", "polar moment of inertia per length [kg m]"),
        "stretch": _may("shapes", "axial field"), "EA": _may("expression", "axial stiffness [N]"),
        "start": _may("list", "amplitudes of all shapes at t = 0"), "speed_start": _may("list", "their rates at t = 0"),
    },
    "body": {
        "name": _NAME, "at": Key("name", "point of the mass centre"), "mass": Key("expression", "mass [kg]"),
        "frame": _may("name", "frame in which it is fixed (none: particle)"),
        "inertia": _may("expressions", "I11, I22, I33[, I12, I23, I31] [kg m²]"),
    },
    "force": {
        "name": _may("name", "input"), "at": Key("name", "point"), "vector": Key("vector", "force [N]"), "in": _IN,
    },
    "distributed": {
        "beam": Key("name", "beam"), "vector": Key("vector", "force per length [N/m], may depend on x"), "in": _IN,
    },
    "torque": {
        "name": _may("name", "input"), "frame": Key("name", "frame or section"),
        "reaction": _may("name", "frame or section of the reaction"), "vector": Key("vector", "torque [N m]"),
        "in": _IN,
    },
    "spring": {
        "from": Key("name", "point"), "to": Key("name", "point"), "stiffness": Key("expression", "stiffness [N/m]"),
        "length": _may("expression", "length without force [m]"), "damping": _may("expression", "damping [N s/m]"),
    },
    "constraint": {
        "expression": _may("expression", "what is zero: linear in the speeds, or a position"),
        "point": _may("name", "point that does not move along `direction`"),
        "direction": _may("vector", "direction of no velocity"), "in": _IN,
        "name": _may("name", "constraint; NAME_force is its force"),
    },
    "close": {
        "from": Key("name", "point"), "to": Key("name", "point that coincides with it"),
        "directions": _may("list", "axes of the frame along which they coincide (1, 2, 3)"), "in": _IN,
        "name": _may("name", "loop; NAME_force or NAME_1_force … are its forces"),
    },
}  # fmt: skip
"""Arrays of tables `[[name]]`, except `[system]`, `[simulate]` and the rows of `[coordinates]` (`coordinate`)."""

SINGLE = ("system", "simulate", "parameters", "coordinates", "outputs")
REFERENCES = {"frame": ("parent",), "attitude": ("parent",), "point": ("base", "in"), "beam": ("frame", "root")}
"""What must exist before a frame, point or beam can be made; the order in the file is free."""


class ModelFile:
    """The file; `place` is where its reader is, for messages, `claimed` the names with their places."""

    def __init__(self, path: Path, data: bytes | None = None) -> None:
        self.data = data  # instead of what the file holds
        self.path, self.place, self.sha256, self.number = path, "", "", 0
        self.claimed: list[tuple[str, str]] = []

    def fail(self, text: str, code: str = "input") -> NoReturn:
        raise InputError([Message("error", self.path.name, None, self.place, text, code)])

    # -- text and types ----------------------------------------------------------------------------------------

    def tables(self) -> TomlTable:
        try:
            data = self.path.read_bytes() if self.data is None else self.data
            self.sha256 = hashlib.sha256(data).hexdigest()
            tables: TomlTable = toml.loads(data.decode("utf-8-sig").replace("\r\n", "\n"))
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

    def table(self, tables: TomlTable, name: str) -> TomlTable:
        """The one table of this name, empty without it."""
        self.place = f"[{name}]"
        row = tables.get(name, {})
        if not isinstance(row, dict):
            self.fail(f"must be one table, written [{name}]")
        return row

    def numbers(self, row: TomlTable, key: str, count: int) -> list[float]:
        """The list of so many numbers under a key, empty without it."""
        given = row.get(key, [])
        wrong = [v for v in given if isinstance(v, bool) or not isinstance(v, (int, float))]
        if wrong or len(given) not in (0, count):
            self.fail(f"key '{key}' must be a list of {count} numbers, not {given!r}")
        return list(map(float, given))

    def single(self, tables: TomlTable, name: str) -> TomlTable:
        return self.checked(self.table(tables, name), TABLES[name])

    def rows(self, tables: TomlTable, name: str) -> list[TomlTable]:
        rows = tables.get(name, [])
        self.place = f"[[{name}]]"
        if not isinstance(rows, list) or not all(isinstance(r, dict) for r in rows):
            self.fail(f"must be an array of tables, written [[{name}]]")
        for number, row in enumerate(rows, 1):
            self.place = label_of(name, row, number)
            self.checked(row, TABLES[name])
        return rows

    def each(self, tables: TomlTable, name: str) -> Iterator[TomlTable]:
        """The rows of a table, each at its place and with its `number`."""
        for number, row in enumerate(self.rows(tables, name), 1):
            self.number, self.place = number, label_of(name, row, number)
            yield row

    def checked(self, row: TomlTable, keys: dict[str, Key]) -> TomlTable:
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


def label_of(table: str, row: TomlTable, number: int) -> str:
    """[[beam]] link2, or [[torque]] 2 for a table without a name."""
    name = row.get("name") if table in REFERENCES or table == "body" else None
    return f"[[{table}]] {name if isinstance(name, str) else number}"


def _kind_of(place: str) -> str:
    """Names of one kind must differ in more than case: parameters, geometry, or states and inputs."""
    table = place.strip("[").split("]")[0]
    return table if table == "parameters" else "geometry" if table in (*REFERENCES, "body") else "scalar"
