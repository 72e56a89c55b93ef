"""Collection functions are exact rewrites: expand(before − after) = 0; the Z table keeps order and signs."""

import random

import pytest
import sympy as sp

from spacar.symbolic import ReferenceFrame, gather_dots, gather_scalars, gather_vectors
from spacar.symbolic import collect as co
from spacar.symbolic.collect import LinearSplit, common_factors

a, b, c, L, s, t = sp.symbols("a b c L s t")
N, B, C = ReferenceFrame("N"), ReferenceFrame("B"), ReferenceFrame("C")
DOT, OTHER = N[1] & B[1], N[2] & C[3]
EXPRESSION = (a + b * s) * DOT + (c * s - a / L) * OTHER / L**2 + DOT * (s * t + b) ** 2


@pytest.mark.parametrize("rewrite", [gather_dots, gather_vectors, gather_scalars, lambda e: gather_scalars(e, [s])])
def test_every_rewrite_is_exact(rewrite):
    assert sp.expand(rewrite(EXPRESSION) - EXPRESSION) == 0
    v = EXPRESSION * N[1] + a * (b + c) * (N[1] ^ B[2])
    difference = rewrite(v) - v
    assert all(sp.expand(value) == 0 for value in difference.terms.values())


def random_sum(chance, depth=3):
    """A nested sum of products with powers of either sign."""
    if depth == 0:
        return sp.Rational(chance.randint(-6, 6), chance.randint(1, 4)) * chance.choice([a, b, c, L, 1 / L]) ** 2 * L
    parts = [random_sum(chance, depth - 1) for _ in range(3)]
    return sp.Add(*(chance.choice([a, b, L**-2, sp.cos(a), L**3]) * part for part in parts)) * chance.choice([a, L])


@pytest.mark.parametrize("seed", range(8))
def test_common_factors_are_exact_and_never_longer(seed):
    e = random_sum(random.Random(seed))
    after = common_factors(e)
    assert sp.expand(after - e) == 0
    assert sp.count_ops(after) <= sp.count_ops(e)


@pytest.mark.parametrize("seed", range(4))
def test_linear_splitting_equals_derivatives(seed):
    chance = random.Random(seed)
    first, second, rest = (random_sum(chance, 2) for _ in range(3))
    e = a * (first * s + c * (second * t + rest)) - L * s
    found, left = LinearSplit([s, t])(e)
    assert sp.expand(found[s] - e.diff(s)) == 0
    assert sp.expand(found[t] - e.diff(t)) == 0
    assert sp.expand(left - e.subs({s: 0, t: 0})) == 0


def test_shared_axes_are_merged():
    q = sp.Function("q")(sp.Symbol("t"))
    turned = N.turned("T", 3, q)
    assert len(gather_vectors(a * N[3] + b * turned[3]).terms) == 1


def test_z_table_refuses_accelerations_and_double_names():
    table = co.ZTable(forbidden=[t])
    with pytest.raises(ValueError, match="accelerations"):
        table.read(a + t)
    table.read(a + b, name="u")
    with pytest.raises(ValueError, match="already"):
        table.read(a + c, name="u")
    with pytest.raises(TypeError):
        co.ZTable("W")  # letters are no accelerations


def test_linear_parts():
    assert co.LinearSplit([s, t])(a * s + b * t + c) == ({s: a, t: b}, c)
    with pytest.raises(ValueError, match="not linear"):
        co.LinearSplit([s, t])(s * t)


def test_definition_order_reads_what_is_written():
    x, y, z = sp.symbols("x y z")
    assert list(co.definition_order({x: y + 1, y: z, z: a}, [x])) == [z, y, x]
    assert list(co.definition_order({x: y + 1, y: z, z: a}, [y])) == [z, y]
