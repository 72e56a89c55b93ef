"""The hand-written element families against the SymPy definitions, which share nothing with them but the theory.

Every kind at random configurations and velocities, as the generated text computes it: deformations, V (once more by
complex steps of the definition), H(v,v) (once more by complex steps of the family), M and h. The bound 1e-11 is
relative to the largest entry: both sides are straight evaluations in double precision, of formulas with cancellation of
a few digits.
"""

import numpy as np
import pytest

from spacar import Deck
from spacar.elements import definitions
from spacar.elements.family import arc_tangent
from spacar.elements.spatial.angle_measure import rotation_factor
from spacar.mechanism import build

sp = pytest.importorskip("sympy")

from sympy.printing.numpy import NumPyPrinter  # noqa: E402

from spacar.compiled.generator import generate  # noqa: E402

AT = [("X", 1, 0.1, -0.2), ("X", 3, 1.0, 0.3)]
IN_SPACE = [("X", 1, 0.1, -0.2, 0.3), ("X", 3, 1.0, 0.3, 0.2)]
LAW = ("ESTIFF", 1, 400.0, 0.3, 1.0, 2.0, 0.001, 0.002)
PIPE = ("EM", 1, 0.3, 0.2, 0.5, 1.1, 3.0)
TUBE = ("TUBE", 1, 1, 2, 3, 4, 0.0, 1.0, 0.2, 0.01)
CURVED = ("ORTUBE", 1, 0.9, 0.1, 0.3, 0.8, 0.4, -0.3, 0.1, 0.2, 1.0)
BEAM = ("BEAM", 1, 1, 2, 3, 4, 0.0, 1.0, 0.2, 0.01)
WARPED = ("BEAMW", 1, 1, 2, 5, 3, 4, 6, 0.0, 1.0, 0.2, 0.01)
CENTRE = [("X", 1, 0.1, -0.2, 0.5), ("X", 3, 0.1, -0.2, 0.0)]
RB = ("PINBODY", 1, 1, 2, 3)
ELASTIC = [("DYNE", 1, *range(1, 7)), ("ADEFORM",)]
MODELS: dict[str, tuple[list[tuple], list[tuple]]] = {  # form: kinematics, dynamics
    "PLBEAM": ([("PLBEAM", 1, 1, 2, 3, 4), *AT], [("EM", 1, 0.3, 0.02), ("ESTIFF", 1, 4.0, 5.0, 0.1)]),
    "PLBEAM angle": ([("PLBEAM", 1, 1, 2, 3, 4), *AT, ("ADEFORM",)], [("EM", 1, 0.3), ("ESTIFF", 1, 4.0, 5.0, 0.1)]),
    "PLTUBE": ([("PLTUBE", 1, 1, 2, 3, 4, 0.2, -0.3), *AT], [PIPE]),
    "PLTUBE angle": ([("PLTUBE", 1, 1, 2, 3, 4, 0.2, -0.3), *AT, ("ADEFORM",)], [PIPE]),
    "PLTRUSS": ([("PLTRUSS", 1, 1, 3), *AT], []),
    "PLTOR": ([("PLTOR", 1, 1, 2)], []),
    "PLPINBOD": ([("PLPINBOD", 1, 1, 2, 3), *AT], []),
    "PLRBEAM": ([("PLRBEAM", 1, 1, 2, 3), *AT], []),
    "PLWHEEL": ([("PLWHEEL", 1, 1, 2, 3, 0.4, -0.3, 1.0)], []),
    "PLBELT": ([("PLBELT", 1, 1, 2, 3, 4, 0.3, -0.1), *AT], [("EM", 1, 0.4, 2.0, 1.5)]),
    "BEAM": ([BEAM, *IN_SPACE], [("EM", 1, 0.3), LAW]),
    "BEAM angle": ([BEAM, *IN_SPACE, *ELASTIC], [("EM", 1, 0.3), LAW]),
    "TUBE": ([TUBE, CURVED, *IN_SPACE], [PIPE, LAW]),
    "TUBE angle": ([TUBE, CURVED, *IN_SPACE, *ELASTIC], [PIPE, LAW]),
    "BEAMW": ([WARPED, *IN_SPACE], [("EM", 1, 0.3), LAW]),
    "BEAMW angle": ([WARPED, *IN_SPACE, ("ADEFORM",)], [("EM", 1, 0.3), LAW]),
    "TRUSS": ([("TRUSS", 1, 1, 3), *IN_SPACE], []),
    "HINGE": ([("HINGE", 1, 1, 2, 0.3, 1.0, 0.2)], []),
    "PINBODY": ([RB, *IN_SPACE], []),
    "RBEAM": ([("RBEAM", *RB[1:]), *IN_SPACE], []),
    "SCREW": ([("SCREW", 1, 1, 2, 3, 4, 0.3, 1.0, 0.2, 0.05), *IN_SPACE], []),
    "WHEEL": ([("WHEEL", 1, 1, 2, 3, 0.3, 1.0, 0.0), *CENTRE], []),
    "TWHEEL": ([("TWHEEL", 1, 1, 2, 3, 0.5, 0.1, 0.3, 1.0, 0.0), *CENTRE], []),
    "normalization": ([BEAM, *IN_SPACE], []),
    "rigid body": ([BEAM, *IN_SPACE], [("XM", 2, 0.3, 0.01, 0.02, 0.4, 0.03, 0.5)]),
}


