"""The arrows of the house (docs/developer.md): spacar_cli -> spacar_formats -> spacar, and the stations inside."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest

HOUSE = Path(__file__).resolve().parents[1]
ROOMS = {
    "spacar": HOUSE / "spacar",
    "spacar_formats": HOUSE / "formats" / "spacar_formats",
    "spacar_cli": HOUSE / "cli" / "spacar_cli",
}
# What a room may import besides itself and the standard library.
ALLOWED = {
    "spacar": {"numpy", "scipy"},
    "spacar_formats": {"numpy", "scipy", "spacar"},
    # PIL comes with matplotlib
    "spacar_cli": {"numpy", "scipy", "spacar", "spacar_formats", "click", "rich", "matplotlib", "PIL"},
}
EXTRAS = {  # optional packages, each for one room
    "spacar/symbolic": {"sympy", "tomli", "mpmath"},
    "spacar/compiled": {"sympy"},
    "spacar/simulation": {"control"},
    "formats/spacar_formats": {"control"},
    "cli/spacar_cli": {"sympy", "tomli", "control", "dask", "distributed"},
}
OPTIONAL = {"symbolic", "compiled"}  # packages of the core that only an extra needs
# The stations of the core: a package may import those of a lower rank. Dynamics, linear and stationary share
# one: the Jacobian of the implicit integrators is the state matrix, a stationary solution needs the tangent
# matrices.
RANKS = {
    "errors": 0, "deck": 1, "elements": 1, "linear_systems": 1, "integrators": 1, "mechanism": 2,
    "kinematics": 3, "dynamics": 4, "stationary": 4, "linear": 4, "inverse": 5, "simulation": 6, "studies": 7,
}  # fmt: skip
TOGETHER = {"dynamics", "stationary", "linear"}


def sources() -> list[tuple[str, Path]]:
    return [(room, path) for room, folder in ROOMS.items() for path in sorted(folder.rglob("*.py"))]


def imports(path: Path, top_only: bool = False) -> set[str]:
    """Absolute dotted names of all modules that a file imports; `top_only`: when it is imported itself."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    nodes = tree.body if top_only else list(ast.walk(tree))
    found = set()
    for node in nodes:
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


def test_the_stations_of_the_core_point_one_way():
    bad = []
    for name, path in sources():
        parts = path.relative_to(HOUSE).parts
        if name != "spacar" or parts[1] not in RANKS:
            continue
        for module in imports(path):
            words = module.split(".")
            other = words[1] if len(words) > 1 and words[0] == "spacar" else ""
            fine = other == parts[1] or {other, parts[1]} <= TOGETHER
            if not fine and RANKS.get(other, -1) >= RANKS[parts[1]]:
                bad.append(f"{'/'.join(parts)} imports {module}")
    assert not bad, "\n".join(bad)


def numeric(path: Path) -> bool:
    return not OPTIONAL & set(path.parts)


def test_the_core_does_not_need_the_optional_packages():
    wrong = ("spacar.symbolic", "spacar.compiled", "sympy")
    numeric_core = [p for room, p in sources() if room == "spacar" and numeric(p)]
    assert not [p for p in numeric_core if any(m.startswith(wrong) for m in imports(p, top_only=True))]


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
