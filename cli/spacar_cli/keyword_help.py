"""The reference of the input language as text, from the keyword table: the list of keywords, and each explained.

The keyword table as JSON, for editors: `spacar keywords --to`, `spacar edit`, a TextMate grammar.
"""

import textwrap
from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any

from spacar_drawing.settings import KINDS, RULES, SPELLINGS
from spacar_formats import sim_blocks

from spacar.deck.findings import alternatives
from spacar.deck.keyword_table import ALIASES, ELEMENT_TYPES, KEYWORDS, blocks_of
from spacar.deck.table_types import BlockKind, Keyword
from spacar.errors import UsageError

WIDTH = 100
PICTURES = "VISUALIZATION section behind the blocks, or NAME.spv; each setting on a line of its own"


def overview() -> Iterator[str]:
    """One line for every keyword, block by block."""
    parts = {block.value: {k.name: k.help for (_, b), k in KEYWORDS.items() if b is block} for block in BlockKind}
    parts[PICTURES] = {name: rule.help for name, rule in RULES.items()}
    parts["blocks of a simulation (.sim)"] = {b.name: b.text for b in sim_blocks.BLOCKS}
    for title, rows in parts.items():
        width = max(map(len, rows))
        yield f"{title}:"
        yield from (f"  {name:<{width}}  {text}" for name, text in rows.items())
        yield ""


def explanation(name: str) -> Iterator[str]:
    """All meanings of a keyword or setting, one for each block where it may stand. Raises UsageError."""
    wanted = ALIASES.get(name.upper(), name.upper())
    setting = SPELLINGS.get(wanted, wanted)
    blocks = blocks_of(wanted)
    if name.lower() in sim_blocks.BY_NAME:
        yield from sim_blocks.explanation(name.lower())
        yield ""
        if not blocks:
            return
    if not blocks and setting not in RULES:
        near = get_close_matches(wanted, {keyword for keyword, _ in KEYWORDS} | set(RULES), 3)
        hint = f"; nearest: {', '.join(near)}" if near else "; `spacar keywords` lists them"
        raise UsageError(f"there is no keyword {name.upper()}{hint}", "usage.keyword")
    for block in blocks:
        yield from _keyword(KEYWORDS[wanted, block])
    if setting in RULES:
        yield from _setting(setting)


def _setting(name: str) -> Iterator[str]:
    rule = RULES[name]
    yield f"{name}: {rule.help}"
    yield f"  {PICTURES}"
    others = [given for given, meant in SPELLINGS.items() if meant == name]
    if others:
        yield f"  also written {', '.join(others)}"
    if rule.groups:
        yield f"  behind a line {' or '.join(rule.groups)}"
    count, what = KINDS[rule.kind]
    behind = what if count is None else f"{count} {what}"
    yield f"  {behind if count != 0 else 'no arguments'}; nothing else stands on the line"
    yield ""


def _keyword(keyword: Keyword) -> Iterator[str]:
    yield f"{keyword.name}: {keyword.help}"
    yield f"  {keyword.block.value}"
    if keyword.aliases:
        yield f"  also written {', '.join(keyword.aliases)}"
    for variant in keyword.variants:
        yield ""
        scope = f"{', '.join(variant.scope)}: " if variant.scope else ""
        yield f"  {scope}{alternatives(variant.counts)} argument{'s' * (set(variant.counts) != {1})}"
        width = max(len(p.text) for p in variant.parameters)
        for position, p in enumerate(variant.parameters, 1):
            default = "" if p.default is None else f"  default {p.default:g}"
            yield f"    {position:>2}  {p.text:<{width}}  {p.kind:<7}{default}".rstrip()
    for note in keyword.notes:
        yield ""
        yield from (f"  {line}" for line in textwrap.wrap(note, WIDTH - 2))
    yield ""


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
    subject = rows[0].subject
    record: dict[str, Any] = {
        "blocks": [row.block.number for row in rows],
        "help": rows[0].help,
        "text": _text(name),
        "subject": None if subject is None else ["element" if rows[0].of_element else "node", subject],
        "forms": [
            {"scope": ", ".join(v.scope), "parameters": [[p.text, p.of] for p in v.parameters]}
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
