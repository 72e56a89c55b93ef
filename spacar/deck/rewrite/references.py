"""What the numbers of a statement name, by the keyword table: all programs that rewrite statements ask here.

A number names an element or a node where the table says so of its position, never because it equals one. Keyword, block
and number of values tell the positions; of TRFRONT the trajectory tells what has a path, an element or a node.
"""

from collections.abc import Callable, Sequence
from functools import cache
from itertools import islice, takewhile

from spacar.deck.keyword_table import KEYWORDS, blocks_of
from spacar.deck.statement import Statement, Value
from spacar.deck.table_types import NODE_OR_ELEMENT

ELEMENT, NODE = "element", "node"
MOVED = {"TRE": ELEMENT, "TROT": NODE, "TRANS": NODE, "TRCIRL": NODE}  # path -> what it moves


@cache
def _places(keyword: str, block: int, count: int) -> tuple[tuple[int, str], ...]:
    row = KEYWORDS[keyword, next(kind for kind in blocks_of(keyword) if kind.number == block)]
    variant = next((v for v in row.variants if count in v.counts), row.variants[0])
    kinds = [p.of if p.of in (ELEMENT, NODE_OR_ELEMENT) else NODE for p in variant.parameters]
    return tuple((i, kinds[i]) for i in range(count) if kinds[i] in variant.parameters[i].of)


def places(s: Statement) -> tuple[tuple[int, str], ...]:
    """The values (from 0) of a statement that name something, with what they name: ELEMENT, NODE or NODE_OR_ELEMENT."""
    return _places(s.keyword, s.block, len(s.values))


def named(s: Statement, kind: str) -> tuple[int, ...]:
    """The elements, or nodes, that a statement names."""
    return tuple([s.integer(i) for i, of in places(s) if of == kind])


def about(s: Statement) -> int | None:
    """The element that a statement is about: the first that it names."""
    return next(iter(named(s, ELEMENT)), None)


def renumbered(
    statements: Sequence[Statement], element: Callable[[int], int], node: Callable[[int], int]
) -> list[Statement]:
    """The same statements, in file order, with other numbers of elements and nodes."""
    new = {ELEMENT: element, NODE: node}
    paths: dict[int, Callable[[int], int]] = {}
    found = []
    for k, s in enumerate(statements):
        if s.keyword == "TRAJECT":
            moved = takewhile(lambda o: o.keyword != "TRAJECT", islice(statements, k + 1, None))
            paths = {o.integer(0): new[MOVED[o.keyword]] for o in moved if o.keyword in MOVED}
        values = list(s.values)
        for i, of in places(s):
            number = s.integer(i)
            values[i] = (paths.get(number, node) if of == NODE_OR_ELEMENT else new[of])(number)
        found.append(s._replace(values=tuple(values)))
    return found


def made(origin: Statement, *values: Value, keyword: str = "", block: int = 0) -> Statement:
    """A statement that another one stands for: messages about it name the line of that one; it has no columns."""
    return Statement(keyword or origin.keyword, values, block or origin.block, origin.line)
