"""Relations of motions: restarted, inverse and forward dynamics, balances of energy and momentum, rigid parts."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from unittest.mock import patch

import numpy as np

from spacar.deck import ELEMENT_TYPES
from spacar.deck.lexer import SMALLEST_REAL
from spacar.mechanism import rigid_search
from spacar.result import Result

from .case import GENERAL, NOTHING, Case, Found, alike, worst
from .compare import quantities
from .model import Element, Model, Node, Place, Tensor

SAMPLES = 16  # that Simpson's rule and its error need of a vibration
SHORTEST, LONGEST = 40, 400  # outputs of a balance


def started(model: Model, result, step: int) -> Model:
    """The model with start values of a step of its own result."""
    rows = []
    for r in model.rows("DYNX", "DYNE", "KINX", "KINE", block=1):
        e = r[0].endswith("E")
        names = r[2:] or ((1, 2, 3)[: 2 if model.planar else 3] if model.roles.get(r[1]) == "position" else (1,))
        if not r[2:] and not e and model.roles[r[1]] == "orientation":
            names = (1,) if model.planar else (2, 3, 4)
        for m in names:
            get = result.element if e else result.node
            if e and m - 1 in ELEMENT_TYPES[model.types[r[1]]].slips:
                continue
            values = (float(get(r[1], m, v)[step]) for v in (("e", "ed") if e else ("x", "xd")))
            rows.append(("STARTDE" if e else "STARTDX", r[1], m, *(v * (abs(v) >= SMALLEST_REAL) for v in values)))
    for n, role in model.roles.items():
        if role == "warping" and not any(r[1] == n and isinstance(r[1], Node) for r in model.rows("FIX", block=1)):
            rows.append(("STARTDX", n, 1, *(float(result.node(n, 1, v)[step]) for v in ("x", "xd"))))
    return model.without("STARTDX", "STARTDE").more(2, *rows)


def later(model: Model, t: float) -> Model | None:
    """What is prescribed as seen from the time t on; None for functions of the time."""
    if model.drives or any(p.a for p in model.pushes):
        return None

    def row(r, block):
        if block == 2 and r[0] in ("INPUTX", "INPUTE") and len(r) > 4:
            x, v, a = (*r[3:], 0.0, 0.0)[:3]
            return [(*r[:3], x + v * t + a * t * t / 2, v + a * t, a)]
        return [r]

    return model.mapped(row)


def restarted(case: Case) -> Found:
    """A motion that is started anew from one of its states goes on as it did."""
    base = case.base
    k = len(base.t) // 2
    if k == 0:
        return NOTHING
    rest = later(case.model, float(base.t[k]))
    if rest is None or case.divides or case.model.has("PLWHEEL", "WHEEL", "TWHEEL"):  # slips have no start value
        return NOTHING
    steps = len(base.t) - 1
    time = case.model.rows("TIMESTEP")[0][1]
    new = started(rest, base, k).without("TIMESTEP").more(2, ("TIMESTEP", time * (steps - k) / steps, steps - k))
    other = quantities(case.model, case.run(new))
    return case.same({key: v[k:] for key, v in case.values.items()}, other, GENERAL * case.condition)


def quiet(case: Case) -> bool:
    """Nothing is prescribed and no mass flows: the motion has an energy and a momentum."""
    prescribed = case.model.has("INPUTX", "INPUTE", "XGYRO", "MEE")
    return not prescribed and not case.model.has("PLTUBE", "TUBE", "PLWHEEL", "WHEEL", "TWHEEL", "PLBELT")


def fine(case: Case):
    """The motion once more, linearized, with SAMPLES outputs in a period of the fastest vibration; parts of divided
    beams vibrate faster. None: that would be too many."""
    time = 0.05 if case.divides else 0.2
    model = case.model.without("TIMESTEP", "INTEGRAT", "ERROR").more(2, ("ERROR", 1e-12, 1e-12))

    def moved(n):
        return case.run(model.more(2, ("TIMESTEP", time, n), ("INTEGRAT", 853, time / n)), mode=4)

    r = moved(SHORTEST)
    if not r.mechanism.numbering.nddof:
        return r
    squares = np.abs(np.linalg.eigvals(np.linalg.solve(r["m0"][0], r["k0"][0])))
    n = 4 * int(np.ceil(SAMPLES * time * np.sqrt(squares.max()) / (8.0 * np.pi)))
    return r if n <= SHORTEST else moved(n) if n <= LONGEST else None


def energy(case: Case) -> Found:
    """The kinetic energy grows by the work of all forces and stresses: T = qd M qd / 2."""
    if not quiet(case):
        return NOTHING
    r = fine(case)
    rates = None if r is None else rates_of(r)
    if rates is None or not rates.shape[1]:
        return NOTHING
    kinetic = np.einsum("ti,tij,tj->t", rates, r["m0"], rates) / 2
    power = (r["fxtot"] * r["xd"]).sum(1) - (r["sig"] * r["ed"]).sum(1)
    return balance(case, r.t, kinetic, power, "energy")


def rates_of(r) -> np.ndarray:
    """(steps, degrees of freedom) rates of the dynamic degrees of freedom."""
    n = r.mechanism.numbering
    return np.hstack([r["xd"][:, n.x_class["dynamic"]], r["ed"][:, n.e_class["dynamic"]]])


def balance(case: Case, t: np.ndarray, quantity: np.ndarray, rate: np.ndarray, what: str) -> Found:
    """The quantity grows by the integral of its rate: Simpson's rule, whose error two step sizes tell."""
    h = float(t[1] - t[0])
    fine, coarse = (np.cumsum(k * h / 3 * (r[:-2:2] + 4 * r[1:-1:2] + r[2::2])) for k, r in ((1, rate), (2, rate[::2])))
    size = max(float(np.abs(quantity).max()), float(np.abs(rate).max()) * h, h)  # of 1 N at least
    error = float(np.abs(fine[1::2] - coarse).max()) / size if size else 0.0
    return case.close(quantity[2::2] - quantity[0], fine, what, 1e-9 + error / 4, size)


