"""Collection functions are exact rewrites: expand(before − after) = 0; the Z table keeps order and signs."""

from __future__ import annotations

import pytest
import sympy as sp

from spacar.symbolic import Frame
from spacar.symbolic import collect as co

a, b, c, L, s, t = sp.symbols("a b c L s t")
N, B, C = Frame("N"), Frame("B"), Frame("C")
DOT, OTHER = N[1] & B[1], N[2] & C[3]
EXPRESSION = (a + b * s) * DOT + (c * s - a / L) * OTHER / L**2 + DOT * (s * t + b) ** 2


@pytest.mark.parametrize(
    "rewrite",
    [
        co.loosen_dots,
        co.distribute_scalars,
        co.gather_dots,
        co.gather_vectors,
        co.gather_divisors,
        co.unsquare,
        lambda e: co.gather_scalars(e, [s]),
        lambda e: co.simplify_rhs(e, [s]),
    ],
)
def test_every_rewrite_is_exact(rewrite):
    assert sp.expand(rewrite(EXPRESSION) - EXPRESSION) == 0
    v = EXPRESSION * N[1] + a * (b + c) * (N[1] ^ B[2])
    difference = rewrite(v) - v
    assert all(sp.expand(value) == 0 for value in difference.terms.values())


def test_minimal_divisions_precompute_reciprocals():
    table = co.ZTable()
    after = co.minimal_divisions(EXPRESSION, table)
    assert not any(p.exp < 0 for p in after.atoms(sp.Pow) if p.exp.is_Integer)
    assert sp.expand(table.expand(after) - EXPRESSION) == 0


def test_simplify_rhs_never_lengthens():
    assert sp.count_ops(co.simplify_rhs(EXPRESSION, [s])) <= sp.count_ops(EXPRESSION)


def test_shared_axes_are_merged():
    q = sp.Function("q")(sp.Symbol("t"))
    turned = N.turned("T", 3, q)
    assert len(co.gather_vectors(a * N[3] + b * turned[3]).terms) == 1


def test_z_table_refuses_accelerations_and_double_names():
    table = co.ZTable(forbidden=[t])
    with pytest.raises(ValueError, match="accelerations"):
        table.read(a + t)
    table.read(a + b, name="u")
    with pytest.raises(ValueError, match="already"):
        table.read(a + c, name="u")


def test_linear_parts():
    coefficients, rest = co.split_linear(a * s + b * t + c, [s, t])
    assert (coefficients, rest) == ([a, b], c)
    with pytest.raises(ValueError, match="not linear"):
        co.split_linear(s * t, [s, t])


def test_definition_order_reads_what_is_written():
    x, y, z = sp.symbols("x y z")
    assert co.definition_order({x: y + 1, y: z, z: a}, [x]) == [z, y, x]
    assert co.definition_order({x: y + 1, y: z, z: a}, [y]) == [z, y]
