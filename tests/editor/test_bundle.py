"""The component of the editor is the file that was made, with licences of everything in it."""

import json
import re
from hashlib import sha256
from pathlib import Path

EDITOR = Path(__file__).parents[2] / "cli" / "spacar_cli" / "editor"
PAGE, MADE = EDITOR / "page", EDITOR / "bundle"


def packages() -> dict[str, str]:
    head = (PAGE / "codemirror.js").read_text("utf-8").partition("*/")[0]
    return dict(re.findall(r"([@\w/.-]+) (\d+\.\d+\.\d+)", head.partition(" of ")[2]))


def test_its_checksum_is_the_one_that_was_written_when_it_was_made():
    digest, name = (PAGE / "codemirror.sha256").read_text("ascii").split()
    assert digest == sha256((PAGE / name).read_bytes()).hexdigest()


def test_its_packages_are_pinned_and_their_licences_are_there():
    """The lock has their digests; what is asked for is one version, not a range."""
    lock = json.loads((MADE / "package-lock.json").read_text("utf-8"))["packages"]
    asked = json.loads((MADE / "package.json").read_text("utf-8"))["devDependencies"]
    licences = (PAGE / "codemirror.LICENSE").read_text("utf-8")
    assert len(packages()) > 5
    for name, version in packages().items():
        row = lock[f"node_modules/{name}"]
        assert row["version"] == version
        assert row["license"] == "MIT"
        assert row["integrity"].startswith("sha512-")
        assert f"{name} {version}\n" in licences
    for name, version in asked.items():
        assert re.fullmatch(r"\d+\.\d+\.\d+", version), name
    assert licences.count("Permission is hereby granted") == len(packages())


def test_nothing_of_ours_is_long():
    """No file of more than 400 lines, no line above 120 characters."""
    ours = [p for p in (*PAGE.iterdir(), *EDITOR.glob("*.py"), *MADE.glob("*.mjs")) if "codemirror" not in p.name]
    ours += list((EDITOR.parents[1] / "spacar_drawing").glob("viewer*.js"))
    for path in ours:
        lines = path.read_text("utf-8").splitlines()
        assert len(lines) <= 400, path
        assert max(map(len, lines)) <= 120, path
