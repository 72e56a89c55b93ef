"""Constraints that touch flexible beams against an oracle of virtual work that shares no code with the package.

The oracle places mass points by its own Gauss quadrature, r(x; q), and takes every derivative as a central difference
of 1e-20 at 120 digits: I_ij = Σ w r_i·r_j, f_i = −Σ w r_i·(d²r/dε² along s − g) − U_i, J and γ of the constraint by
differences too. What is left is the truncation of the differences, 1e-40 relative: 1e-25 is asked.
"""

from functools import cache

import mpmath as mp
import numpy as np
import pytest
import sympy as sp

from spacar.errors import AnalysisError
from spacar.symbolic import MultibodySystem, beam_shapes
from spacar.symbolic.compiled_program import CompiledFunction, compiler

from .systems import gauss

VALUES = {"g": 9.81, "L1": 0.15, "m": 0.05, "rho": 0.2, "L": 0.3, "EI": 0.5, "GJ": 0.4, "EA": 30.0, "j": 1e-5}
NODES = 10  # exact to degree 19; the integrands reach 12
STEP = mp.mpf(10) ** -20


# -- the oracle ---------------------------------------------------------------------------------------------------


def turn(axis, angle):
    c, s = mp.cos(angle), mp.sin(angle)
    R = mp.eye(3)
    i, j = axis % 3, (axis + 1) % 3
    R[i, i] = R[j, j] = c
    R[i, j], R[j, i] = -s, s
    return R


def powers(c, x, n):
    """Σ c_k x^(k+2), its n-th derivative."""
    return sum(a * mp.ff(k, n) * x ** (k - n) for k, a in enumerate(c, 2))


class Rod:
    """A beam with deflections Σ φ x^(k+2)/L³ (two directions in space) on a crank (plane) or a universal joint."""

    def __init__(self, spatial, shortening, V):
        self.spatial, self.shortening, self.V = spatial, shortening, V

    def frames(self, q):
        if self.spatial:
            return mp.matrix([0, 0, 0]), turn(3, q[0]) * turn(2, q[1])
        return turn(3, q[0]) * mp.matrix([self.V["L1"], 0, 0]), turn(3, q[1])

    def fields(self, q):
        scale = self.V["L"] ** 3
        u = [c / scale for c in q[2:4]]
        return u, [c / scale for c in q[4:6]] if self.spatial else [0, 0]

    def point(self, q, x):
        root, B = self.frames(q)
        u, w = self.fields(q)
        drawn = mp.mpf(0)
        if self.shortening:
            drawn = sum(h * x * (powers(u, s * x, 1) ** 2 + powers(w, s * x, 1) ** 2) / 2 for s, h in gauss(NODES))
        return root + B * mp.matrix([x - drawn, powers(u, x, 0), powers(w, x, 0)])

    def tip_axis(self, q):
        """The second unit vector of the tip section: turned by u_x about 3, then by −w_x about 2."""
        u, w = self.fields(q)
        return (
            self.frames(q)[1]
            * turn(3, powers(u, self.V["L"], 1))
            * turn(2, -powers(w, self.V["L"], 1))
            * mp.matrix([0, 1, 0])
        )

    def masses(self, q):
        V = self.V
        found = [(h * V["L"] * V["rho"], self.point(q, x * V["L"])) for x, h in gauss(NODES)]
        found.append((V["m"], self.point(q, V["L"])))
        if not self.spatial:
            crank = turn(3, q[0])
            found += [(h * V["L1"] * V["rho"], crank * mp.matrix([x * V["L1"], 0, 0])) for x, h in gauss(NODES)]
        return found

    def potential(self, q):
        V, (u, w) = self.V, self.fields(q)
        places = [(x * V["L"], h * V["L"]) for x, h in gauss(NODES)]
        bent = sum(h * (powers(u, x, 2) ** 2 + powers(w, x, 2) ** 2) for x, h in places)
        return V["EI"] * bent / 2 + sum(m * V["g"] * r[1] for m, r in self.masses(q))


def shifted(q, s, h):
    return [a + h * b for a, b in zip(q, s, strict=True)]


def unit(n, k):
    return [mp.mpf(i == k) for i in range(n)]


