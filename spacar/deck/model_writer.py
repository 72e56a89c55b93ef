"""Writes `model_statements.py`: a method for every keyword, made from the keyword table.

`python -m spacar.deck.model_writer > spacar/deck/model_statements.py`. The methods stand in a file, and are not made
when the program runs, so that editors complete them and mypy checks calls.

Signatures: `model_arguments`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from textwrap import wrap

from spacar.deck.findings import alternatives
from spacar.deck.keyword_table import ELEMENT_TYPES, KEYWORDS
from spacar.deck.model_arguments import (
    Argument,
    argument_name,
    continues,
    element_arguments,
    method_name,
    statement_arguments,
)
from spacar.deck.reference import rules
from spacar.deck.rewrite.divide import PAIRS
from spacar.deck.section_block import ROWS
from spacar.deck.table_types import Keyword, Parameter, Variant

WIDTH = 120

def rows() -> Iterator[Keyword]:
    """One row for every method: the forms of a keyword of the third block are the same in all of its kinds."""
    seen: set[str] = set()
    for row in KEYWORDS.values():
        if row.block.number == 3:
            if row.name in seen:
                continue
            seen.add(row.name)
        yield row


def takes_section(keyword: str) -> bool:
    """Whether BEAMSEC is for this type of element."""
    return keyword in PAIRS and ELEMENT_TYPES[keyword].coefficients in ROWS


def _method(row: Keyword) -> list[str]:
    name, block = method_name(row.name, row.block.number), row.block.number
    named: list[Argument] = []
    repeated: Argument | None = None
    element = row.name in ELEMENT_TYPES
    if element:
        arguments = element_arguments(row.name)
    else:
        arguments, named, repeated = statement_arguments(row)
    some = bool(row.variants[1:]) and not element and not _one_list(row)
    signature = ["self", *(_declared(a) for a in arguments)]
    if repeated is not None:
        signature.append(f"*{repeated.name}: {repeated.kind}")
    signature += ["*values: float"] * some
    signature += [_declared(a) for a in named]
    words = [f'"{row.name}"', str(block)]
    words += [f"*{a.name}" if a.count > 1 and a.required else _passed(a) for a in arguments]
    if repeated is not None:
        words.append(f"*{repeated.name}")
    words += ["*values"] * some
    if named:
        pairs = [f'"{a.name}": {a.name}' for a in named]
        words += [f"named={{{pairs[0]}", *pairs[1:-1], f"{pairs[-1]}}}"]
    result = "int" if element else "None"
    lines = _wrapped(f"    def {name}(", signature, ",", f") -> {result}:")
    if element and takes_section(row.name):
        signature += ["*", "section: str | None = None", "material: str | None = None", "parts: int = 1"]
        lines = _wrapped(f"    def {name}(", signature, ",", ") -> int:")
    lines += _documentation(row, arguments, named, repeated)
    lines += _wrapped("        self.statement(", words, ",", ")")
    if element and takes_section(row.name):
        lines.append("        self.of_section(number, section, material, parts)")
    if element:
        lines.append("        return number")
    return lines


def _one_list(row: Keyword) -> bool:
    longest = max((v.parameters for v in row.variants), key=len)
    return all(continues(longest, v.parameters) for v in row.variants)


def _declared(a: Argument) -> str:
    return f"{a.name}: {a.kind}" if a.required else f"{a.name}: {a.kind} | None = None"


def _passed(a: Argument) -> str:
    return f"*(() if {a.name} is None else {a.name})" if a.count > 1 else a.name


def _wrapped(head: str, items: Sequence[str], sign: str, tail: str) -> list[str]:
    """`head(items)tail` in lines of 120 characters."""
    line = head + f"{sign} ".join(items) + tail
    if len(line) <= WIDTH:
        return [line]
    indent = " " * (len(head) - len(head.lstrip()) + 4)
    body = [indent]
    for item in items:
        if len(body[-1]) + len(item) + 2 > WIDTH:
            body.append(indent)
        body[-1] += f"{item}{sign} "
    return [head, *(b.rstrip() for b in body), " " * (len(indent) - 4) + tail]


def _documentation(
    row: Keyword, arguments: Sequence[Argument], named: Sequence[Argument], repeated: Argument | None
) -> list[str]:
    lines = [f"{row.name}: {row.help}."]
    if row.name in ELEMENT_TYPES and not any(rule.startswith("Deformation modes") for rule in rules(row)):
        modes = ", ".join(f"{i} {n} [{u}]" for i, (n, u) in enumerate(ELEMENT_TYPES[row.name].modes, 1))
        lines += ["", *wrap(f"Deformation modes: {modes}.", WIDTH - 8)]
    shown = [*arguments, *([repeated] if repeated else [])]
    if shown:
        width = max(len(a.name) for a in shown) + 2
        lines.append("")
        for a in shown:
            first, *rest = wrap(a.repeated_text if a is repeated else a.text, WIDTH - 8 - width)
            lines += [f"{a.name:<{width}}{first}", *(f"{'':<{width}}{r}" for r in rest)]
    if row.name in ELEMENT_TYPES and takes_section(row.name):
        lines += ["", *wrap("section, material and parts: its BEAMSEC, names of `section` and `material`.", WIDTH - 8)]
    if row.variants[1:] and row.name not in ELEMENT_TYPES and not _one_list(row):
        how = "In the order of the deck"
        if named:
            how += ", or by name (what has no name is zero, or its default)"
        lines += ["", f"{how}:"]
        for v in row.variants:
            skip = sum(a.count for a in arguments)
            what = "; ".join(_shown(p, bool(named)) for p in v.parameters[skip:])
            lines += wrap(f"{_whom(v)}: {what}", WIDTH - 8, initial_indent="- ", subsequent_indent="  ")
    for rule in rules(row):
        lines += ["", *wrap(rule, WIDTH - 8)]
    lines = [line.replace("\\", "\\\\").replace('"""', "'''") for line in lines]
    if len(lines) == 1:
        return [f'        """{lines[0]}"""']
    return [f'        """{lines[0]}', *(f"        {line}".rstrip() for line in lines[1:]), '        """']