def family_of(form):
    kinematics, dynamics = MODELS[form]
    mechanism = build(Deck.build(kinematics, [*dynamics, ("TIMESTEP", 0.1, 1)]), 1)
    (batch,) = [b for b in mechanism.batches if b.family.keyword == form.removesuffix(" angle")]
    return batch.family, mechanism.x0[batch.x]


FUNCTIONS = {
    "atan2": arc_tangent, "sqrt": np.sqrt, "sin": np.sin, "cos": np.cos, "pi": np.pi,
    **{f"turn{k}": (lambda c, k=k: rotation_factor(c)[k]) for k in range(3)},
}  # fmt: skip


class Printer(NumPyPrinter):
    """Names without their modules."""

    def _print_Function(self, expression):
        return f"{type(expression).__name__}({', '.join(map(self._print, expression.args))})"

    _print_sin = _print_cos = _print_atan2 = _print_Function
    _print_turn0 = _print_turn1 = _print_turn2 = _print_Function


printed = Printer({"fully_qualified_modules": False}).doprint


def evaluate(program, wanted, numbers):
    """The wanted expressions behind all statements of a straight-line program, (wanted, cases)."""
    known = {str(name): value for name, value in numbers.items()} | FUNCTIONS
    exec("\n".join(f"{name} = {printed(value)}" for name, value in program), known)
    values = [eval(printed(sp.sympify(w)), known) for w in wanted]
    return np.array(np.broadcast_arrays(*values, next(iter(numbers.values())))[:-1])


def close(got, want):
    want = want.reshape(got.shape)
    np.testing.assert_allclose(got, want, rtol=0, atol=1e-11 * max(1.0, np.abs(want).max(initial=0.0)))


def test_every_kind_has_a_definition_and_a_model():
    assert {d.name for d in definitions()} == {family_of(form)[0].definition for form in MODELS}


LONG = ("BEAM", "BEAM angle", "TUBE", "TUBE angle", "BEAMW", "BEAMW angle")
A_SECOND = ("PLBEAM angle", "PLTUBE angle", "PLBELT", "SCREW")


@pytest.mark.parametrize("form", [
    pytest.param(f, marks=[pytest.mark.slow] * (f in LONG + A_SECOND)) for f in MODELS
])  # fmt: skip
def test_family_agrees_with_its_definition(form):
    """Two cases of the same element."""
    family, x0 = family_of(form)
    (definition,) = [d for d in definitions() if d.name == family.definition]
    n, m, rng = definition.n_coordinates, family.n_deformations, np.random.default_rng(7)
    x, v = x0 + 0.1 * rng.standard_normal((n, 2)), rng.standard_normal((n, 2))
    xs, vs, p = symbols = generate.symbols_of(definition)
    numbers = dict(zip([*xs, *vs, *p.values()], [*x, *v, *family.parameters()], strict=True))
    cases = [by_family(family, x[:, k : k + 1], v[:, k : k + 1]) for k in range(2)]
    e, V, h, mass, force = (np.concatenate(parts, axis=-1) for parts in zip(*cases, strict=True))
    if m:
        program, *wanted = generate.strains(definition, *symbols)
        close(e, evaluate(program, wanted[0], numbers))
        entries = np.zeros_like(V)
        entries[tuple(np.array(list(wanted[1])).T)] = evaluate(program, wanted[1].values(), numbers)
        close(V, entries)
        close(h, evaluate(program, wanted[2], numbers))
    rows = [r for r in range(m) if r not in family.slips]
    if rows:
        first, z = generate.localized(definition, xs, p)
        moved = {s: value if s in p.values() else np.tile(value, n) for s, value in numbers.items()}
        for j, symbol in enumerate(xs):
            moved[symbol] = moved[symbol] + 1e-30j * (np.arange(2 * n) // 2 == j)
        by_steps = evaluate(first, definition.strain(z, p), moved).imag / 1e-30
        close(V[rows], by_steps.reshape(len(rows), n, 2))
    if mass.size:
        program, M, convected = generate.inertia(definition, *symbols)
        close(mass, evaluate(program, list(M), numbers))
        expected = evaluate(program, convected, numbers)
        if definition.flow:
            expected = expected + evaluate(*generate.flow(definition, *symbols), numbers)
        close(force, expected)


def by_family(family, x, v):
    """e, V, H(v,v), M and h; H(v,v) of all rows is V of a complex step along v, times v."""
    n, m = family.n_coordinates, family.n_deformations
    e, V, h, near = np.zeros((m, 1)), np.zeros((m, n, 1)), np.zeros((m, 1)), np.zeros((m, 1))
    c = family.strain(x, near, e, V)
    W = np.zeros(V.shape, complex)
    if not family.constant_gradient and m:
        family.convective_strain(c, v, h)
        family.strain(x + 1e-30j * v, near, np.zeros((m, 1), complex), W)
    close(h, (W.imag * v).sum(1) / 1e-30)
    if not family.has_mass or family.constant_mass:
        return e, V, h, np.zeros((0, 1)), np.zeros((0, 1))
    mass = np.zeros((n, n, 1))
    family.mass(c, mass)
    return e, V, h, mass, family.inertia_force(c, v, None)
