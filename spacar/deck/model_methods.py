"""The methods of `Model`: one for every keyword, made from the keyword table; their arguments: `model_arguments`.

`python -m spacar.deck.model_methods FILE` writes the stub that declares them for editors and type checkers, as
hatch_build.py does.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from inspect import Parameter as Given
from inspect import Signature
from pathlib import Path
from textwrap import indent, wrap
from typing import Any

from spacar.deck.findings import alternatives
from spacar.deck.keyword_table import ELEMENT_TYPES, KEYWORDS
from spacar.deck.model_arguments import (
    Argument,
    argument_name,
    element_arguments,
    is_one_list,
    method_name,
    statement_arguments,
)
from spacar.deck.reference import rules
from spacar.deck.rewrite.divide import PAIRS
from spacar.deck.section_block import ROWS
from spacar.deck.table_types import Keyword, Parameter

WIDTH = 112  # of a description


def methods() -> Iterator[Callable[..., int | None]]:
    for row in rows():
        yield _element(row) if row.name in ELEMENT_TYPES else _statement(row)


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


def _element(row: Keyword) -> Callable[..., int | None]:
    """The method of an element type; it returns the number of the element."""
    arguments, has_section = element_arguments(row.name), takes_section(row.name)
    declared = [_declared(a) for a in arguments]
    if has_section:
        declared += [
            Given(name, Given.KEYWORD_ONLY, default=default, annotation=kind) for name, kind, default in SECTION
        ]

    def method(self: Any, *values: Any, **by_name: Any) -> int:
        given = _bound(method, self, values, by_name)
        self.statement(row.name, row.block.number, *_words(arguments, given))
        if has_section:
            self.of_section(given["number"], *(given[name] for name, *_ in SECTION))
        return int(given["number"])

    return _described(method, row, declared, "int", _documentation(row, arguments, [], None))


def _statement(row: Keyword) -> Callable[..., int | None]:
    arguments, named, repeated = statement_arguments(row)
    declared = [_declared(a) for a in arguments]
    more = repeated.name if repeated else "values" if row.variants[1:] and not is_one_list(row) else ""
    if more:
        declared.append(Given(more, Given.VAR_POSITIONAL, annotation=repeated.kind if repeated else "float"))
    declared += [_declared(a, Given.KEYWORD_ONLY if more else Given.POSITIONAL_OR_KEYWORD) for a in named]

    def method(self: Any, *values: Any, **by_name: Any) -> None:
        given = _bound(method, self, values, by_name)
        numbers = [*_words(arguments, given), *given.get(more, ())]
        of_names = {"named": {a.name: given[a.name] for a in named}} if named else {}
        self.statement(row.name, row.block.number, *numbers, **of_names)

    return _described(method, row, declared, "None", _documentation(row, arguments, named, repeated))


# arguments of an element that has BEAMSEC: name, type, default
SECTION = (("section", "str | None", None), ("material", "str | None", None), ("parts", "int", 1))


def _bound(method: Any, model: Any, values: Sequence[Any], by_name: dict[str, Any]) -> dict[str, Any]:
    """All arguments by name, those that are left out with their defaults."""
    try:
        bound = method.__signature__.bind(model, *values, **by_name)
    except TypeError as error:
        raise TypeError(f"{method.__name__}(): {error}") from None
    bound.apply_defaults()
    return dict(bound.arguments)


def _words(arguments: Sequence[Argument], given: dict[str, Any]) -> list[Any]:
    words: list[Any] = []
    for a in arguments:
        value = given[a.name]
        if a.count == 1:
            words.append(value)
        elif a.required or value is not None:
            words += value
    return words


def _described(method: Any, row: Keyword, declared: list[Given], result: str, lines: list[str]) -> Any:
    method.__name__ = method_name(row.name, row.block.number)
    method.__qualname__ = f"ModelStatements.{method.__name__}"
    method.__module__ = "spacar.deck.keyword_methods"
    method.__doc__ = "\n".join(lines)
    own = Given("self", Given.POSITIONAL_OR_KEYWORD)
    method.__signature__ = Signature([own, *declared], return_annotation=result)
    return method


def _declared(a: Argument, kind: Any = Given.POSITIONAL_OR_KEYWORD) -> Given:
    if a.required:
        return Given(a.name, kind, annotation=a.kind)
    return Given(a.name, kind, default=None, annotation=f"{a.kind} | None")


def _documentation(
    row: Keyword, arguments: Sequence[Argument], named: Sequence[Argument], repeated: Argument | None
) -> list[str]:
    lines = [f"{row.name}: {row.help}."]
    if row.name in ELEMENT_TYPES and not any(rule.startswith("Deformation modes") for rule in rules(row)):
        modes = ", ".join(f"{i} {n} [{u}]" for i, (n, u) in enumerate(ELEMENT_TYPES[row.name].modes, 1))
        lines += ["", *wrap(f"Deformation modes: {modes}.", WIDTH)]
    shown = [*arguments, *([repeated] if repeated else [])]
    if shown:
        width = max(len(a.name) for a in shown) + 2
        lines.append("")
        for a in shown:
            first, *rest = wrap(a.repeated_text if a is repeated else a.text, WIDTH - width)
            lines += [f"{a.name:<{width}}{first}", *(f"{'':<{width}}{r}" for r in rest)]
    if row.name in ELEMENT_TYPES and takes_section(row.name):
        lines += ["", *wrap("section, material and parts: its BEAMSEC, names of `section` and `material`.", WIDTH)]
    if row.variants[1:] and row.name not in ELEMENT_TYPES and not is_one_list(row):
        how = "In the order of the deck"
        if named:
            how += ", or by name (what has no name is zero, or its default)"
        lines += ["", f"{how}:"]
        for v in row.variants:
            skip = sum(a.count for a in arguments)
            what = "; ".join(_shown(p, bool(named)) for p in v.parameters[skip:])
            whom = " ".join(v.scope) or f"{alternatives(v.counts)} arguments"
            lines += wrap(f"{whom}: {what}", WIDTH, initial_indent="- ", subsequent_indent="  ")
    for rule in rules(row):
        lines += ["", *wrap(rule, WIDTH)]
    return lines


def _shown(p: Parameter, named: bool) -> str:
    unit = f" [{p.unit}]" if p.unit else ""
    default = "" if p.default is None else f" = {p.default:g}"
    name = argument_name(p)
    said = not named or name in p.meaning.split() or p.meaning == "not used"
    return f"{p.meaning}{unit}{default}" if said else f"{name} ({p.meaning}){unit}{default}"


STUB = """# made from the keyword table by spacar.deck.model_methods
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

from spacar.arrays import Array
from spacar.deck.statement import Value

Vector = Sequence[float] | Array

class ModelStatements(ABC):
    @abstractmethod
    def statement(
        self, keyword: str, block: int, *values: Value | None, named: Mapping[str, Value | None] | None = None
    ) -> None: ...
    @abstractmethod
    def of_section(self, number: int, section: str | None, material: str | None, parts: int) -> None: ...
"""


def stub() -> str:
    parts = [STUB]
    for method in methods():
        described = indent(f'r"""{method.__doc__}\n"""', "        ")
        parts.append(f"    def {method.__name__}{Signature.from_callable(method)}:\n{described}\n")
    return "".join(parts)


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(stub(), encoding="utf-8")
