"""Mutants: one sign, factor, index or operator of the source changed, and whether the cases of `array.txt` notice.

`python -m tests.combinations.mutants --count 100 --seed 1`. Each is made in a copy of the package and meets the cases
that come by its statement, the fastest first, with the relations of the fast test and then with all. Text from which C
is generated is left out: the engine has it compiled; so are conditions of refusals, which no valid model meets.
"""

from __future__ import annotations

import argparse
import ast
import compileall
import os
import py_compile
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import FrameType
from typing import Any

from .campaign import FAST, finding
from .coverage import specs
from .relations import RELATIONS

HERE = Path(__file__).resolve()
ROOT = HERE.parents[2]
ROOMS = ("spacar/elements/**/*.py", "spacar/deck/rewrite/divide.py", "spacar/linearization/*.py")
SWAPS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}


class Changes(ast.NodeTransformer):
    """Counts the places where something can be changed; changes the one of number `at`."""

    def __init__(self, at: int = -1) -> None:
        self.at, self.count, self.what, self.line, self.statement = at, 0, "", 0, 0
        self.inside: list[int] = []  # lines of the statements of functions that are open

    def visit(self, node: ast.AST) -> ast.AST:
        """As usual; keeps the line of the statement."""
        if not isinstance(node, ast.stmt) or not (self.inside or isinstance(node, ast.FunctionDef)):
            return super().visit(node)
        self.inside.append(node.lineno)
        found = super().visit(node)
        self.inside.pop()
        return found

    def here(self, node: ast.AST, what: str) -> bool:
        self.count += 1
        if self.count - 1 != self.at:
            return False
        self.what, self.line = what, getattr(node, "lineno", 0)
        self.statement = self.inside[-1] if self.inside else 0
        return True

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        other = SWAPS.get(type(node.op))
        if other is not None and not is_text(node) and self.here(node, f"{type(node.op).__name__} -> {other.__name__}"):
            node.op = other()
        return node

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant) and self.here(node, "-a -> a"):
            return node.operand
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if isinstance(node.value, float) and node.value and self.here(node, f"{node.value} -> {1.5 * node.value}"):
            node.value = 1.5 * node.value
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        self.generic_visit(node)
        places = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        for place in places:
            small = (
                isinstance(place, ast.Constant) and isinstance(place.value, int) and not isinstance(place.value, bool)
            )
            if (
                small
                and isinstance(node.ctx, ast.Load)
                and self.here(node, f"index {place.value} -> {other_index(place.value)}")
            ):
                place.value = other_index(place.value)
        return node

    def visit_arguments(self, node: ast.arguments) -> ast.AST:
        return node  # annotations and defaults stay

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        if node.value is not None:
            node.value = self.visit(node.value)
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.body = [self.visit(s) for s in node.body]
        return node

    def visit_If(self, node: ast.If) -> ast.AST:
        return node if isinstance(node.body[0], ast.Raise) else self.generic_visit(node)

    def visit_For(self, node: ast.For) -> ast.AST:
        return node if isinstance(node.body[0], ast.Raise) else self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> ast.AST:
        return node

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.AST:
        return node


def other_index(i: int) -> int:
    return i - 1 if i > 0 else 1


def is_text(node: ast.BinOp) -> bool:
    """Sums of strings, and types such as `int | None`."""
    return any((isinstance(n, ast.Constant) and isinstance(n.value, str)) or isinstance(n, ast.JoinedStr)
               for n in (node.left, node.right))  # fmt: skip


def places() -> Iterator[tuple[Path, int]]:
    for room in ROOMS:
        for path in sorted(p for p in ROOT.glob(room) if not p.stem.endswith("_symbolic")):
            count = Changes()
            count.visit(ast.parse(path.read_text()))
            yield from ((path.relative_to(ROOT), k) for k in range(count.count))


def mutated(path: Path, at: int) -> tuple[str, str, int]:
    """The changed source, what was changed, and the line of its statement; 0: outside of functions."""
    change = Changes(at)
    tree = change.visit(ast.parse((ROOT / path).read_text()))
    return ast.unparse(ast.fix_missing_locations(tree)), f"{path}:{change.line}: {change.what}", change.statement


def passed(files: set[str]) -> list[tuple[float, int, set[tuple[str, int]]]]:
    """Of every case its CPU time (s), its seed, and the lines of the files that it comes by; the fastest first. Lines
    that run when a module is imported belong to no case."""
    for file in sorted(files):
        import_module(".".join(Path(file).relative_to(ROOT).with_suffix("").parts))
    seen: set[tuple[str, int]] = set()

    def line(frame: FrameType, event: str, arg: Any) -> Any:
        seen.add((frame.f_code.co_filename, frame.f_lineno))
        return line

    def call(frame: FrameType, event: str, arg: Any) -> Any:
        return line if frame.f_code.co_filename in files else None

    found = []
    for spec in specs():
        seen.clear()
        start = time.process_time()
        sys.settrace(call)
        finding(spec, len(RELATIONS), None)
        sys.settrace(None)
        found.append((time.process_time() - start, spec.seed, set(seen)))
    return sorted(found, key=lambda f: f[:2])


def killed(copy: Path, path: Path, text: str, cases: list[int]) -> str:
    """Why the cases fail with this source; empty: they do not."""
    file = copy / path
    before = file.read_text()
    file.write_text(text)
    try:
        words = [sys.executable, "-m", "tests.combinations.campaign", "--array", *map(str, cases), "--first-failure"]
        environment = {**os.environ, "PYTHONPATH": f"{copy}:{copy}/formats:{copy}/cli", "PYTHONDONTWRITEBYTECODE": "1"}
        for relations in (FAST, len(RELATIONS)):
            done = subprocess.run(
                [*words, "--relations", str(relations)],
                cwd=copy, env=environment, capture_output=True, text=True, check=False, timeout=600,
            )  # fmt: skip
            if done.returncode:
                return (done.stdout + done.stderr).strip()[-200:] or "failed"
        return ""
    except subprocess.TimeoutExpired:
        return "time"
    finally:
        file.write_text(before)


def main() -> int:
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--count", type=int, default=100)
    p.add_argument("--seed", type=int, default=1)
    a = p.parse_args()
    chosen = random.Random(a.seed).sample(list(places()), a.count)
    alive = []
    runs = passed({str(ROOT / path) for path, _ in chosen})
    with tempfile.TemporaryDirectory(prefix="mutants-") as name:
        copy = Path(name)
        for folder in ("spacar", "formats", "cli", "tests", "data"):
            shutil.copytree(ROOT / folder, copy / folder)
        compileall.compile_dir(copy, quiet=1, invalidation_mode=py_compile.PycInvalidationMode.CHECKED_HASH)
        for k, (path, at) in enumerate(chosen, 1):
            text, what, statement = mutated(path, at)
            cases = [seed for _, seed, lines in runs if (str(ROOT / path), statement) in lines]
            why = killed(copy, path, text, cases or [seed for _, seed, _ in runs])
            last = why.splitlines()[-1][:80] if why else ""
            print(f"{k} {'killed' if why else 'ALIVE '} {what} ({len(cases)} cases) {last}", flush=True)
            alive += [what] * (not why)
    print(f"{a.count - len(alive)} of {a.count} killed", *alive, sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
