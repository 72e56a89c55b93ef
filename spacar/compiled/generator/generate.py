"""The text of kernels.c, made with SymPy when the package is built (`element_texts`).

Up to seven functions per element type:

    NAME_strain(x, p, e, V)          e = D(x), V = dD/dx row by row (structural zeros are not written); slips: e = 0
    NAME_convective(x, v, p, h)      H(v,v) = d^2 D(x + s v)/ds^2 at s = 0; of slips dW(x + s v)/ds v
    NAME_inertia(x, v, p, M, h)      M = Y^T C Y, h = Y^T C d^2 y(x + s v)/ds^2; types with mass only
    NAME_flow(x, v, p, h)            Y^T (D y' + A y), another part of h; types with a fluid only
    NAME_guard(x, p, g)              what shows that the element is in the range of its theory; types with a limit only
    NAME_whole_turn(p, s)            change of D in a whole turn; types that count turns only
    NAME_angle(x, e, p, a)           the angle in which these are counted, where that is not e[0]

D is first turned into a straight-line program (common subexpressions), behind the local coordinates that it is a
function of. V comes from it in reverse, H(v,v) by carrying first and second derivatives along v forward, so the text
stays small. What the statements then still share is named once more. A type that has a function of a type before it
(`owner`) gets no second text. At the end stand the tables of the functions and the largest sizes.
Numbers are of type `real`: one double, or LANES doubles of as many cases (lanes.c).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any

import sympy as sp
from sympy.printing.c import C99CodePrinter

from spacar.elements import definitions
from spacar.elements.definition_symbolic import Definition

Program = list[tuple[sp.Symbol, sp.Expr]]


class LanePrinter(C99CodePrinter):
    """C text that is valid for vectors too: no pow, own names of the functions."""

    def _print_Pow(self, expr: sp.Pow) -> str:
        base, exponent = expr.base, expr.exp
        if exponent.is_negative:
            return f"1.0/({self._print(base**-exponent)})"
        if not (2 * exponent).is_Integer:
            raise ValueError(f"a power that is not a multiple of 1/2: {expr}")
        text = self.parenthesize(base, 999)
        factors = [text] * int(exponent) + [f"lanes_sqrt({self._print(base)})"] * (exponent.q == 2)
        return f"({'*'.join(factors)})" if len(factors) > 1 else factors[0]

    def _print_Function(self, expr: sp.Function) -> str:
        return f"lanes_{type(expr).__name__}({', '.join(map(self._print, expr.args))})"

    _print_sin = _print_cos = _print_atan2 = _print_Function
    _print_turn0 = _print_turn1 = _print_turn2 = _print_turn3 = _print_Function


printed = LanePrinter()._print  # `doprint` first looks for what no expression here has


def text(own: dict[str, list[str]]) -> str:
    """The whole C text; `own`: functions of every type."""
    parts = [part for definition in definitions() for part in (*own[definition.name], "")]
    return "\n".join([*parts, *tables()])


TABLES = {  # table -> arguments of its functions
    "strain": "const real *x, const real *p, real *e, real *V",
    "convective": "const real *x, const real *v, const real *p, real *h",
    "inertia": "const real *x, const real *v, const real *p, real *M, real *h",
    "flow": "const real *x, const real *v, const real *p, real *h",
    "guard": "const real *x, const real *p, real *g",
    "whole_turn": "const real *p, real *s",
    "angle": "const real *x, const real *e, const real *p, real *a",
}


def made_of(definition: Definition) -> dict[str, tuple[Any, ...]]:
    """What the functions of a type are made of; only the functions that it has."""
    d, n = definition, definition.n_coordinates
    strain = (n, d.strain, d.local, d.slips) if rows_of(d) else ()
    flow = (n, d.line, d.flow) if d.flow else ()
    parts = {
        "strain": strain,
        "convective": strain,
        "inertia": (n, d.line, d.inertia) if d.line or d.inertia else (),
        "flow": flow,
        "guard": (n, d.guard, d.local) if d.guard else (),
        "whole_turn": (d.turn,) if d.turn else (),
        "angle": (n, d.angle) if d.angle else (),
    }
    return {what: part for what, part in parts.items() if part}


def owner(definition: Definition, what: str) -> Definition:
    """The first type with the same function, whose parameters agree with those of this one as far as both go."""
    for other in definitions():
        agree = all(a == b for a, b in zip(other.parameters, definition.parameters, strict=False))
        if agree and made_of(other).get(what) == made_of(definition)[what]:
            return other
    raise AssertionError(definition.name)


def symbols_of(definition: Definition) -> tuple[list[sp.Symbol], list[sp.Symbol], dict[str, sp.Symbol]]:
    """Coordinates x, rates v, parameters."""
    n = definition.n_coordinates
    x, v = list(sp.symbols(f"x:{n}", real=True)), list(sp.symbols(f"v:{n}", real=True))
    return x, v, {name: sp.Symbol(f"p{k}", real=True) for k, name in enumerate(definition.parameters)}


def localized(definition: Definition, x: list, p: dict) -> tuple[Program, list[sp.Expr]]:
    """The local coordinates, and the program that makes them."""
    if definition.local is None:
        return [], x
    program, z = named("z", sp.Matrix(definition.local(x, p)))
    return program, list(z)


@cache
def rows_of(definition: Definition) -> tuple[int, int]:
    """Numbers of deformations and slips; empty without any."""
    x, v, p = symbols_of(definition)
    slips = len(definition.slips(x, v, p)) if definition.slips else 0
    strains = len(definition.strain(localized(definition, x, p)[1], p))
    return (strains, slips) if strains or slips else ()  # type: ignore[return-value]


def tables() -> Iterator[str]:
    """C text of the enumeration of the kinds, of the sizes and of the tables of functions."""
    types, guards = definitions(), []
    for definition in types:
        x, _, p = symbols_of(definition)
        guards.append(len(definition.guard(localized(definition, x, p)[1], p)) if definition.guard else 0)
    largest = max(definition.n_coordinates for definition in types)
    most = max(sum(rows_of(definition)) for definition in types)
    yield f"enum {{ {', '.join(definition.name.upper() for definition in types)}, N_KINDS }};"
    parameters = max(len(definition.parameters) for definition in types)
    yield f"enum {{ MAX_X = {largest}, MAX_E = {most}, MAX_GUARDS = {max(guards)}, MAX_P = {parameters} }};"
    for what, arguments in TABLES.items():
        yield from table_of(what, what, arguments)
    yield f"static const int N_GUARDS[N_KINDS] = {{ {', '.join(map(str, guards))} }};"
    counts = " ".join(f"{d.name}/{len(d.parameters)}" for d in types)
    yield "/* Names of the kinds and numbers of their parameters: Python evaluates what is not here. */"
    yield f'static const char KINDS[] = "{counts}";'


def table_of(what: str, name: str, arguments: str) -> Iterator[str]:
    """C text of the table of the functions `name`, which types with `what` have."""
    yield f"static void (*const {name.upper()}[N_KINDS])({arguments}) = {{"
    for definition in definitions():
        if what in made_of(definition):
            yield f"    [{definition.name.upper()}] = {owner(definition, what).name}_{name},"
    yield "};"


def placed(array: str, values: Sequence[sp.Expr]) -> dict[str, sp.Expr]:
    """Values by their places in an array."""
    return {f"{array}[{i}]": value for i, value in enumerate(values)}


def functions(definition: Definition) -> Iterator[str]:
    """C text of the functions of one type that are its own."""
    n = definition.n_coordinates
    x, v, p = symbols_of(definition)
    own = {what for what in made_of(definition) if owner(definition, what) is definition}
    if "strain" in own:
        program, e, V, h = strains(definition, x, v, p)
        outputs = placed("e", e) | {f"V[{i * n + j}]": w for (i, j), w in V.items()}
        yield function(definition, "strain", program, outputs)
        yield function(definition, "convective", program, placed("h", h))
    if definition.guard and "guard" in own:
        first, z = localized(definition, x, p)
        program, guards = straight(definition.guard(z, p), first)
        yield function(definition, "guard", program, placed("g", guards))
    if "inertia" in own:
        program, M, h = inertia(definition, x, v, p)
        outputs = {f"M[{i * n + j}]": M[i, j] for i in range(n) for j in range(n) if M[i, j] != 0}
        yield function(definition, "inertia", program, outputs | placed("h", h))
    if "flow" in own:
        program, h = flow(definition, x, v, p)
        yield function(definition, "flow", program, placed("h", h))
    if definition.turn and "whole_turn" in own:
        yield function(definition, "whole_turn", [], placed("s", definition.turn(p)))
    if definition.angle and "angle" in own:
        e = list(sp.symbols(f"e:{sum(rows_of(definition))}", real=True))
        program, angle = straight([definition.angle(x, e, p)], [])
        yield function(definition, "angle", program, placed("a", angle))


def strains(
    definition: Definition, x: list, v: list, p: dict
) -> tuple[Program, list[sp.Expr], dict[tuple[int, int], sp.Expr], list[sp.Expr]]:
    """A program for e, the entries of V and H(v,v); these."""
    first, z = localized(definition, x, p)
    D = definition.strain(z, p)
    unit = [[sp.Integer(i == j) for i in range(len(x))] for j in range(len(x))]
    slips = list(zip(*(definition.slips(x, u, p) for u in unit), strict=True)) if definition.slips else []
    places = [(i, j) for i, row in enumerate(slips, len(D)) for j, w in enumerate(row) if w != 0]
    program, results = straight([*D, *(slips[i - len(D)][j] for i, j in places)], first)
    e, W = results[: len(D)], dict(zip(places, results[len(D) :], strict=True))
    rows, adjoint = reverse(program, e, x)
    rates, along, second = forward(program, results, x, v)
    V = {(i, j): w for i, row in enumerate(rows) for j, w in enumerate(row) if w != 0} | W
    h = second[: len(D)] + [sp.Integer(0)] * len(slips)
    for (i, j), rate in zip(places, along[len(D) :], strict=True):
        h[i] += rate * v[j]
    return program + adjoint + rates, e + [sp.Integer(0)] * len(slips), V, h


def straight(expressions: list, first: Program) -> tuple[Program, list[sp.Expr]]:
    """Common subexpressions as a program behind another, and what remains of the expressions, each a symbol."""
    found, results = sp.cse(expressions, symbols=sp.numbered_symbols("t", real=True))
    program, named = [*first, *found], []
    for k, result in enumerate(results):
        symbol = sp.Symbol(f"r{k}", real=True)
        program.append((symbol, sp.sympify(result)))
        named.append(symbol)
    return program, named


def stated(program: Program, name: str, value: sp.Expr) -> sp.Expr:
    """What stands for a value: itself, or the name of a new statement of the program where it is an expression."""
    if value.is_Atom:
        return value
    symbol = sp.Symbol(name, real=True)
    program.append((symbol, value))
    return symbol


def reverse(program: Program, results: list, x: list) -> tuple[list[list[sp.Expr]], Program]:
    """Rows of the gradient and the program of adjoints they need."""
    rows, statements = [], []
    for k, result in enumerate(results):
        row, needed_here = pull(program, {result: sp.Integer(1)}, x, f"b{k}")
        rows.append(row)
        statements += needed_here
    return rows, statements


def pull(program: Program, seeds: dict[sp.Symbol, sp.Expr], x: list, prefix: str) -> tuple[list[sp.Expr], Program]:
    """Gradient of the sum of seeds times what they are of, and the program of adjoints it needs."""
    adjoint = dict(seeds)
    statements: Program = []
    for symbol, expression in reversed(program):
        bar = adjoint.pop(symbol, sp.Integer(0))
        if bar == 0:
            continue
        bar = stated(statements, f"{prefix}_{symbol.name}", bar)
        for argument in sorted(expression.free_symbols, key=str):
            if not argument.name.startswith("p"):
                adjoint[argument] = adjoint.get(argument, sp.Integer(0)) + bar * slope(expression, argument)
    return [adjoint.get(a, sp.Integer(0)) for a in x], statements


@cache
def slope(expression: sp.Expr, by: sp.Symbol) -> sp.Expr:
    """Derivative; every row and both directions ask for the same ones. As `sp.diff`, which takes five times as long."""
    args = expression.args
    if expression.is_Symbol or by not in expression.free_symbols:
        return sp.Integer(expression == by)
    if expression.is_Add:
        return sp.Add(*(slope(term, by) for term in args))
    if expression.is_Mul:
        rates = [slope(factor, by) for factor in args]
        return sp.Add(*(sp.Mul(*args[:i], rate, *args[i + 1 :]) for i, rate in enumerate(rates) if rate != 0))
    if expression.is_Pow and expression.exp.is_Number:
        return expression * (slope(expression.base, by) * expression.exp / expression.base)
    return sp.Add(*(expression.fdiff(i) * slope(a, by) for i, a in enumerate(args, 1)))


def jacobian(y: Sequence[sp.Expr], x: list[sp.Symbol]) -> sp.Matrix:
    return sp.Matrix([[slope(sp.sympify(value), a) for a in x] for value in y])


def forward(
    program: Program, results: list, x: list, v: list, a: Sequence[sp.Symbol] = ()
) -> tuple[Program, list[sp.Expr], list[sp.Expr]]:
    """Program of first and second derivatives along x + s v + s^2 a/2 at s = 0, and those of the results."""
    first: dict[sp.Symbol, sp.Expr] = dict(zip(x, v, strict=True))
    second: dict[sp.Symbol, sp.Expr] = dict(zip(x, a, strict=False))
    statements: Program = []
    for symbol, expression in program:
        moving = [a for a in sorted(expression.free_symbols, key=str) if a in first]
        rate, bend = sp.Integer(0), sp.Integer(0)
        for k, a in enumerate(moving):
            by_a = slope(expression, a)
            rate += by_a * first[a]
            bend += by_a * second.get(a, sp.Integer(0)) + slope(by_a, a) * first[a] ** 2
            bend += sum(2 * slope(by_a, b) * first[a] * first[b] for b in moving[:k])
        for prefix, value, table in (("d", rate, first), ("dd", bend, second)):
            if value != 0:
                table[symbol] = stated(statements, f"{prefix}_{symbol.name}", value)
    along, bends = ([table.get(r, sp.Integer(0)) for r in results] for table in (first, second))
    return statements, along, bends


def inertia(definition: Definition, x: list, v: list, p: dict) -> tuple[Program, sp.Matrix, list]:
    """Program, M and h, from y and C where the type has them."""
    if definition.inertia:
        M, h = definition.inertia(x, v, p)
        return [], M, h
    assert definition.line is not None
    y, C = definition.line(x, p)
    s = sp.Symbol("s")
    shifted = {a: a + s * b for a, b in zip(x, v, strict=True)}
    twice = [slope(slope(f.subs(shifted, simultaneous=True), s), s) for f in y]
    moved = [sp.factor_terms(sp.signsimp(f)).subs(s, 0) for f in twice]  # as `sp.diff` gives it
    first, Y = named("y", jacobian(y, x))
    then, CY = named("c", C * Y)
    last, acceleration = named("a", sp.Matrix(moved))
    return first + then + last, Y.T * CY, list(CY.T * acceleration)


def flow(definition: Definition, x: list, v: list, p: dict) -> tuple[Program, list]:
    """Program and h of the fluid. A does not act on a common translation: positions count from that of p."""
    assert definition.line is not None
    assert definition.flow is not None
    y, _ = definition.line(x, p)
    n = len(y) // 4  # position and tangent at p, the same at q
    at_p, tangent_p, at_q, tangent_q = (sp.Matrix(y[k * n : (k + 1) * n]) for k in range(4))
    D, A = (sp.kronecker_product(matrix, sp.eye(n)) for matrix in definition.flow(p))
    first, Y = named("y", jacobian(y[: 4 * n], x))
    then, from_p = named("f", sp.Matrix([0 * at_p, tangent_p, at_q - at_p, tangent_q]))
    last, force = named("w", D * (Y * sp.Matrix(v)) + A * from_p)
    return first + then + last, list(Y.T * force)


def named(prefix: str, matrix: sp.Matrix) -> tuple[Program, sp.Matrix]:
    """The program of the entries that are more than numbers or symbols, and the matrix with symbols for them."""
    program: Program = []
    out = sp.zeros(*matrix.shape)
    for i in range(matrix.rows):
        for j in range(matrix.cols):
            out[i, j] = stated(program, f"{prefix}{i}_{j}", matrix[i, j])
    return program, out


def shared(program: Program, outputs: dict[str, sp.Expr]) -> tuple[Program, dict[str, sp.Expr]]:
    """The same with every expression that occurs twice named, in an order in which it can be evaluated."""
    names = [name for name, _ in program]
    found, values = sp.cse([*(v for _, v in program), *outputs.values()], symbols=sp.numbered_symbols("c", real=True))
    parts = dict(found)
    done: set[sp.Symbol] = set()
    ordered: Program = []

    def require(expression: sp.Expr) -> None:
        for symbol in sorted(expression.free_symbols, key=str):
            if symbol in parts and symbol not in done:
                done.add(symbol)
                require(parts[symbol])
                ordered.append((symbol, parts[symbol]))

    for name, value in zip(names, values, strict=False):
        require(value)
        ordered.append((name, value))
    rest = dict(zip(outputs, values[len(names) :], strict=True))
    for value in rest.values():
        require(value)
    return ordered, rest


def function(definition: Definition, what: str, program: Program, outputs: dict[str, sp.Expr]) -> str:
    """One C function; every statement of the program that the outputs need is a local constant."""
    arguments = TABLES[what]
    program, outputs = shared(*needed(program, {k: sp.sympify(v) for k, v in outputs.items()}))
    used = set().union(*(v.free_symbols for v in (*outputs.values(), *(v for _, v in program))))
    lines = [f"static void {definition.name}_{what}({arguments})", "{"]
    lines += declared([letter for letter in "xvep" if f"const real *{letter}," in arguments], used)
    lines += [f"    const real {name} = {constant(value)};" for name, value in program]
    lines += [f"    {name} = {constant(value)};" for name, value in outputs.items()]
    return "\n".join([*lines, "}"])


def declared(vectors: Sequence[str], used: set[sp.Symbol]) -> list[str]:
    """C text of the constants that are the numbers of these vectors."""
    lines = []
    for letter in vectors:
        names = [k for k in range(99) if sp.Symbol(f"{letter}{k}", real=True) in used]
        lines += [f"    const real {letter}{k} = {letter}[{k}];" for k in names] or [f"    (void){letter};"]
    return lines


def needed(program: Program, outputs: dict[str, sp.Expr]) -> tuple[Program, dict[str, sp.Expr]]:
    """Without the statements that no output uses."""
    used = set().union(*(e.free_symbols for e in outputs.values()))
    kept = []
    for name, value in reversed(program):
        if name in used:
            used |= value.free_symbols
            kept.append((name, value))
    return kept[::-1], outputs


def constant(value: sp.Expr) -> str:
    """C text; a number alone is spread over the lanes."""
    return f"EVERY({printed(value)})" if value.is_number else str(printed(value))
