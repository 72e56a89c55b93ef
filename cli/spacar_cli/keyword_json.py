"""The keyword table as JSON, for editors: `spacar keywords --to`, `spacar edit`, a TextMate grammar."""

from __future__ import annotations

from typing import Any

from spacar_drawing.settings_check import RULES

from spacar.deck.keyword_table import ALIASES, ELEMENT_TYPES, KEYWORDS, blocks_of
from spacar.deck.table_types import Keyword, subject_of
from spacar_cli.keyword_help import explanation, scope

ENDS = ("END", "HALT", "VISUALIZATION")  # words between the blocks
NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eEdD][+-]?[0-9]+)?"


def keywords_json() -> dict[str, Any]:
    """keywords, aliases, settings of pictures, words between blocks; every keyword with help, forms and subject."""
    names = dict.fromkeys(name for name, _ in KEYWORDS)
    return {
        "keywords": {name: _record([KEYWORDS[name, block] for block in blocks_of(name)]) for name in names},
        "aliases": ALIASES,
        "settings": {name: {"help": rule.help, "text": _text(name)} for name, rule in RULES.items()}, "ends": ENDS,
    }  # fmt: skip


def _record(rows: list[Keyword]) -> dict[str, Any]:
    name = rows[0].name
    subject, of_element = subject_of(rows[0])
    record: dict[str, Any] = {
        "blocks": [row.block.number for row in rows],
        "help": rows[0].help,
        "text": _text(name),
        "subject": None if subject is None else ["element" if of_element else "node", subject],
        "forms": [
            {"scope": scope(v).rstrip(": "), "parameters": [[p.text, p.of] for p in v.parameters]}
            for row in rows for v in row.variants
        ],
    }  # fmt: skip
    if name in ELEMENT_TYPES:
        record["nodes"] = len(ELEMENT_TYPES[name].nodes)
    return record


def _text(name: str) -> str:
    return "\n".join(explanation(name)).rstrip()


def textmate_grammar() -> dict[str, Any]:
    """A grammar for editors that read those of TextMate (Visual Studio Code, Sublime Text, JetBrains ...)."""
    table = keywords_json()
    elements = [name for name, row in table["keywords"].items() if "nodes" in row]
    others = [name for name in (*table["keywords"], *table["aliases"]) if name not in elements]

    def words(names: list[str] | tuple[str, ...], scope: str) -> dict[str, str]:
        longest_first = sorted(names, key=lambda name: (-len(name), name))
        return {"match": rf"(?i)(?<!\S)(?:{'|'.join(longest_first)})(?=[\s%#;]|$)", "name": f"{scope}.spacar"}

    return {
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "SPACAR input",
        "scopeName": "source.spacar",
        "fileTypes": ["dat", "spv"],
        "patterns": [
            {"match": "[%#;].*$", "name": "comment.line.spacar"},
            words(elements, "entity.name.type"),
            words(ENDS, "keyword.control"),
            words(others, "keyword.other"),
            words(list(table["settings"]), "support.type"),
            {"match": rf"(?<!\S){NUMBER}(?=[\s%#;]|$)", "name": "constant.numeric.spacar"},
        ],
    }
