"""Runs the fenced blocks of a document the way a reader does: in an empty folder, from top to bottom.

    <!-- file: NAME -->      before a block: the block is the file NAME
    ```console               `$ command`, then the lines that it prints
    ```python                doctest when it has `>>>`, else executed; all blocks of a document share their names
    ```sh, ```text ...       shown to the reader, not run here

Printed lines are compared word by word; `...` stands for any number of lines. Numbers are equal within 1e-5 of
their size, or 1e-9 near zero: what integrators with their default tolerance reproduce on any machine, and below
every digit that the text speaks about. A command that fails is an error unless the next one is `echo $?`.
"""

import contextlib
import doctest
import importlib.util
import io
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

from spacar_cli.environment import Environment
from spacar_cli.main import main

NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")
FENCE = re.compile(r"^```(\w*)\s*$")
FILE = re.compile(r"^<!-- file: (\S+) -->$")
RELATIVE, ABSOLUTE = 1e-5, 1e-9


def module_of(path: Path) -> Any:
    """A script as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@dataclass(frozen=True)
class Block:
    """A fenced block: language, file name or "", first line of its text, text."""

    language: str
    name: str
    line: int
    text: str


@dataclass
class Count:
    """How much of a document was compared."""

    commands: int = 0
    numbers: int = 0
    files: list[str] = field(default_factory=list)


def blocks(path: Path) -> Iterator[Block]:
    name, language, start, lines = "", None, 0, []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        fence, file = FENCE.match(line), FILE.match(line)
        if language is None:
            if file:
                name = file[1]
            elif fence:
                language, start, lines = fence[1], number + 1, []
            elif line.strip():
                name = ""
        elif line == "```":
            yield Block(language, name, start, "\n".join(lines) + "\n")
            language, name = None, ""
        else:
            lines.append(line)
    assert language is None, f"{path}: a block that begins in line {start} has no end"


def environment() -> dict[str, str]:
    tools = str(Path(sys.executable).parent)
    more = {"PATH": tools + os.pathsep + os.environ["PATH"], "OMP_NUM_THREADS": "1", "MPLBACKEND": "Agg",
            "NO_COLOR": "1", "COLUMNS": "80", "LC_ALL": "C.UTF-8"}  # fmt: skip
    return {**os.environ, **more}


def same_line(expected: str, got: str) -> bool:
    expected, got = " ".join(expected.split()), " ".join(got.split())
    if NUMBER.sub("#", expected) != NUMBER.sub("#", got):
        return False
    pairs = zip(NUMBER.findall(expected), NUMBER.findall(got), strict=True)
    return all(abs(float(a) - float(b)) <= ABSOLUTE + RELATIVE * abs(float(a)) for a, b in pairs)


def matches(expected: list[str], got: list[str]) -> bool:
    if not expected:
        return not got
    if expected[0].strip() == "...":
        return any(matches(expected[1:], got[k:]) for k in range(len(got) + 1))
    return bool(got) and same_line(expected[0], got[0]) and matches(expected[1:], got[1:])


def full(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.strip()]


def run_command(command: str, folder: Path, before: int) -> tuple[int, str]:
    """Exit status and printed text of a line of the shell, `before` is $?. A plain call of spacar runs in this process:
    the imports of some forty processes took most of the time of the tutorial.
    """
    if command.startswith("spacar ") and not re.search(r"[|<>&;$`]", command):
        said = io.StringIO()
        with mock.patch.dict(os.environ, environment()):
            status = main(shlex.split(command)[1:], Environment(io.StringIO(), said, said, os.environ))
        return status, said.getvalue()
    done = subprocess.run(
        ["bash", "-c", f"(exit {before}); {command}"], cwd=folder, env=environment(), text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300, check=False, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    return done.returncode, done.stdout


def run_console(block: Block, folder: Path, where: str, count: Count) -> None:
    parts = re.split(r"^\$ (.*)\n", block.text, flags=re.MULTILINE)
    assert not parts[0].strip(), f"{where}: text before the first command"
    commands = list(zip(parts[1::2], parts[2::2], strict=True))
    status = 0
    for k, (command, expected) in enumerate(commands):
        status, printed = run_command(command, folder, status)
        asked = k + 1 < len(commands) and commands[k + 1][0] == "echo $?"
        assert status == 0 or asked, f"{where}: `{command}` ended with status {status}:\n{printed}"
        shown = f"{where}: `{command}` printed\n{printed}\ninstead of\n{expected}"
        assert matches(full(expected), full(printed)), shown
        count.commands += 1
        count.numbers += len(NUMBER.findall(expected))


def run_python(block: Block, names: dict[str, Any], where: str, count: Count) -> None:
    if ">>>" not in block.text:
        exec(compile(block.text, where, "exec"), names)
        return
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    test = doctest.DocTestParser().get_doctest(block.text, names, where, where, block.line)
    runner = doctest.DocTestRunner(checker=Checker(), optionflags=flags)
    said = io.StringIO()
    runner.run(test, out=said.write, clear_globs=False)
    names.update(test.globs)
    assert runner.summarize(verbose=False).failed == 0, said.getvalue()
    count.commands += len(test.examples)
    count.numbers += sum(len(NUMBER.findall(e.want)) for e in test.examples)


class Checker(doctest.OutputChecker):
    """Numbers of a doctest have the tolerance of the console blocks."""

    def check_output(self, want: str, got: str, optionflags: int) -> bool:
        return super().check_output(want, got, optionflags) or same_line(want, got)


def run_document(path: Path, folder: Path, names: dict[str, Any] | None = None) -> Count:
    """Run a document in `folder`; raises AssertionError with the place of the first difference."""
    count, names = Count(), {} if names is None else names
    with in_folder(folder):
        for block in blocks(path):
            where = f"{path.name}:{block.line}"
            if block.name:
                Path(folder, block.name).write_text(block.text, encoding="utf-8")
                count.files.append(block.name)
            elif block.language == "console":
                run_console(block, folder, where, count)
            elif block.language == "python":
                run_python(block, names, where, count)
    return count


@contextlib.contextmanager
def in_folder(folder: Path) -> Iterator[None]:
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def broken_links(path: Path) -> list[str]:
    """Relative links and pictures of a document that point nowhere, section names included."""
    text = re.sub(r"^```.*?^```$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    bad = []
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if "://" in target:
            continue
        file, _, section = target.partition("#")
        other = path.parent / file if file else path
        if not other.exists() or (section and section not in sections(other)):
            bad.append(target)
    return bad


def sections(path: Path) -> set[str]:
    """Names that links can use, by the rule of the usual Markdown renderers."""
    heads = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.strip().lower()).replace(" ", "-") for h in heads}
