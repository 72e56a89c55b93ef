"""Reading scalar expressions from text without executing anything.

The text is parsed by Python's `ast` and walked with a white list: numbers, names, + − * / **, parentheses,
`a if x > b else c` and the functions of `FUNCTIONS`; smoothmax(x, w) = (x + √(x² + w²))/2 is for contact,
smoothsign(x, w) = tanh(x/w) for friction. Never `eval`, `sympify` or `parse_expr`. Limits: 2000 characters, depth 100,
exponents of at most 64, finite numbers.
"""

import ast
import difflib
import math
import operator
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from keyword import iskeyword
from typing import Any

import sympy as sp

from spacar.errors import UsageError

FUNCTIONS: dict[str, Any] = {
    "sin": sp.sin, "cos": sp.cos, "tan": sp.tan, "asin": sp.asin, "acos": sp.acos, "atan": sp.atan, "atan2": sp.atan2,
    "sinh": sp.sinh, "cosh": sp.cosh, "tanh": sp.tanh, "sqrt": sp.sqrt, "exp": sp.exp, "log": sp.log, "abs": sp.Abs,
    "sign": sp.sign, "min": sp.Min, "max": sp.Max,
    "smoothmax": lambda x, width: (x + sp.sqrt(x**2 + width**2)) / 2, "smoothsign": lambda x, width: sp.tanh(x / width),
}  # fmt: skip
CONSTANTS: dict[str, sp.Expr] = {"pi": sp.pi}
MAX_CHARACTERS = 2000
MAX_DEPTH = 100
MAX_EXPONENT = 64
MAX_MAGNITUDE = sp.Integer(10) ** 300

_BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}  # fmt: skip
_COMPARE: dict[type, Callable[[Any, Any], Any]] = {ast.Lt: sp.Lt, ast.LtE: sp.Le, ast.Gt: sp.Gt, ast.GtE: sp.Ge}


def read_expression(
    text: str, known: Mapping[str, sp.Expr], unknown: Callable[[str], sp.Expr] | None = None
) -> sp.Expr:
    """The scalar that `text` describes, with the names of `known`.

    Known names may contain points (`link1.tip.u`). `unknown` makes a scalar of any other name; without it such a name
    is an error. Decimal numbers are read exactly. Raises UsageError with a sentence that quotes the offending piece.

    >>> q = sp.Symbol("q")
    >>> read_expression("0.5*q**2 + sin(q)", {"q": q})
    q**2/2 + sin(q)
    """
    if len(text) > MAX_CHARACTERS:
        raise UsageError(f"an expression of {len(text)} characters is too long (at most {MAX_CHARACTERS})")
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else str(error)
        taken = [word for word in re.findall(r"\w+", text) if iskeyword(word) and word not in ("if", "else")]
        if taken:
            reason += f"; '{taken[0]}' cannot be a name in expressions: choose another one"
        raise UsageError(f"cannot read expression '{text}' ({reason})", "syntax") from None
    except (RecursionError, MemoryError):
        raise UsageError(f"cannot read expression: nested deeper than {MAX_DEPTH}", "syntax") from None
    return _ExpressionReader(text.strip(), known, unknown).read(tree.body, 0)


def meant(word: str, known: Iterable[str]) -> str:
    """The question whether the nearest of the known words was meant; "" without one."""
    near = difflib.get_close_matches(word, list(known), n=1)
    return f", did you mean '{near[0]}'?" if near else ""


def read_number(value: float) -> sp.Rational:
    """The decimal number that Python shows for a float, exactly. UsageError when it is not finite."""
    if not math.isfinite(value):
        raise UsageError(f"{value} is not a finite number", "finite")
    return sp.Rational(repr(float(value)))


