"""The text of derivatives.c, made with SymPy when the package is built (`element_texts`).

What statics and linearized equations need beside kernels.c, from the same definitions (theory-system.md section 0):

    NAME_geometric(x, s, p, D)             Hs[i][j] = d/dx_j sum_e s_e V[e][i]
    NAME_rates(x, v, p, D)                 H1[e][j] = d/dx_j sum_i V[e][i] v_i
    NAME_second_rates(x, v, p, D)          T[e][j] = d/dx_j H(v,v)[e]
    NAME_inertia_gradient(x, v, a, p, D)   d(M a + h)/dx, then dh/dv: 2 n_coordinates columns; types with mass only
    NAME_flow_gradient(x, v, p, D)         the same of the force of a fluid

Every function is a straight-line program and its tangent. The program gives what is differentiated: for Hs one reverse
pass of D with s as seeds, for H1 and T first and second derivatives along v carried forward. Factors of the tangent do
not depend on the direction and stand in front of the loop over the directions, which has products and sums only. So the
text grows by the size of the program, not by the number of coordinates, and nothing is expanded.

Structural zeros are not written. A type that has a function of a type before it (`owner`) gets no second text.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import sympy as sp

from spacar.compiled.generator.generate import (
    Program,
    constant,
    declared,
    forward,
    localized,
    made_of,
    named,
    needed,
    owner,
    printed,
    pull,
    shared,
    slope,
    stated,
    straight,
    symbols_of,
    table_of,
)
from spacar.elements import definitions
from spacar.elements.definition_symbolic import Definition

TABLES = {  # table -> what it is made of in kernels.c, its vectors
    "geometric": ("strain", "xsp"),
    "rates": ("strain", "xvp"),
    "second_rates": ("strain", "xvp"),
    "inertia_gradient": ("inertia", "xvap"),
    "flow_gradient": ("flow", "xvp"),
}


def text(own: dict[str, list[str]]) -> str:
    """The whole C text; `own`: functions of every type."""
    parts = [part for definition in definitions() for part in own[definition.name]]
    return "\n".join([*parts, *tables()])


def functions(definition: Definition) -> Iterator[str]:
    """C text of the functions of one type that are its own."""
    for table, (what, _) in TABLES.items():
        if what in made_of(definition) and owner(definition, what) is definition:
            yield function(definition, table)


def tables() -> Iterator[str]:
    """C text of the tables by which the functions are found."""
    for name, (what, vectors) in TABLES.items():
        yield from table_of(what, name, arguments(vectors))
    yield "/* The kinds that have functions here: NumPy evaluates what was added to kernels.c alone. */"
    yield f'static const char DERIVED[] = "{" ".join(definition.name for definition in definitions())}";'


def arguments(vectors: str) -> str:
    return ", ".join([*(f"const real *{letter}" for letter in vectors), "real *D"])


# -- what is differentiated -----------------------------------------------------------------------------------------
def program_of(definition: Definition, table: str) -> tuple[Program, list[sp.Expr], list[sp.Symbol]]:
    """A program, its results, and by what they are differentiated."""
    x, v, p = symbols_of(definition)
    if table == "geometric":
        return *geometric(definition, x, p), x
    if table in ("rates", "second_rates"):
        return *rates(definition, x, v, p, second=table == "second_rates"), x
    if table == "inertia_gradient":
        return *inertia(definition, x, v, p), [*x, *v]
    return *flow(definition, x, v, p), [*x, *v]


def geometric(definition: Definition, x: list, p: dict) -> tuple[Program, list[sp.Expr]]:
    """sum_e s_e V[e][i]."""
    first, z = localized(definition, x, p)
    D = definition.strain(z, p)
    program, results = straight(D, first)
    program = elementary(program)
    force, statements = pull(program, dict(zip(results, sp.symbols(f"s:{len(D)}", real=True), strict=True)), x, "b")
    if definition.slips:
        stress = sp.symbols(f"s{len(D)}:{len(D) + 2}", real=True)
        for j in range(len(x)):
            rows = definition.slips(x, [sp.Integer(i == j) for i in range(len(x))], p)
            force[j] += sum(s * row for s, row in zip(stress, rows, strict=True))
    return program + statements, force


def rates(definition: Definition, x: list, v: list, p: dict, second: bool) -> tuple[Program, list[sp.Expr]]:
    """V v, or H(v,v)."""
    first, z = localized(definition, x, p)
    slips = definition.slips(x, v, p) if definition.slips else []
    D = definition.strain(z, p)
    program, results = straight([*D, *slips], first)
    strains, slipping = results[: len(D)], results[len(D) :]
    moving = dict(zip(x, v, strict=True))
    program, rate = carried(elementary(program), moving, "w")
    once = [rate.get(r, sp.Integer(0)) for r in strains] + slipping
    if not second:
        return program, once
    program, rate = carried(program, moving, "o")
    return program, [rate_of(r, rate) for r in once]


def carried(program: Program, rates: dict, prefix: str) -> tuple[Program, dict[sp.Symbol, sp.Expr]]:
    """The program with its rates of change, and the rate of every symbol that has one."""
    steps, rate = Steps(prefix), dict(rates)
    for symbol, expression in program:
        steps.state(symbol, expression)
        value = steps.signed(rate_of(expression, rate, steps.signed))
        if value != 0:
            rate[symbol] = value
    return steps.program, rate


def rate_of(
    expression: sp.Expr, rate: dict[sp.Symbol, sp.Expr], factor: Callable[[sp.Expr], sp.Expr] = sp.sympify
) -> sp.Expr:
    """Rate of an expression from those of its symbols; `factor` gives what stands for a factor."""
    moving = [a for a in sorted(expression.free_symbols, key=str) if a in rate]
    return sp.Add(*(factor(slope(expression, a)) * rate[a] for a in moving))


def elementary(program: Program) -> Program:
    """The same in elementary steps."""
    steps = Steps("u")
    for symbol, expression in program:
        steps.state(symbol, expression)
    return steps.program


class Steps:
    """A program in elementary steps: sums of products of symbols, and functions of symbols. None is made twice."""

    def __init__(self, prefix: str) -> None:
        self.program: Program = []
        self.prefix = prefix
        self._known: dict[sp.Expr, sp.Symbol] = {}

    def state(self, symbol: sp.Symbol, expression: sp.Expr) -> None:
        """The next statement."""
        flat = self._flat(expression)
        self.program.append((symbol, flat))
        if not flat.is_Atom:
            self._known.setdefault(flat, symbol)

    def signed(self, expression: sp.Expr) -> sp.Expr:
        """A symbol for an expression, with its sign, or a number."""
        if expression.could_extract_minus_sign():
            return -self._atom(-expression)
        return self._atom(expression)

    def _atom(self, expression: sp.Expr) -> sp.Expr:
        flat = self._flat(expression)
        if flat.is_Atom:
            return flat
        if flat not in self._known:
            self.state(sp.Symbol(f"{self.prefix}{len(self.program)}", real=True), flat)
        return self._known[flat]

    def _flat(self, expression: sp.Expr) -> sp.Expr:
        if expression.is_Add:
            return sp.Add(*(self._product(term) for term in expression.args))
        return self._product(expression)

    def _product(self, expression: sp.Expr) -> sp.Expr:
        if expression.is_Mul:
            return sp.Mul(*(self._factor(factor) for factor in expression.args))
        return self._factor(expression)

    def _factor(self, expression: sp.Expr) -> sp.Expr:
        if expression.is_Atom:
            return expression
        if expression.is_Pow:
            base, exponent = expression.args
            if exponent.is_Integer:
                return sp.Pow(self.signed(base), exponent)
            root = sp.sqrt(self.signed(base))
            return root if 2 * exponent == 1 else sp.Pow(self._atom(root), 2 * exponent)
        if expression.is_Function:
            return expression.func(*map(self.signed, expression.args))
        return self.signed(expression)


def inertia(definition: Definition, x: list, v: list, p: dict) -> tuple[Program, list[sp.Expr]]:
    """M a + h."""
    a = list(sp.symbols(f"a:{len(x)}", real=True))
    if definition.inertia:
        M, h = definition.inertia(x, v, p)
        return straight(list(M * sp.Matrix(a) + sp.Matrix(h)), [])
    assert definition.line is not None
    y, C = definition.line(x, p)
    program, results = straight(y, [])
    statements, _, bends = forward(program, results, x, v, a)
    return _pulled(program, statements, results, C * sp.Matrix(bends), x)


def flow(definition: Definition, x: list, v: list, p: dict) -> tuple[Program, list[sp.Expr]]:
    """The force of the fluid (`generate.flow`)."""
    assert definition.line is not None
    assert definition.flow is not None
    y, _ = definition.line(x, p)
    n = len(y) // 4  # position and tangent at p, the same at q; planar tubes have more
    D, A = (sp.kronecker_product(matrix, sp.eye(n)) for matrix in definition.flow(p))
    program, results = straight(y[: 4 * n], [])
    statements, along, _ = forward(program, results, x, v)
    place, tangent, far, other = (results[k * n : (k + 1) * n] for k in range(4))
    from_p = [*[sp.Integer(0)] * n, *tangent, *(b - a for a, b in zip(place, far, strict=True)), *other]
    return _pulled(program, statements, results, D * sp.Matrix(along) + A * sp.Matrix(from_p), x)


def _pulled(
    program: Program, statements: Program, results: list, force: sp.Matrix, x: list
) -> tuple[Program, list[sp.Expr]]:
    """A program and what else a force on its results is made of, and that force on x."""
    then, forces = named("f", force)
    total, back = pull(program, dict(zip(results, forces, strict=True)), x, "b")
    return program + statements + then + back, total


# -- its tangent ----------------------------------------------------------------------------------------------------
class TangentProgram:
    """Statements of the tangent of a program, and the factors they need in front of the loop."""

    def __init__(self, by: Sequence[sp.Symbol]) -> None:
        self.factors: dict[sp.Expr, sp.Symbol] = {}
        self.statements: Program = []
        self.of: dict[sp.Symbol, sp.Expr] = {s: sp.Symbol(f"D_{s.name}", real=True) for s in by}

    def extend(self, symbol: sp.Symbol, expression: sp.Expr) -> None:
        value = self.along(expression)
        if value != 0:
            self.of[symbol] = stated(self.statements, f"D_{symbol.name}", value)

    def along(self, expression: sp.Expr) -> sp.Expr:
        return rate_of(expression, self.of, self._factor)

    def _factor(self, value: sp.Expr) -> sp.Expr:
        if value.is_Number or value.is_Symbol:
            return value
        if value.could_extract_minus_sign():
            return -self._factor(-value)
        return self.factors.setdefault(value, sp.Symbol(f"m{len(self.factors)}", real=True))


def function(definition: Definition, table: str) -> str:
    """One C function."""
    vectors = TABLES[table][1]
    program, results, by = program_of(definition, table)
    tangent = TangentProgram(by)
    for symbol, expression in program:
        tangent.extend(symbol, expression)
    columns = {f"D[{i * len(by)} + j]": tangent.along(sp.sympify(value)) for i, value in enumerate(results)}
    columns = {place: value for place, value in columns.items() if value != 0}
    statements, columns = needed(tangent.statements, columns)
    used = set().union(*(v.free_symbols for v in (*columns.values(), *(v for _, v in statements))))
    factors = {symbol.name: value for value, symbol in tangent.factors.items() if symbol in used}
    # what the loop takes from the program itself
    factors |= {s.name: s for s, _ in program if s in used}
    scalars, factors = shared(*needed(program, factors))
    lines = [f"static void {definition.name}_{table}({arguments(vectors)})", "{"]
    if not columns:
        return "\n".join([*lines, *(f"    (void){letter};" for letter in (*vectors, "D")), "}"])
    inside = used.union(*(v.free_symbols for v in (*factors.values(), *(v for _, v in scalars))))
    lines += declared(list(vectors), inside)
    own = {name for name, _ in scalars}
    named_factors = [(name, value) for name, value in factors.items() if sp.Symbol(name, real=True) not in own]
    lines += [f"    const real {name} = {constant(value)};" for name, value in [*scalars, *named_factors]]
    lines.append(f"    for (int j = 0; j < {len(by)}; j++) {{")
    lines += [
        f"        const real {seed} = EVERY(j == {k});" for k, s in enumerate(by) if (seed := tangent.of[s]) in used
    ]
    lines += [f"        const real {name} = {printed(value)};" for name, value in statements]
    lines += [f"        {place} = {printed(value)};" for place, value in columns.items()]
    return "\n".join([*lines, "    }", "}"])
