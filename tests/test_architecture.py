"""The arrows of the house (docs/developer.md): spacar_cli -> spacar_drawing -> spacar_formats ->
spacar, and the stations inside."""

import ast
import re
import sys
from functools import cache
from pathlib import Path

import pytest

HOUSE = Path(__file__).resolve().parents[1]
ROOMS = {
    "spacar": HOUSE / "spacar",
    "spacar_formats": HOUSE / "formats" / "spacar_formats",
    "spacar_drawing": HOUSE / "cli" / "spacar_drawing",
    "spacar_cli": HOUSE / "cli" / "spacar_cli",
}
# What a room may import besides itself and the standard library.
ALLOWED = {
    "spacar": {"numpy", "scipy"},
    "spacar_formats": {"numpy", "scipy", "spacar"},
    # PIL comes with matplotlib
    "spacar_drawing": {"numpy", "scipy", "spacar", "spacar_formats", "matplotlib", "PIL"},
    "spacar_cli": {"numpy", "scipy", "spacar", "spacar_formats", "spacar_drawing", "click", "rich", "matplotlib"},
}
EXTRAS = {  # optional packages, each for one room
    "spacar/symbolic": {"sympy", "tomli", "tomllib", "mpmath"},
    "spacar/compiled/generator": {"sympy"},
    "spacar/elements": {"sympy"},  # modules that no run imports: tests/test_imports.py
    "spacar/simulation": {"control"},
    "formats/spacar_formats": {"control", "pythonfmu", "pandas", "xarray"},
    "cli/spacar_cli": {"sympy", "tomli", "control", "dask", "distributed"},
}
OPTIONAL = {"symbolic", "compiled"}  # packages of the core that only an extra needs
# The rooms and files of the core: each may import those of a lower rank, and itself. Analyses are named in the table
# of modes; what else lies above its caller is asked of `spacar.modes`, and `spacar/__init__.py` says where it is.
RANKS = {
    "errors": 0, "arrays": 0, "locks": 0,
    "modes": 1, "frame": 1, "elements": 1, "linear_systems": 1, "integrators": 1, "native": 1,
    "summary": 2,
    "deck": 3, "symbolic": 3,
    "expressions": 4, "mechanism": 4,
    "stream": 5,
    "kinematics": 6, "result": 6,
    "calls": 7, "dynamics": 7,
    "linearization": 8, "compiled": 8,
    "stationary": 9, "forward": 9,
    "linear": 10,
    "inverse": 11,
    "simulation": 12,
    "studies": 13, "stroke": 13,
    "sensitivities": 14,
}  # fmt: skip


@cache
def sources() -> list[tuple[str, Path]]:
    return [(room, path) for room, folder in ROOMS.items() for path in sorted(folder.rglob("*.py"))]


@cache
def statements(path: Path) -> tuple[list[ast.stmt], list[ast.stmt]]:
    """The import statements at the top of a file, and all of them; a file is parsed once."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    kinds = (ast.Import, ast.ImportFrom)
    return [n for n in tree.body if isinstance(n, kinds)], [n for n in ast.walk(tree) if isinstance(n, kinds)]


@cache
def imports(path: Path, top_only: bool = False) -> set[str]:
    """Absolute dotted names of all modules that a file imports; `top_only`: when it is imported itself."""
    found = set()
    for node in statements(path)[0 if top_only else 1]:
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.module is not None or node.level, path
            found.add("." * node.level + (node.module or ""))
    return {name for name in found if not name.startswith(".")}


@pytest.mark.parametrize("room", ROOMS)
def test_rooms_import_only_what_they_may(room):
    bad = []
    for name, path in sources():
        if name != room:
            continue
        place = path.relative_to(HOUSE).as_posix()
        extra = set().union(*(more for folder, more in EXTRAS.items() if place.startswith(folder)))
        tops = {module.partition(".")[0] for module in imports(path)}
        wrong = tops - ALLOWED[room] - extra - {room} - set(sys.stdlib_module_names)
        bad += [f"{place} imports {w}" for w in sorted(wrong)]
    assert not bad, "\n".join(bad)


def test_every_room_of_the_core_has_a_rank():
    here = {p.stem if p.is_file() else p.name for p in ROOMS["spacar"].iterdir() if p.suffix in ("", ".py")}
    assert here - {"__init__", "__pycache__"} == set(RANKS)


def test_the_stations_of_the_core_point_one_way():
    bad = []
    for name, path in sources():
        parts = path.relative_to(HOUSE).with_suffix("").parts
        if name != "spacar" or parts[1] == "__init__":
            continue
        for module in imports(path):
            words = module.split(".")
            other = words[1] if len(words) > 1 and words[0] == "spacar" else ""
            if other != parts[1] and RANKS.get(other, -1) >= RANKS[parts[1]]:
                bad.append(f"{'/'.join(parts)} imports {module}")
    assert not bad, "\n".join(bad)


def test_no_arrow_hides_in_a_string():
    """Modules are named by strings in the packages' own files and in the table of modes, nowhere else in the core."""
    bad = []
    for name, path in sources():
        if name != "spacar" or path.name in ("__init__.py", "modes.py"):
            continue
        place, text = path.relative_to(HOUSE), path.read_text(encoding="utf-8")
        bad += [f"{place} imports by a string" for word in ("import_module", "__import__") if word in text]
        named = re.findall(r"[\"']((?:spacar|spacar_formats|spacar_drawing|spacar_cli)\.[\w.:]+)[\"']", text)
        bad += [f"{place} names {module}" for module in named if module.split(".")[1] not in place.parts]
    assert not bad, "\n".join(bad)


