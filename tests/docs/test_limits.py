"""docs/limits.md names every file in which a small number decides something."""

from __future__ import annotations

import ast
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SMALL = 1e-3
GUARD = 1e-200  # a divisor that shall not be zero: it decides nothing
NO_LIMIT = {
    "table_sections.py": "a unit",
    "table_solvers.py": "defaults of ERROR and ITERSTEP, in docs/keywords.md",
    "mechanism.py": "the same defaults",
    "dop853.py": "coefficients of the method",
    "symbolic_run.py": "defaults of options",
    "trade.py": "the default of --target",
    "work_precision.py": "the least error that a picture shows",
}


WRITTEN_SMALL = re.compile(r"[0-9.]e-|[.]000", re.IGNORECASE)  # every text with such a number has this


def small_numbers(source: str) -> list[float]:
    if not WRITTEN_SMALL.search(source):
        return []
    values = [n.value for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Constant)]
    return [v for v in values if isinstance(v, float) and GUARD < abs(v) < SMALL]


def test_every_file_with_a_small_number_stands_in_the_table() -> None:
    table = (ROOT / "docs" / "limits.md").read_text()
    missing = [
        str(file.relative_to(ROOT))
        for room in ("spacar", "formats", "cli/spacar_cli")
        for file in sorted((ROOT / room).rglob("*.py"))
        if file.name not in NO_LIMIT and f"{file.name}`" not in table and small_numbers(file.read_text())
    ]
    assert not missing, f"say in docs/limits.md what these decide: {missing}"


def test_a_limit_is_found() -> None:
    assert small_numbers("x = 1.0\nif x < 1e-9 * y: pass\nz = 1e-300") == [1e-9]
