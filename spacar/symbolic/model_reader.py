"""Model files: TOML text (or a small Python script) to a `MultibodySystem` with parameter values, start and settings.

Errors name the file, the table, the key, and what was expected; expressions by `Description.expression`.
The format: `symbolic.md`, section 7; the keys: `model_file.py`.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import sympy as sp

from spacar.errors import UsageError
from spacar.symbolic.beam_shapes import FAMILIES, X
from spacar.symbolic.constraints import check_constraints
from spacar.symbolic.model_file import KINDS, REFERENCES, TABLES, ModelFile, TomlTable
from spacar.symbolic.name_rules import is_name, is_output
from spacar.symbolic.reference_frames import ReferenceFrame
from spacar.symbolic.script import SymbolicModel, read_script
from spacar.symbolic.system import MultibodySystem
from spacar.symbolic.system_parts import FrameOrSection, GeometricPoint, frame_at
from spacar.symbolic.unit_vectors import TIME
from spacar.symbolic.vectors import ZERO, Vector


def read_model(path: Path | str) -> SymbolicModel:
    """Read NAME.toml, or run NAME.py, which must define `system` and may define values, start, settings, outputs.

    Raises InputError (one message, the first that is found) or UsageError when there is no such file.
    """
    path = Path(path)
    if not path.exists() and not path.suffix:
        path = path.with_suffix(".toml")
    if not path.is_file():
        raise UsageError(f"{path}: there is no such model file", "file")
    return read_script(path) if path.suffix == ".py" else _TomlReader(path).read()


def read_model_text(text: str, path: Path) -> SymbolicModel:
    """The model of a text, with the name of a file that need not exist. Raises InputError."""
    return _TomlReader(path, text.encode()).read()


class _TomlReader(ModelFile):
    """From the tables of one file to a system."""

    def __init__(self, path: Path, data: bytes | None = None) -> None:
        super().__init__(path, data)
        self.guess: dict[str, float] = {}
        self.symbols: dict[str, sp.Symbol] = {}
        self.start: dict[str, float] = {}
        self.turning: dict[str, list[list[Any]]] = {}
        self.frames: dict[str, FrameOrSection] = {}
        self.points: dict[str, GeometricPoint] = {}

    def read(self) -> SymbolicModel:
        tables = self.tables()
        values = self._parameters(self.table(tables, "parameters"))
        system_table = self.single(tables, "system")
        system = self.system = MultibodySystem(title=system_table.get("title", self.path.stem))
        system.parameters_declared = self.symbols
        self._coordinates(self.table(tables, "coordinates"))
        self.place = "[system] gravity"
        system.gravity = self._vector(system_table.get("gravity", [0, 0, 0]), system.N)
        self._speeds(self.rows(tables, "speed"))
        self._quaternions(tables)
        self._kinematics(self.rows(tables, "kinematic"))
        self.frames["N"], self.points["O"] = system.N, system.O
        self._resolve(tables)
        for table, make in (("body", self._body), ("force", self._force), ("distributed", self._distributed),
                            ("torque", self._torque), ("spring", self._spring), ("constraint", self._constraint),
                            ("close", self._close)):  # fmt: skip
            for row in self.each(tables, table):
                self.guarded(make, row)
        settings = self.single(tables, "simulate") | ({"guess": self.guess} if self.guess else {})
        outputs = self._outputs(self.table(tables, "outputs"))
        declared = frozenset(tables.get("parameters", {}))
        return SymbolicModel(self.path, system, values, self.start, settings, outputs, declared, self.sha256)

    def expression(self, value: Any, extra: dict[str, sp.Expr] | None = None, outputs: bool = False) -> sp.Expr:
        if isinstance(value, bool) or not isinstance(value, (str, int, float)):
            self.fail(f"must be {KINDS['expression'][0]}, not {value!r}")
        try:
            return self.system.expression(value, extra, outputs)
        except UsageError as error:
            self.fail(str(error), error.code)

    def _components(self, values: list[Any], names: dict[str, sp.Expr] | None = None) -> list[sp.Expr]:
        if len(values) != 3:
            self.fail(f"must be a list of 3 expressions, not {len(values)}")
        return [self.expression(v, names) for v in values]

    def _vector(self, values: list[Any], frame: ReferenceFrame, names: dict[str, sp.Expr] | None = None) -> Vector:
        return sum((c * frame[i] for i, c in enumerate(self._components(values, names), 1)), ZERO)

    # -- scalars -----------------------------------------------------------------------------------------------

    def _parameters(self, table: TomlTable) -> dict[str, float]:
        values: dict[str, float] = {}
        for name, value in table.items():
            self.place = f"[parameters] {name}"
            self.claim(name)
            self.symbols[name] = sp.Symbol(name, real=True)
            if value == "":
                continue  # a value must come from --set
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                self.fail(f'must be a number (or "" for a value given later), not {value!r}')
            values[name] = float(value)
        return values

    def _coordinates(self, table: TomlTable) -> None:
        for name, row in table.items():
            self.place = f"[coordinates] {name}"
            if not isinstance(row, dict):
                self.fail(f'must be a table such as {{ speed = "s", start = 0.0 }}, not {row!r}')
            self.checked(row, TABLES["coordinate"])
            self.claim(name)
            q, speed = self.system.coordinate(name), row.get("speed")
            if speed is not None:
                self.claim(speed)
                self.system.kinematic(q, self.system.speed(speed))
            for key, what, state in (
                ("start", self.start, name), ("guess", self.guess, name), ("speed_start", self.start, speed),
            ):  # fmt: skip
                if key in row and state is not None:
                    what[state] = float(row[key])

    def _speeds(self, rows: list[TomlTable]) -> None:
        for row in rows:
            self.place = f"[[speed]] {row['name']}"
            self.claim(row["name"])
            self.system.speed(row["name"])
            if "start" in row:
                self.start[row["name"]] = float(row["start"])

    def _quaternions(self, tables: TomlTable) -> None:
        """Coordinates and speeds of attitudes; their frames are made when their parents are known."""
        for row in self.each(tables, "attitude"):
            made = self.turning[row["name"]] = []
            for key, indices, values, make in (
                ("quaternion", (0, 1, 2, 3), "start", self.system.coordinate),
                ("speed", (1, 2, 3), "speed_start", self.system.speed),
            ):
                names = [f"{row[key]}{i}" for i in indices]
                for name in names:
                    self.claim(name)
                made.append([make(name) for name in names])
                self.start |= dict(zip(names, self.numbers(row, values, len(names)), strict=False))

    def _attitude(self, row: TomlTable) -> None:
        name, (quaternion, speeds) = row["name"], self.turning[row["name"]]
        parent, symbol = self.frame_of(row, "parent"), row.get("symbol")
        self.frames[name] = self.system.attitude(name, parent, quaternion, speeds, symbol)

    def _kinematics(self, rows: list[TomlTable]) -> None:
        turning = {q for quaternion, _ in self.turning.values() for q in quaternion}
        known = {str(q.func): q for q in self.system.coordinates if q not in turning}
        for number, row in enumerate(rows, 1):
            self.place = f"[[kinematic]] {number} coordinate"
            if row["coordinate"] not in known:
                self.fail(f"'{row['coordinate']}' is not a coordinate")
            self.place = f"[[kinematic]] {number} rate"
            self.system.kinematic(known[row["coordinate"]], self.expression(row["rate"]))
        for name, q in known.items():
            if q.diff(TIME) not in self.system.rates:
                self.place = f"[coordinates] {name}"
                self.fail("the coordinate needs a speed, or a [[kinematic]] table")

    # -- frames, points, beams ---------------------------------------------------------------------------------

    def _resolve(self, tables: TomlTable) -> None:
        """Make frames, points and beams as soon as what they refer to exists."""
        makers = {"frame": self._frame, "attitude": self._attitude, "point": self._point, "beam": self._beam}
        waiting = [(table, self.place, row) for table in makers for row in self.each(tables, table)]
        for _, place, row in waiting:
            self.place = place
            self.claim(row["name"])
        names = {f"{row['name']}.tip" if table == "beam" else row["name"] for table, _, row in waiting}
        while waiting:
            ready = [(table, place, row) for table, place, row in waiting if not self._missing(table, row)]
            for table, place, row in ready:
                self.place = place
                self.guarded(makers[table], row)
            waiting = [item for item in waiting if item not in ready]
            if not ready and waiting:
                for table, place, row in waiting:
                    self.place = place
                    if unknown := [name for name in self._missing(table, row) if name not in names]:
                        self.fail(f"refers to {unknown}, which is not defined")
                table, self.place, row = waiting[0]
                self.fail(f"refers to {self._missing(table, row)}, which depends on it in a cycle")

    def _missing(self, table: str, row: TomlTable) -> list[str]:
        homes = [(row[key], self.points if key in ("base", "root") else self.frames)
                 for key in REFERENCES[table] if key in row]  # fmt: skip
        return [name for name, home in homes if name not in home]

    def _named(self, home: Mapping[str, Any], row: TomlTable, key: str) -> Any:
        if row.get(key) not in home:
            self.fail(f"{key} refers to ['{row.get(key)}'], which is not defined")
        return home[row[key]]

    def frame_of(self, row: TomlTable, key: str) -> Any:
        return self._named(self.frames, row, key)

    def point_of(self, row: TomlTable, key: str) -> GeometricPoint:
        return self._named(self.points, row, key)

    def components_in(self, row: TomlTable) -> ReferenceFrame:
        return frame_at(self.frame_of(row, "in")) if "in" in row else self.system.N

    def _frame(self, row: TomlTable) -> None:
        parent = self.frame_of(row, "parent")
        place = self.place
        self.place = f"{place} angle"
        value = row["angle"]
        angle: Any = [self.expression(a) for a in value] if isinstance(value, list) else self.expression(value)
        self.place = place
        if not is_name(row.get("symbol", "b")):
            self.fail(f"key 'symbol' must be a name (letters, digits and _), not {row['symbol']!r}")
        self.frames[row["name"]] = self.system.frame(row["name"], parent, row["axis"], angle, row.get("symbol"))

    def _point(self, row: TomlTable) -> None:
        frame, base = self.components_in(row), self.point_of(row, "base")
        self.place += " offset"
        self.points[row["name"]] = self.system.point(row["name"], base, self._vector(row["offset"], frame))

    def _beam(self, row: TomlTable) -> None:
        place = self.place
        options: dict[str, Any] = {}
        for key in ("length", "mass", "EI", "damping", "GJ", "polar", "EA"):
            if key in row:
                self.place = f"{place} {key}"
                value = row[key]
                names = {} if key in ("length", "damping") else {"x": X}
                values = [self.expression(v, names) for v in (value if isinstance(value, list) else [value])]
                options[key] = tuple(values) if isinstance(value, list) else values[0]
        for key in ("field", "twist", "stretch"):
            if key in row:
                self.place = f"{place} {key}"
                options[key] = self._shapes(row[key])
        self.place = place
        options |= {key: row[key] for key in ("damping_boundary", "foreshortening") if key in row}
        if "bends" in row:
            options["bends"] = tuple(row["bends"]) if isinstance(row["bends"], list) else row["bends"]
        beam = self.system.beam(row["name"], self.frame_of(row, "frame"), self.point_of(row, "root"), **options)
        for key, states in (("start", beam.coordinates), ("speed_start", beam.speeds)):
            numbers = self.numbers(row, key, len(states))
            self.start |= {str(s.func): v for s, v in zip(states, numbers, strict=False)}
        tip = f"{row['name']}.tip"
        self.frames[tip] = self.points[tip] = beam.tip

    def _shapes(self, value: Any) -> Any:
        if isinstance(value, int):
            return value
        if isinstance(value, str):
            family, _, number = value.partition(" ")
            if family not in FAMILIES or not number.strip().isdigit():
                self.fail(f"'{value}' is not a family of shapes with a number ({', '.join(FAMILIES)})")
            return FAMILIES[family](int(number))
        if value and all(isinstance(v, list) for v in value):
            return tuple(self._shapes(v) for v in value)
        return tuple(self.expression(v, {"x": X}) for v in value)

    # -- bodies, loads, constraints ----------------------------------------------------------------------------

    def _body(self, row: TomlTable) -> None:
        self.claim(row["name"])
        mass, point = self.expression(row["mass"]), self.point_of(row, "at")
        if "frame" not in row:
            self.system.particle(row["name"], point, mass)
            return
        inertia = [self.expression(v) for v in row.get("inertia", [])]
        if len(inertia) not in (0, 3, 6):
            self.fail(f"key 'inertia' must be a list of 3 or 6 expressions, not {len(inertia)}")
        self.system.rigid_body(row["name"], self.frame_of(row, "frame"), point, mass, inertia)

    def _load(self, row: TomlTable, kind: str) -> Vector:
        """Every measure number that is not constant zero becomes an input with that law."""
        frame, place = self.components_in(row), self.place
        self.place = f"{place} vector"
        laws = self._components(row["vector"])
        self.place = place
        stem = row.get("name", f"{kind}{self.number}")
        acting = [i for i, law in enumerate(laws, 1) if law != 0]
        total = ZERO
        for i in acting:
            name = stem if len(acting) == 1 else f"{stem}_{i}"
            self.claim(name)
            total += self.system.input(name, laws[i - 1]) * frame[i]
        return total

    def _force(self, row: TomlTable) -> None:
        point = self.point_of(row, "at")
        self.system.force(point, self._load(row, "force"))

    def _distributed(self, row: TomlTable) -> None:
        beam = self._named({b.name: b for b in self.system.beams}, row, "beam")
        frame = self.components_in(row)
        self.place += " vector"
        self.system.distributed(beam, self._vector(row["vector"], frame, {"x": X}))

    def _torque(self, row: TomlTable) -> None:
        frame = self.frame_of(row, "frame")
        reaction = self.frame_of(row, "reaction") if "reaction" in row else None
        self.system.torque(frame, self._load(row, "torque"), reaction)

    def _spring(self, row: TomlTable) -> None:
        numbers = [self.expression(row.get(key, 0)) for key in ("stiffness", "length", "damping")]
        self.system.spring(self.point_of(row, "from"), self.point_of(row, "to"), *numbers)

    def _constraint(self, row: TomlTable) -> None:
        if ("expression" in row) == ("point" in row) or ("point" in row) != ("direction" in row):
            self.fail("needs either key 'expression', or keys 'point' and 'direction'")
        if "point" in row:
            direction = self._vector(row["direction"], self.components_in(row))
            expression = self.point_of(row, "point").velocity & direction
        else:
            expression = self.expression(row["expression"])
        self.system.constraint(expression, row.get("name"))
        check_constraints(self.system)

    def _close(self, row: TomlTable) -> None:
        axes, frame = row.get("directions", [1, 2, 3]), self.components_in(row)
        if not axes or not all(type(a) is int and a in (1, 2, 3) for a in axes) or len(set(axes)) != len(axes):
            self.fail(f"key 'directions' must be axes out of 1, 2 and 3, not {axes!r}")
        a, b = self.point_of(row, "from"), self.point_of(row, "to")
        self.system.close(a, b, [frame[i] for i in axes], row.get("name"))
        check_constraints(self.system)

    # -- outputs -----------------------------------------------------------------------------------------------

    def _outputs(self, table: TomlTable) -> dict[str, sp.Expr]:
        result = {}
        for name, value in table.items():
            self.place = f"[outputs] {name}"
            if not is_output(name):
                self.fail(f"{name!r} is not a name for an output (letters, digits, blanks and _.+-()[])", "name")
            result[name] = self.expression(value, outputs=True)
        return result
