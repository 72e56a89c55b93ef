"""The hand-written element families against the SymPy definitions, which share nothing with them but the theory.

The bound 1e-11 is relative to the largest entry: both sides are straight evaluations in double precision, of formulas
with cancellation of a few digits.
"""

from pathlib import Path

import numpy as np
import pytest

import spacar

sp = pytest.importorskip("sympy")

from spacar.compiled import generate  # noqa: E402
from spacar.compiled.definitions import DEFINITIONS  # noqa: E402
from spacar.compiled.element_parameters import SUPPORTED, kinds  # noqa: E402

DATA = Path(__file__).parents[2] / "data"
SOURCES = ["crankfl", "fourbar", "finger", "trike2", "cardan", "robotsim", "trike3v", "lateral4", "crosshingew"]


def batches():
    """One batch of every compiled kind from the example models."""
    found = {}
    for name in SOURCES:
        for batch in spacar.frames(1, DATA / f"{name}.dat").mechanism.batches:
            if batch.family.keyword in SUPPORTED:
                kind, parameters = SUPPORTED[batch.family.keyword]
                if kind not in found or (batch.family.has_mass and not found[kind][0].family.has_mass):
                    found[kind] = (batch, parameters(batch.family))
    return found


BATCHES = batches()
LARGE = ("beam", "beam_angle", "beamw")  # seconds in SymPy
BY_NAME = {d.name: d for d in DEFINITIONS}


def test_every_kind_has_a_definition():
    assert {d.name for d in DEFINITIONS} == set(kinds())


@pytest.mark.parametrize("kind", [pytest.param(k, marks=[pytest.mark.slow] * (k in LARGE)) for k in sorted(BATCHES)])
def test_family_agrees_with_its_definition(kind):
    batch, parameters = BATCHES[kind]
    definition, family = BY_NAME[kind], batch.family
    n, rng = definition.n_coordinates, np.random.default_rng(7)
    x = reference(batch) + 0.1 * rng.standard_normal((n, family.n))
    v = rng.standard_normal((n, family.n))
    xs, vs = list(sp.symbols(f"x:{n}", real=True)), list(sp.symbols(f"v:{n}", real=True))
    p = {name: sp.Symbol(f"p{k}", real=True) for k, name in enumerate(definition.parameters)}
    numbers = dict(zip([*xs, *vs, *p.values()], [*x, *v, *parameters], strict=True))
    D = definition.strain(xs, p)
    e, V, h = np.zeros((len(D), family.n)), np.zeros((len(D), n, family.n)), np.zeros((len(D), family.n))
    c = family.strain(x, np.zeros_like(e), e, V)
    if D:
        program, results = generate.straight(D)
        rows, adjoint = generate.reverse(program, results, xs)
        rates, second = generate.forward(program, results, xs, vs)
        known = evaluate(program + adjoint + rates, numbers)
        family.convective_strain(c, v, h)
        close(e, results, known)
        close(V, [entry for row in rows for entry in row], known)
        close(h, second, known)
    if family.has_mass and not family.constant_mass:
        program, M, convected = generate.inertia(definition, xs, vs, p)
        known = evaluate(program, numbers)
        mass = np.zeros((n, n, family.n))
        family.mass(c, mass)
        close(mass, list(M), known)
        close(family.inertia_force(c, v, None), convected, known)


def evaluate(program, numbers):
    """All statements of a straight-line program, as arrays over the elements."""
    known = dict(numbers)
    for name, value in program:
        known[name] = number(value, known)
    return known


def number(expression, known):
    expression = sp.sympify(expression)
    symbols = sorted(expression.free_symbols, key=str)
    return sp.lambdify(symbols, expression, "numpy")(*(known[s] for s in symbols))


def reference(batch):
    """Coordinates of the start configuration, (n_coordinates, n)."""
    for name in SOURCES:
        mechanism = spacar.frames(1, DATA / f"{name}.dat").mechanism
        for other in mechanism.batches:
            if other.family.keyword == batch.family.keyword and np.array_equal(other.x, batch.x):
                return mechanism.x0[batch.x]
    raise AssertionError


def close(got, expressions, known):
    values = [np.broadcast_to(np.asarray(number(e, known), float), got.shape[-1:]) for e in expressions]
    want = np.array(values).reshape(got.shape)
    np.testing.assert_allclose(got, want, atol=1e-11 * max(1.0, np.abs(want).max()))


COMMITTED = (Path(generate.__file__).parent / "kernels.c").read_text()


@pytest.mark.parametrize("name", [name for name in BY_NAME if name not in LARGE])
def test_the_committed_functions_are_the_generated_ones(name):
    assert "\n".join([*generate.functions(BY_NAME[name]), ""]) in COMMITTED


def test_the_committed_tables_are_the_generated_ones():
    assert "\n".join(generate.tables([BY_NAME[kind] for kind in kinds()])) in COMMITTED


@pytest.mark.slow
def test_the_committed_kernels_are_the_generated_ones():
    assert generate.kernels().strip() == COMMITTED.strip()
