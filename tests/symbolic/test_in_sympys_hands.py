"""Held products of unit vectors in SymPy's functions: the same value, or a refusal that says what to do.

Truth: the same function of the transformed expression.
"""

import copy
import pickle

import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

from spacar.errors import UsageError
from spacar.symbolic import ReferenceFrame, transform
from spacar.symbolic.unit_vectors import TIME

q, p = dynamicsymbols("q p", real=True)
x, z, alpha = sp.symbols("x z alpha", real=True)


@pytest.fixture
def frames():
    N = ReferenceFrame("N", "n")
    A = N.turned("A", 3, q, "a")
    return N, A, A.turned("B", 1, p + alpha, "b")


@pytest.fixture
def e(frames):
    N, A, B = frames
    return 3 * (N[1] & A[1]) - 3 * x * (N[1] & A[2]) ** 2 + x**2 * (N[2] & B[2]) + sp.sin(N[1] & A[1])


KEEPING = {
    "simplify": sp.simplify, "doit": lambda e: e.doit(), "copy": copy.copy,
    "deepcopy": copy.deepcopy, "expand": sp.expand,
    "factor": sp.factor, "trigsimp": sp.trigsimp, "powsimp": sp.powsimp,
    "nsimplify": sp.nsimplify, "sympify": sp.sympify,
    "together": lambda e: sp.together(e / x + 1 / z), "collect": lambda e: sp.collect(e, x),
    "subs": lambda e: e.subs(x, z + 2),
    "xreplace": lambda e: e.xreplace({x: z}), "replace": lambda e: e.replace(x, z), "diff": lambda e: sp.diff(e, x),
    "rates": lambda e: sp.diff(e, TIME, 2), "integrate": lambda e: sp.integrate(e, (x, 0, 1)),
    "series": lambda e: sp.series(sp.exp(x * e), x, 0, 3).removeO(), "limit": lambda e: sp.limit(e, x, 2),
    "solve": lambda e: sp.solve(z - e, z)[0], "rebuilt": lambda e: e.func(*e.args),
    "jacobian": lambda e: sp.Matrix([e]).jacobian([x])[0],
    "cse": lambda e: sp.cse([e, e + x])[1][1].subs(reversed(sp.cse([e, e + x])[0])),
    "poly": lambda e: sp.Poly(e, x).as_expr(),
    "solution": lambda e: sp.Matrix([[e, x], [-x, e]]).LUsolve(sp.Matrix([1, x]))[0],
    "det": lambda e: sp.Matrix([[e, x], [x, e]]).det(),
}  # fmt: skip


@pytest.mark.parametrize("name", KEEPING)
def test_value_stays(name, e):
    f = KEEPING[name]
    at = {dynamicsymbols._t: 0.3, q: 0.7 + 0.2 * TIME, p: 0.4 - TIME**2, alpha: 0.1, x: 0.6, z: 1.3}
    got, truth = (sp.sympify(v).subs({q: at[q], p: at[p]}).doit().subs(at) for v in (transform(f(e)), f(transform(e))))
    assert float(got) == pytest.approx(float(truth), rel=1e-12)


REFUSED = {
    "coordinate": lambda e: e.subs(q, 0), "parameter": lambda e: e.subs(alpha, 0.1), "time": lambda e: e.subs(TIME, 0),
    "both": lambda e: e.xreplace({q: x, p: z}), "partial": lambda e: e.diff(q),
    "by a parameter": lambda e: e.diff(alpha),
    "jacobian": lambda e: sp.Matrix([e]).jacobian([q, p]), "series": lambda e: sp.series(e, q, 0, 2),
    "integral": lambda e: sp.integrate(e, q), "function": lambda e: sp.lambdify((q, p, x, alpha), e),
    "pickle": pickle.dumps, "lambdify": lambda e: sp.lambdify(x, e), "C": sp.ccode,
    "limit": lambda e: sp.limit(e, TIME, 0), "rank": lambda e: sp.Matrix([[e, x], [x, e]]).rank(),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_needs_the_value_is_refused(name, e):
    with pytest.raises(UsageError, match=r"transform it first"):
        REFUSED[name](e)


def test_a_coordinate_that_does_not_turn_one_frame_against_the_other(frames):
    """a·b does not depend on how a itself turns."""
    _, A, B = frames
    d = A[2] & B[2]
    assert d.diff(q) == 0
    assert d.subs(q, 0) is d
    assert (d * q).diff(q) == d


def test_products_are_functions_of_the_time(frames):
    N, A, _ = frames
    d = N[1] & A[1]
    assert (d + 2 * (N[1] & A[2])).replace(d, x) == x + 2 * (N[1] & A[2])  # its arguments are the same
    assert d.has(TIME)
    assert (x + d).as_independent(TIME) == (x, d)
    assert d.free_symbols == {TIME}
    assert sp.latex(d) == r"(\hat{n}_{1} \cdot \hat{a}_{1})"