def momentum(case: Case) -> Found:
    """Gravity weighs every mass: g p = fxgrav xd is the momentum along g, and its rate the sum of the forces on it."""
    if not quiet(case) or not case.model.has("GRAVITY") or "position" not in case.model.roles.values():
        return NOTHING
    r = fine(case)
    if r is None:
        return NOTHING
    g = np.array(case.model.rows("GRAVITY")[0][1])
    p = (r["fxgrav"] * r["xd"]).sum(1)
    nodes = (n for n, role in r.mechanism.numbering.kind.items() if role == "position")  # of divided beams too
    force = sum(r.node(n, variable="fxtot") @ g for n in nodes)
    return balance(case, r.t, p, force, "momentum")


def inverse(case: Case) -> Found:
    """Mode 1 with the nominal input of a step as preload moves as mode 2 does at that step."""
    base = case.base
    found = []
    if any(p.a for p in case.model.pushes) or case.model.has("TROT"):
        return NOTHING
    ports = case.model.rows("NOMS", block=3)
    for k in case.rng.sample(range(len(base.t)), 2):
        # an input is the driving force, minus the stress
        driven = {(r[2], r[3]): -float(base["u0"][k][r[1] - 1]) for r in ports}

        def row(r, block):
            if block == 3 or r[0] in ("TIMESTEP", "USERINP", "DELINPE") or (block == 2 and r[0] == "INPUTE"):
                return []
            if r[0] == "INPUTE" and block == 1:
                return [("DYNE", *r[1:])]
            return [r]

        model = replace(case.model.mapped(row), mode=1, drives=())
        width = {e: len(ELEMENT_TYPES[case.model.types[e]].modes) for e, _ in driven}
        for e, n in width.items():
            model = model.more(2, ("ESIG", e, *(driven.get((e, m), 0.0) for m in range(1, n + 1))))
        model = started(model, base, k)
        got = quantities(case.model, case.run(model, mode=1))
        want = {key: v[k : k + 1] for key, v in case.values.items()}
        found.append(case.same(want, got, GENERAL * case.condition))
    return worst(found)


def rigid_parts(case: Case) -> Found:
    """What is rigid is left out of the evaluation, or not."""
    model = ballasted(case)
    if model is None:
        return NOTHING

    def run(least: int) -> Result:
        with patch.object(rigid_search, "LEAST", least):
            return case.run(model)

    found = alike(partial(run, 1), partial(run, 1000))
    if found is None:
        return NOTHING  # the ballast carries it beyond its theory
    return case.same(*(quantities(model, result) for result in found), GENERAL * case.condition)


def ballasted(case: Case) -> Model | None:
    """With rigid beams and a body behind the first end of an element, and a truss at rest."""
    model, rng, d = case.model, case.rng, 2 if case.model.planar else 3
    places = {r[1]: r[2] for r in model.rows("X", block=1)}
    frames = [k for k in model.types.values() if ELEMENT_TYPES[k].nodes[:2] == ("position", "orientation")]
    ends = [r[2:4] for r in model.rows(*frames, block=1) if r[2] in places]
    if not ends or case.divides or model.pushes:  # a user function sees all coordinates
        return None
    p, o = rng.choice(ends)
    q, turn, far, other, point, a, b = (Node(max(model.roles) + k) for k in range(1, 8))
    e = [Element(max(model.types) + k) for k in range(1, 5)]
    beam, body, truss = ("PLBEAM", "PLRBEAM", "PLTRUSS") if d == 2 else ("BEAM", "RBEAM", "TRUSS")
    rows = [(beam, e[0], p, o, q, turn), (beam, e[1], q, turn, far, other), (body, e[2], q, turn, point)]
    rows += [(truss, e[3], a, b), ("RLSE", e[3], 1), ("FIX", a), ("FIX", b)]
    rows += [("X", n, Place(v + rng.choice((-1, 1)) * rng.uniform(0.2, 0.6) for v in places[p]))
             for n in (q, far, point, a, b)]  # fmt: skip
    tensor = 0.3 if d == 2 else Tensor((0.3, 0.02, 0.03, 0.4, -0.05, 0.35))
    heavy = [("XM", far, 0.7), ("XM", point, 0.9), ("XM", other, tensor), ("EM", e[3], 0.2), ("ESTIFF", e[3], 30.0)]
    heavy += [("EM", n, m, *(0.03,) * (2 * d - 3)) for n, m in zip(e, (0.5, 0.4), strict=False)]
    return model.more(1, *rows).more(2, *heavy)