def _shown(p: Parameter, named: bool) -> str:
    unit = f" [{p.unit}]" if p.unit else ""
    default = "" if p.default is None else f" = {p.default:g}"
    name = argument_name(p)
    said = not named or name in p.meaning.split() or p.meaning == "not used"
    return f"{p.meaning}{unit}{default}" if said else f"{name} ({p.meaning}){unit}{default}"


def _whom(v: Variant) -> str:
    role = f"{v.role} node" if v.role else ""
    words = [v.space, role, ", ".join(v.types)]
    return " ".join(w for w in words if w) or f"{alternatives(v.counts)} arguments"


HEAD = '''"""A method for every keyword of the input language: the base of `Model`.

This file is made from the keyword table by `python -m spacar.deck.model_writer`; do not edit it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

from spacar.arrays import Array
from spacar.deck.statement import Value

Vector = Sequence[float] | Array


class ModelStatements(ABC):
    """One method a keyword; `statement` and `of_section` are those of the model that collects them."""

    @abstractmethod
    def statement(
        self, keyword: str, block: int, *values: Value | None, named: Mapping[str, Value | None] | None = None
    ) -> None:
        """Take in one statement of a block (1, 2 or 3)."""

    @abstractmethod
    def of_section(self, number: int, section: str | None, material: str | None, parts: int) -> None:
        """The BEAMSEC of an element, when it has one."""
'''


def source() -> str:
    """The text of the module."""
    lines = [HEAD]
    for row in rows():
        lines += [*_method(row), ""]
    return "\n".join(lines).rstrip("\n") + "\n"


if __name__ == "__main__":
    print(source(), end="")
