"""Every situation of reference/keywords.md section 10 is reported, with its line, and nothing else goes
wrong."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from spacar.deck import parse_deck
from spacar.errors import InputError, Message

_SPEC = importlib.util.spec_from_file_location("deck_rows", Path(__file__).with_name("rows.py"))
assert _SPEC is not None
assert _SPEC.loader is not None
rows = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(rows)


def messages_of(text: str, mode: int | None) -> list[Message]:
    try:
        return list(parse_deck(text, "<deck>", mode).messages)
    except InputError as error:
        return error.messages


@pytest.mark.parametrize("row", rows.ROWS, ids=lambda r: r.name)
def test_row(row) -> None:
    messages = messages_of(row.text, row.mode)
    lines = [str(m) for m in messages if m.severity == row.severity]
    assert any(all(f in line for f in row.fragments) for line in lines), "\n".join(map(str, messages))
    if row.severity != "error":
        assert not [m for m in messages if m.severity == "error"]


def test_one_mistake_gives_one_error() -> None:
    """A wrong word must not be reported several times; only one row holds two mistakes."""
    double = {"wheel in mode 2"}  # has no trajectory either
    for row in rows.ROWS:
        errors = [m for m in messages_of(row.text, row.mode) if m.severity == "error"]
        if row.severity == "error" and row.name not in double:
            assert len(errors) == 1, (row.name, *map(str, errors))


def test_base_decks_are_right() -> None:
    for text in (rows.planar(), rows.spatial(), rows.arm(), rows.bar(), rows.TROLLEY + rows.END):
        assert [str(m) for m in messages_of(text, None)] == []