@dataclass
class _ExpressionReader:
    text: str
    known: Mapping[str, sp.Expr]
    unknown: Callable[[str], sp.Expr] | None

    def read(self, node: ast.AST, depth: int) -> sp.Expr:
        if depth > MAX_DEPTH:
            raise UsageError(f"an expression is nested deeper than {MAX_DEPTH}")
        if isinstance(node, ast.Constant) and type(node.value) in (int, float):
            literal = str(node.value)
            return self._finite(sp.oo if literal in ("inf", "nan") else sp.Rational(literal), node)
        if isinstance(node, ast.Name):
            return self._name(node.id)
        if isinstance(node, ast.Attribute) and self._source(node) in self.known:
            return self.known[self._source(node)]
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
            value = self.read(node.operand, depth + 1)
            return -value if isinstance(node.op, ast.USub) else value
        if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
            return self._binary(node, depth)
        if isinstance(node, ast.IfExp):
            return sp.Piecewise(
                (self.read(node.body, depth + 1), self._condition(node.test, depth)),
                (self.read(node.orelse, depth + 1), True),
            )
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
            return self._call(node, node.func.id, depth)
        raise UsageError(f'"{self._source(node)}" is not allowed in an expression', "forbidden")

    def _condition(self, node: ast.AST, depth: int) -> Any:
        """a < b of two expressions."""
        if isinstance(node, ast.Compare) and len(node.ops) == 1 and type(node.ops[0]) in _COMPARE:
            left, right = self.read(node.left, depth + 1), self.read(node.comparators[0], depth + 1)
            return _COMPARE[type(node.ops[0])](left, right)
        raise UsageError(f'"{self._source(node)}" is not a condition such as x > 0', "forbidden")

    def _source(self, node: ast.AST) -> str:
        return ast.get_source_segment(self.text, node) or self.text

    def _name(self, name: str) -> sp.Expr:
        if name in self.known:
            return self.known[name]
        if name in CONSTANTS:
            return CONSTANTS[name]
        if self.unknown is not None and name not in FUNCTIONS:
            return self.unknown(name)
        raise UsageError(f"unknown name '{name}'{meant(name, (*self.known, *CONSTANTS))}", "name")

    def _binary(self, node: ast.BinOp, depth: int) -> sp.Expr:
        left, right = self.read(node.left, depth + 1), self.read(node.right, depth + 1)
        if isinstance(node.op, ast.Div) and right == 0:
            raise UsageError(f"division by zero in '{self._source(node)}'", "division")
        if isinstance(node.op, ast.Pow):
            if right.is_number and abs(right) > MAX_EXPONENT:
                raise UsageError(f"exponent {right} is too large (at most {MAX_EXPONENT})", "exponent")
            if left == 0 and right.is_number and right < 0:
                raise UsageError(f"division by zero in '{self._source(node)}'", "division")
        return self._finite(_BINARY[type(node.op)](left, right), node)

    def _call(self, node: ast.Call, name: str, depth: int) -> sp.Expr:
        if name not in FUNCTIONS:
            hint = meant(name, FUNCTIONS) or f" (known: {', '.join(FUNCTIONS)})"
            if name.startswith("_"):
                raise UsageError(f'"{self._source(node)}" is not allowed in an expression', "forbidden")
            raise UsageError(f"unknown function '{name}'{hint}", "name")
        number = 2 if name in ("atan2", "min", "max", "smoothmax", "smoothsign") else 1
        if len(node.args) != number and not (name in ("min", "max") and len(node.args) > 2):
            raise UsageError(f"'{name}' takes {number} argument{'s' if number > 1 else ''}, not {len(node.args)}")
        return self._finite(FUNCTIONS[name](*(self.read(a, depth + 1) for a in node.args)), node)

    def _finite(self, value: sp.Expr, node: ast.AST) -> sp.Expr:
        if value.has(sp.oo, -sp.oo, sp.zoo, sp.nan, sp.I):
            raise UsageError(f"'{self._source(node)}' is not a finite real number", "finite")
        if value.is_Rational and abs(value) > MAX_MAGNITUDE:
            raise UsageError(f"'{self._source(node)}' is too large", "finite")
        return value
