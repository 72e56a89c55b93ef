"""Imports stand at the top of a module; which may stand in a function, and why, is said here and nowhere else.

Measured by tests/acceptance/test_runs.py: `spacar --help` loads no NumPy, `spacar 1 crank` no linear algebra of SciPy.
"""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

HOUSE = Path(__file__).resolve().parents[1]
# Commands (cli/spacar_cli) are free: they import what they work with when they run, so that their help costs nothing.
ROOMS = ("spacar", "formats", "cli/spacar_drawing")
# Slow to import, not there on every system or only with an extra; of the standard library what only rare branches need.
HEAVY = {
    "matplotlib", "PIL", "scipy", "numpy.polynomial", "rich", "sympy", "mpmath", "control", "pythonfmu", "concurrent",
    "multiprocessing", "importlib", "difflib", "hashlib", "html", "msvcrt", "fcntl", "shutil", "tempfile",
    "pandas", "xarray",
}  # fmt: skip
# Ours, for some models or runs only: the compiled path and symbolic models need extras, the others load SciPy,
# a window, or the spatial elements, which a planar model never needs. Who imports spacar_drawing mostly wants one
# picture: curves, pages and numbers of stresses would bring in the linearized equations. Results in memory, beams by
# cross-section, words about a failure and codes that need a Jacobian are what a run of the command line seldom needs.
LATE = {
    "spacar.compiled", "spacar.symbolic", "spacar.simulation", "spacar.linear_systems", "spacar.elements",
    "spacar.mechanism.user_files", "spacar.mechanism.user_functions", "spacar.kinematics.lost_stiffness",
    "spacar.kinematics.released_parts",
    "spacar_drawing.window",
    "spacar.result", "spacar.deck.section_block", "spacar.kinematics.failure", "spacar.linearization.state_jacobian",
    "spacar_drawing.report_page", "spacar_drawing.curves", "spacar_drawing.history", "spacar_drawing.stress_numbers",
    "spacar_drawing.stroke_page", "spacar_drawing.stroke_figures", "spacar_drawing.viewer_page",
    "spacar_drawing.raster", "spacar_drawing.shown_figure",
}  # fmt: skip


def late(module: str) -> bool:
    return any(module == name or module.startswith(f"{name}.") for name in HEAVY | LATE)


def imports_in_functions(node: ast.AST, inside: bool = False) -> Iterator[ast.Import | ast.ImportFrom]:
    """Statements only: expressions hold no imports."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom) and inside:
            yield child
        elif isinstance(child, ast.stmt | ast.ExceptHandler | ast.match_case):
            yield from imports_in_functions(child, inside or isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef))


def test_imports_stand_at_the_top_but_for_those_that_start_up_needs_late():
    bad = []
    for path in (p for room in ROOMS for p in sorted((HOUSE / room).rglob("*.py"))):
        text = path.read_text(encoding="utf-8")
        if not re.search(r"^\s+(from|import)\s", text, flags=re.MULTILINE):
            continue
        for node in imports_in_functions(ast.parse(text)):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module]
            bad += [f"{path.relative_to(HOUSE)}:{node.lineno} {name}" for name in names if not late(name)]
    assert not bad, "\n".join(sorted(bad))


WITHOUT_SYMPY = """
import sys
sys.modules["sympy"] = None  # an import of it raises
import spacar_cli.main as program
for line in {commands!r}:
    sys.argv = ["spacar", *line.split()]
    try:
        program.main()
    except SystemExit as ended:
        assert not ended.code, line
assert not [name for name in sys.modules if name.startswith("spacar.symbolic")]
"""
COMMANDS = (
    "0 slider", "1 slider", "2 robotinv", "3 robotinvlin", "4 lever", "7 plbeam5", "8 plbeam5buck", "9 robotinv",
    "10 lateral4", "simulate robotsim.sim", "keywords PLBEAM",
)  # fmt: skip


@pytest.mark.parametrize("general", ["", "1"], ids=["compiled", "general"])
def test_every_mode_runs_without_sympy(general, tmp_path, monkeypatch):
    for path in (HOUSE / "data").glob("*.*"):
        (tmp_path / path.name).write_bytes(path.read_bytes())
    monkeypatch.setenv("SPACAR_GENERAL", general)
    text = WITHOUT_SYMPY.format(commands=COMMANDS)
    done = subprocess.run([sys.executable, "-c", text], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert not done.returncode, done.stderr[-1000:]