def module_of(path: Path) -> str:
    """Dotted name of a file."""
    room, folder = next((r, f) for r, f in ROOMS.items() if f in path.parents)
    words = path.relative_to(folder).with_suffix("").parts
    return ".".join((room, *(words[:-1] if words[-1] == "__init__" else words)))


def arrows() -> dict[str, set[str]]:
    """Which module imports which, at any place in it, for types too."""
    known = {module_of(path) for _, path in sources()}
    found: dict[str, set[str]] = {}
    for _, path in sources():
        module = module_of(path)
        package = module if path.name == "__init__.py" else module.rpartition(".")[0]
        aims = found.setdefault(module, set())
        for node in statements(path)[1]:
            if isinstance(node, ast.Import):
                aims |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                home = node.module or ""
                if node.level:
                    base = package.split(".")[: len(package.split(".")) - node.level + 1]
                    home = ".".join((*base, home)).rstrip(".")
                inner = {f"{home}.{alias.name}" for alias in node.names}
                aims |= (inner & known) or {home}
        aims &= known - {module}
    return found


def test_no_modules_import_each_other_in_a_circle():
    """Take away what imports nothing that is left, again and again: what remains goes round."""
    left = arrows()
    while free := [module for module, aims in left.items() if not aims & left.keys()]:
        for module in free:
            del left[module]
    while ends := left.keys() - {aim for module, aims in left.items() for aim in aims if aim != module}:
        for module in ends:  # only leads into a circle
            del left[module]
    assert not left, "\n".join(f"{m} imports {', '.join(sorted(aims & left.keys()))}" for m, aims in left.items())


def numeric(path: Path) -> bool:
    return not OPTIONAL & set(path.parts) and not path.stem.endswith("_symbolic")


def test_the_core_does_not_need_the_optional_packages():
    wrong = ("spacar.symbolic", "spacar.compiled", "sympy")
    numeric_core = [p for room, p in sources() if room == "spacar" and numeric(p)]
    for path in numeric_core:
        assert not [m for m in imports(path, top_only=True) if m.startswith(wrong) or m.endswith("_symbolic")], path


def test_heavy_packages_are_imported_where_they_are_used():
    """Not at the top of a module: `spacar 1 crank` must not pay for them."""
    heavy = ("matplotlib", "rich", "scipy.integrate", "sympy", "control", "dask", "distributed")
    bad = [
        f"{path.relative_to(HOUSE)} imports {module} at its top"
        for room, path in sources()
        if room == "spacar_formats" or (room == "spacar" and numeric(path))
        for module in imports(path, top_only=True)
        if module.startswith(heavy)
    ]
    assert not bad, "\n".join(bad)


def test_no_file_is_long() -> None:
    """400 lines of 120 characters: Python (ruff looks at its lines) and C."""
    texts = {path: path.read_text("utf-8").splitlines() for _, path in sources()}
    in_c = {path: path.read_text("utf-8").splitlines() for path in (HOUSE / "spacar" / "compiled").glob("*.[ch]")}
    assert [path.name for path, lines in (texts | in_c).items() if len(lines) > 400] == []
    assert [path.name for path, lines in in_c.items() if max(map(len, lines)) > 120] == []
