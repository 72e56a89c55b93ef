"""A name of a class or a file means one thing in the whole program, so that a reader knows the room from the name."""

import ast
import re
from collections import defaultdict
from pathlib import Path

from spacar_cli.command_table import COMMANDS

HOUSE = Path(__file__).resolve().parents[1]
FILES = [p for room in ("spacar", "formats", "cli") for p in sorted((HOUSE / room).rglob("*.py"))]
CLASS = re.compile(r"^\s*class\s+(\w+)", re.MULTILINE)
COMMAND_ROOM = HOUSE / "cli" / "spacar_cli" / "commands"


def place(path: Path) -> str:
    return path.relative_to(HOUSE).as_posix()


def test_no_class_name_stands_twice():
    """A statement begins its line: where no two lines name one class, nothing need be parsed."""
    lines, found = defaultdict(list), defaultdict(list)
    texts = {path: path.read_text(encoding="utf-8") for path in FILES}
    for path, text in texts.items():
        for name in CLASS.findall(text):
            lines[name].append(path)
    for path in {path for places in lines.values() if len(places) > 1 for path in places}:
        for node in ast.walk(ast.parse(texts[path])):
            if isinstance(node, ast.ClassDef):
                found[node.name].append(place(path))
    twice = {name: files for name, files in found.items() if len(files) > 1}
    assert not twice


def test_no_file_name_stands_twice():
    """The module of a command has the name of the command, whatever the module that does the work is called."""
    found = defaultdict(list)
    for path in FILES:
        command = path.parent == COMMAND_ROOM and path.stem in COMMANDS
        if path.stem != "__init__" and not command:
            found[path.stem].append(place(path))
    twice = {name: files for name, files in found.items() if len(files) > 1}
    assert not twice


def test_no_file_has_the_name_of_another_folder():
    """Its own folder may have its name: `mechanism/mechanism.py` has what the folder is about."""
    folders = {path.parent for path in FILES if path.name == "__init__.py"}
    both = [
        place(path)
        for path in FILES
        for folder in folders
        if path.stem == folder.name and path.parent != folder and path.parent != COMMAND_ROOM
    ]
    assert not both