def oracle(rod, rate, q, s, t):
    """ṡ and λ for the constraint rate(q, s, t) = 0."""
    n, h = len(q), STEP
    flat = lambda p: [c for _, r in rod.masses(p) for c in r]  # noqa: E731
    weight = [m for m, _ in rod.masses(q) for _ in range(3)]
    columns = []
    for k in range(n):
        a, b = flat(shifted(q, unit(n, k), h)), flat(shifted(q, unit(n, k), -h))
        columns.append([(x - y) / (2 * h) for x, y in zip(a, b, strict=True)])
    bias = [
        (x - 2 * y + z) / h**2 for x, y, z in zip(flat(shifted(q, s, h)), flat(q), flat(shifted(q, s, -h)), strict=True)
    ]
    K, right = mp.zeros(n + 1), mp.zeros(n + 1, 1)
    for i in range(n):
        for j in range(n):
            K[i, j] = sum(w * a * b for w, a, b in zip(weight, columns[i], columns[j], strict=True))
        slope = (rod.potential(shifted(q, unit(n, i), h)) - rod.potential(shifted(q, unit(n, i), -h))) / (2 * h)
        right[i] = -sum(w * a * b for w, a, b in zip(weight, columns[i], bias, strict=True)) - slope
        J = (rate(q, shifted(s, unit(n, i), h), t) - rate(q, shifted(s, unit(n, i), -h), t)) / (2 * h)
        K[n, i], K[i, n] = J, -J
    right[n] = -(rate(shifted(q, s, h), s, t + h) - rate(shifted(q, s, -h), s, t - h)) / (2 * h)
    return list(mp.lu_solve(K, right))


@cache
def expectation(kind, spatial, shortening, q, s, t):
    """Of the oracle, once for both strategies."""
    rod = Rod(spatial, shortening, {k: mp.mpf(v) for k, v in VALUES.items()})
    return oracle(rod, rates(kind, rod), q, s, t)


def rates(kind, rod):
    L = rod.V["L"]

    def tip_velocity(q, s):
        return (rod.point(shifted(q, s, STEP), L) - rod.point(shifted(q, s, -STEP), L)) / (2 * STEP)

    along = {
        "close": lambda q, s, t: tip_velocity(q, s)[1],
        "velocity": lambda q, s, t: tip_velocity(q, s)[1],
        "knife": lambda q, s, t: (tip_velocity(q, s).T * rod.tip_axis(q))[0],
        "moving": lambda q, s, t: tip_velocity(q, s)[1] - mp.sin(t) * s[0] - t,
    }
    return along[kind]


# -- the same in the package --------------------------------------------------------------------------------------


@cache
def model(kind, spatial, shortening, strategy):
    S = MultibodySystem(gravity=("0", "-g", "0"))
    q1, w1 = S.coordinate("q1", speed="w1")
    q2, _ = S.coordinate("q2", speed="w2")
    L1, m, rho, L, EI = S.parameters("L1 m rho L EI")
    A = S.frame("A", S.N, 3, q1)
    B = S.frame("B", A if spatial else S.N, 2 if spatial else 3, q2)
    root = S.O
    if not spatial:
        root = S.point("P", S.O, L1 * A[1])
        S.beam("crank", A, S.O, L1, rho, field=())
    rod = S.beam(
        "rod", B, root, L, rho, EI=EI, bends=(2, 3) if spatial else 2, field=beam_shapes.monomial(2, 3),
        foreshortening=shortening,
    )  # fmt: skip
    S.particle("block", rod.tip, m)
    if kind == "close":
        S.close(rod.tip, S.O, S.N[2], name="loop")
    else:
        e = {
            "velocity": rod.tip.velocity & S.N[2],
            "knife": rod.tip.velocity & rod.tip.frame[2],
            "moving": (rod.tip.velocity & S.N[2]) - sp.sin(S.time) * w1 - S.time,
        }[kind]
        S.constraint(e, name="loop")
    return S, rod, S.derive(strategy)


KINDS = ["close", "velocity", "knife", "moving"]
BEAMS = [
    (spatial, shortening, strategy)
    for spatial in (False, True) for shortening in (False, True) for strategy in ("held", "recursive")
]  # fmt: skip


def is_slow(kind, spatial, shortening, strategy):
    few = ("close",) if shortening else ("close", "knife")
    both = shortening and (spatial or strategy == "held")
    return both or (spatial and strategy == "held") or ((spatial or shortening) and kind not in few)


