"""Writes the page of limits from the program: `python docs/limits.py > docs/limits.md`.

A row is a constant that holds a small number or eps, with the comment beside or above it. So every file and constant
on the page exists.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

HOUSE = Path(__file__).resolve().parents[1]
SMALL, GUARD = 1e-3, 1e-200  # below GUARD: a divisor that shall not be zero, it decides nothing
NO_LIMIT = {
    "table_kinematics.py": "a unit",
    "table_solvers.py": "defaults of ERROR and ITERSTEP, in docs/keywords.md",
    "mechanism.py": "the same defaults",
    "dop853.py": "coefficients of the method",
    "symbolic_run.py": "defaults of options",
    "trade.py": "the default of --target",
    "work_precision.py": "the least error that a picture shows",
}
ROOMS = {
    "Positions, motion, elements": ("elements", "kinematics", "mechanism", "dynamics", "forward", "compiled"),
    "Integration": ("integrators",),
    "Statics, linearization, linear systems": ("stationary", "linearization", "linear", "linear_systems"),
    "Flexures and sensitivities": ("stroke", "sensitivities"),
    "Inverse dynamics and simulation": ("inverse", "simulation"),
    "Input, studies, files and tools": (),
    "Symbolic part": ("symbolic",),
}
HEAD = """# Limits of convergence and acceptance

For readers who ask why a number was accepted, refused or warned about. `python docs/limits.py` makes this page from
the program: every small constant that decides something, with the comment beside it.

ε is 2.2e-16. A limit of *rounding* follows from ε and from the size or condition of what is compared; a *chosen* one
has another reason. L is the size of the model; *scaled* means lengths over L, rotations as they are. Most limits lead
to a warning, few to a refusal; some decide only the cost.
"""


class Limit(NamedTuple):
    """One row: file from the top folder, constant, its number as written, comment."""

    file: str
    name: str
    value: str
    reason: str


def is_small(node: ast.AST) -> bool:
    """Whether an expression holds a number that decides something by its smallness."""
    parts = list(ast.walk(node))
    numbers = [n.value for n in parts if isinstance(n, ast.Constant)]
    eps = any(isinstance(n, ast.Name) and n.id in ("EPS", "eps") for n in parts)
    eps |= any(isinstance(n, ast.Attribute) and n.attr == "eps" for n in parts)
    return eps or any(isinstance(v, float) and GUARD < abs(v) < SMALL for v in numbers)


def comment(lines: list[str], first: int, last: int) -> str:
    """The comment in line `last`, else the whole lines of comment above `first` (both from 1)."""
    if beside := re.search(r"#\s*(?!type:|noqa)(.*)", lines[last - 1]):
        return beside[1]
    above: list[str] = []
    while first > 1 and lines[first - 2].lstrip().startswith("#"):
        first -= 1
        above.insert(0, lines[first - 1].lstrip(" #"))
    return re.split(r"(?<=[a-z])[.](?= |$)", " ".join(above))[0]


def limits(path: Path) -> Iterator[Limit]:
    """The rows of a source file."""
    source = path.read_text(encoding="utf-8")
    if not re.search(r"[0-9.]e-|[.]000|eps", source, re.IGNORECASE):
        return
    file, lines = path.relative_to(HOUSE).as_posix(), source.splitlines()
    for node in ast.parse(source).body:
        value = getattr(node, "value", None)
        if isinstance(node, ast.Assign | ast.AnnAssign) and value is not None:
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            name = ast.unparse(target).strip("()").replace(" ", "")
            if is_small(value) and name != "EPS" and len(written := ast.unparse(value)) < 60:
                yield Limit(file, name, written, comment(lines, node.lineno, node.end_lineno or node.lineno))


def sources() -> list[Path]:
    """Files that may hold limits."""
    rooms = ("spacar", "formats", "cli/spacar_cli")
    found = [p for room in rooms for p in (HOUSE / room).rglob("*.py") if "generated" not in p.parts]
    return sorted(p for p in found if p.name not in NO_LIMIT)


def title(file: str) -> str:
    """The heading under which a file stands."""
    room = file.split("/")[1] if file.startswith("spacar/") else ""
    other = "Input, studies, files and tools"
    return next((t for t, rooms in ROOMS.items() if room in rooms), other)


def page() -> str:
    """The text of docs/limits.md."""
    rows = [limit for path in sources() for limit in limits(path)]
    text = [HEAD]
    for heading in ROOMS:
        mine = [r for r in rows if title(r.file) == heading]
        text += [f"## {heading}\n"] * bool(mine)
        for file in dict.fromkeys(r.file for r in mine):
            text.append(f"- `{file}`")
            for r in mine:
                if r.file == file:
                    number = re.sub(r"float\((np.\w+\(.*\))\)", r"\1", r.value)
                    number = re.sub(r"float\(np.finfo\(float\).eps\)|np.finfo\(float\).eps|EPS", "ε", number)
                    text.append(f"  - `{r.name}` {number.replace(' ', '')}" + f": {r.reason}" * bool(r.reason))
        text.append("")
    return "\n".join(text).rstrip() + "\n"


if __name__ == "__main__":
    print(page(), end="")
