"""Text to a checked expression. All that does not depend on a result is refused here."""

import ast
from collections.abc import Mapping
from dataclasses import dataclass

from spacar.errors import UsageError
from spacar.expressions.functions import FUNCTIONS

LONGEST = 500  # characters of an expression: bounds the depth of its tree and the time to read it
X_NAMES = ("x", "xd", "xdd", "fx", "fxgrav", "fxtot", "xcompl", "xerr")
E_NAMES = ("e", "ed", "edd", "sig")
VECTORS, MATRICES = ("eigval", "frequency", "lmult"), ("m0", "c0", "d0", "k0", "n0", "g0")
ALIASES = {"fxt": "fxtot"}  # its name in the .sbd file
INDICES = {
    **dict.fromkeys((*X_NAMES, *ALIASES, *E_NAMES), 2), **dict.fromkeys(VECTORS, 1), **dict.fromkeys(MATRICES, 2),
}  # fmt: skip
MEANING = {
    "x": "coordinate", "xd": "velocity", "xdd": "acceleration", "fx": "applied force", "fxgrav": "gravity force",
    "fxtot": "force", "fxt": "force", "xcompl": "compliance", "xerr": "estimated error", "e": "deformation",
    "ed": "deformation rate", "edd": "deformation acceleration", "sig": "stress resultant", "eigval": "eigenvalue",
    "frequency": "natural frequency", "lmult": "load multiplier", "t": "time",
}  # fmt: skip
More = Mapping[str, tuple[int, ...]]
NOTHING_MORE: More = {}
OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow)
EXAMPLES = "write for example x[6,1], sig[1,1], t, x[6,1]-x[3,1], hypot(x[6,1],x[6,2]), max(abs(e[2,1])), x[6,1]@end"


@dataclass(frozen=True)
class Expression:
    """A checked expression."""

    text: str
    tree: ast.expr

    @property
    def variable(self) -> str:
        """The name of the variable when the expression is a single one, else empty."""
        single = self.tree.value if isinstance(self.tree, ast.Subscript) else self.tree
        return single.id if isinstance(single, ast.Name) and single.id != "pi" else ""


def parse(text: str, more: More = NOTHING_MORE) -> Expression:
    """Raises UsageError with the reason for a text that is no expression.

    `more`: variables that only the caller knows, with the numbers of indices that they may have.
    """
    text = text.strip()
    if len(text) > LONGEST:
        raise wrong(f"{text[:30]}...", f"it has {len(text)} characters, {LONGEST} are allowed")
    if "\\" in text:
        raise wrong(text, "a backslash has no meaning")
    try:
        tree = ast.parse(text, mode="eval").body
        _check(tree, text, more)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise wrong(text, f"{getattr(error, 'msg', 'it cannot be read')}; {EXAMPLES}") from None
    return Expression(text, tree)


def wrong(text: str, why: str) -> UsageError:
    return UsageError(f"cannot read '{text}', it is no expression: {why}", "expression.form")


def _check(node: ast.expr, text: str, more: More) -> None:
    parts: list[ast.expr] = []
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool) or not isinstance(node.value, (int, float)):
            raise wrong(text, f"{node.value!r} is not a number")
    elif isinstance(node, ast.Name):
        if node.id not in ("t", "pi"):
            raise _name(node.id, text, more)
    elif isinstance(node, ast.Subscript):
        if not isinstance(node.value, ast.Name) or node.value.id not in (*INDICES, *more):
            name = f"{node.value.id} is not a variable; " if isinstance(node.value, ast.Name) else ""
            raise wrong(text, f"{name}variables with indices are {', '.join((*INDICES, *more))}")
        indices(node, text, more)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        parts = [node.operand]
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        parts = [node.left]
        when(node.right, text)
    elif isinstance(node, ast.BinOp) and isinstance(node.op, OPERATORS):
        parts = [node.left, node.right]
    elif isinstance(node, ast.Call):
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name not in FUNCTIONS:
            raise wrong(text, f"{f'{name} is not a function; ' * bool(name)}functions are {', '.join(FUNCTIONS)}")
        count = FUNCTIONS[name].arguments
        if len(node.args) != count or node.keywords:
            raise wrong(text, f"{name} takes {count} argument{'s' * (count > 1)}")
        parts = node.args
    else:
        raise wrong(text, f"{type(node).__name__} is not allowed; {EXAMPLES}")
    for part in parts:
        _check(part, text, more)


def _name(name: str, text: str, more: More) -> UsageError:
    if name in INDICES:
        form, count = (f"{name}[i, j]", "two numbers") if INDICES[name] == 2 else (f"{name}[i]", "a number")
        return wrong(text, f"{name} needs {count} in brackets; write {form}{_meant(name)}")
    known = ", ".join((*INDICES, *more))
    return wrong(text, f"{name} is not a variable: '{name}' is not known; variables are t, {known}")


def _meant(name: str) -> str:
    """What the two numbers of a variable are."""
    if name in (*X_NAMES, *ALIASES, *E_NAMES):
        return f": {'element and mode' if name in E_NAMES else 'node and coordinate'} number, as {name}[6,1]"
    return ""


def indices(node: ast.Subscript, text: str, more: More = NOTHING_MORE) -> tuple[int, ...]:
    """The numbers in the brackets of a known variable, checked."""
    assert isinstance(node.value, ast.Name)
    name = node.value.id
    parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
    values = [p.value if isinstance(p, ast.Constant) else None for p in parts]
    if any(isinstance(p, ast.Slice) or not (type(v) is int and v >= 1) for p, v in zip(parts, values, strict=True)):
        raise wrong(text, f"indices are whole numbers from 1{_meant(name)}")
    counts = more.get(name) or (INDICES[name],)
    if len(values) not in counts:
        many = "indices" if counts[-1] > 1 else "index"
        takes = " or ".join(map(str, counts))
        raise wrong(text, f"{name} takes {takes} {many}, not {len(values)}{_meant(name)}")
    return tuple(v for v in values if isinstance(v, int))


def when(node: ast.expr, text: str) -> str | int | float:
    """The step that stands after @."""
    if isinstance(node, ast.Name) and node.id in ("start", "end"):
        return node.id
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return node.value  # type: ignore[return-value]
    raise wrong(text, "after @ stands end, start, the number of a step or a time such as 0.05")