@pytest.mark.parametrize(("spatial", "shortening", "strategy", "kind"), [
    pytest.param(*beam, kind, marks=[pytest.mark.slow] * is_slow(kind, *beam)) for beam in BEAMS for kind in KINDS
])  # fmt: skip
def test_constraint_on_a_flexible_section(kind, spatial, shortening, strategy):
    S, _, eq = model(kind, spatial, shortening, strategy)
    speeds = [str(s.func) for s in S.speeds]
    program = eq.program({name: f"{name}_dot" for name in speeds} | {"force": "loop_force"})
    names = [s.name for s in program.state]
    rng = np.random.default_rng(3)
    n = len(speeds)
    y = [
        *rng.uniform(0.3, 0.9, 2),
        *rng.uniform(-0.002, 0.002, n - 2),
        *rng.uniform(1, 3, 2),
        *rng.uniform(-0.2, 0.2, n - 2),
    ]
    with mp.workdps(120):
        q, s = [mp.mpf(v) for v in y[:n]], [mp.mpf(v) for v in y[n:]]
        expected = expectation(kind, spatial, shortening, tuple(q), tuple(s), mp.mpf(0.4))
        numbers = VALUES | dict(zip(names, y, strict=True)) | {"time": 0.4}
        got = program.evaluate(numbers, 30)["outputs"]
        size = max(abs(x) for x in expected[:n])
        for name, x in zip(speeds, expected[:n], strict=True):
            assert abs(mp.mpf(str(got[name])) - x) < 1e-25 * size
        assert abs(mp.mpf(str(got["force"])) - expected[n]) < 1e-25 * abs(expected[n])


@pytest.mark.parametrize(("strategy", "kind"), [
    pytest.param(strategy, kind, marks=[pytest.mark.slow] * (kind in ("velocity", "knife") or strategy == "held"))
    for strategy in ("held", "recursive") for kind in KINDS
])  # fmt: skip
def test_check_sees_energy_and_constraints(kind, strategy):
    """30 digits leave 1e-28; without the field columns of J this check gave 0.92."""
    check = model(kind, False, True, strategy)[2].check()
    assert check.energy_error < 1e-28
    assert check.constraint_error < 1e-28
    assert check.positive


def test_wrong_columns_do_not_pass_the_check():
    """The defect that was: zeros in the field columns of J."""
    from dataclasses import replace

    eq = model("velocity", False, False, "recursive")[2]
    J = eq.constraints.matrix.copy()
    J[0, 2:] = sp.zeros(1, J.cols - 2)
    broken = replace(eq, constraints=replace(eq.constraints, matrix=J))
    assert broken.check().constraint_error > 1e-3
    with pytest.raises(AnalysisError, match="contradict"):
        broken.check().demand()


@pytest.mark.slow  # test_check_sees_energy_and_constraints is the fast one
@pytest.mark.parametrize("strategy", ["held", "recursive"])
@pytest.mark.parametrize("shortening", [False, True])
def test_energy_of_the_closed_slider_crank(strategy, shortening):
    """Without dissipation; 1e-9 of the energy at rtol 1e-10."""
    S, rod, eq = model("close", False, shortening, strategy)
    program = eq.program({"E": sum(eq.energy()), "gap": rod.tip.position & S.N[2]})
    function = CompiledFunction(program, VALUES) if compiler() else None
    run = program.simulate(
        VALUES, {"q1": 0.7, "w1": 20.0}, t_end=0.1, steps=20, integrator="dop853", rtol=1e-10, function=function
    )
    assert np.ptp(run["E"]) < 1e-9 * np.max(np.abs(run["E"]))
    assert np.max(np.abs(run["gap"])) < 1e-15
    assert "assembled" in run.notes[0]
    assert "phi" not in run.notes[0].split("w")[0]  # the rod stays straight, its angle closes the loop


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_compiled_closed_loop():
    """Accelerations, Jacobian, outputs and residuals in C; 1e-11 is rounding times the condition of the reduced I."""
    S, rod, eq = model("close", False, False, "recursive")
    program = eq.program({"force": "loop_force", "a": S.ddt(S.N, rod.tip.velocity) & S.N[1]})
    f, g = program.function(VALUES), CompiledFunction(program, VALUES)
    y = np.array([0.7, -0.3, 1e-3, 2e-3, 3.0, 1.2, 0.1, 0.2])
    a = np.array(f(0.0, y.tolist()))
    assert np.max(np.abs(a - g(0.0, y))) < 1e-11 * np.max(np.abs(a))
    J = f.jac(0.0, y.tolist())
    assert np.max(np.abs(J - g.jac(0.0, y))) < 1e-11 * np.max(np.abs(J))
    assert g.outputs(0.0, y) == pytest.approx(f.outputs(0.0, y.tolist()), rel=1e-11)
    for left, right in zip(g.manifold(0.0, y), f.manifold(0.0, y.tolist()), strict=True):
        assert left == pytest.approx(right, rel=1e-14, abs=1e-17)
    for k in range(8):  # central differences; 1e-6 is their noise
        h = 1e-6 * max(abs(y[k]), 1e-3)
        e = np.eye(8)[k] * h
        assert J[:, k] == pytest.approx(
            (g(0.0, y + e) - g(0.0, y - e)) / (2 * h), rel=1e-5, abs=1e-6 * np.max(np.abs(J))
        )
