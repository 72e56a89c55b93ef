"""Relations of linearized equations and stationary states."""

from __future__ import annotations

from dataclasses import replace
from typing import Any
from unittest import mock

import numpy as np

import spacar
from spacar.dynamics import Dynamics
from spacar.errors import SpacarError
from spacar.linear import form
from spacar.linearization.descriptor import of_frame
from spacar.linearization.sparse_response import response

from .case import GENERAL, NOTHING, Case, Found, worst
from .compare import quantities
from .model import Model, Vector
from .motion_relations import started

DIFFERENCE = 1e-6  # central differences with two steps, extrapolated: of the largest entry
INCREMENTS = {"XF": "DELXF", "GRAVITY": "DELGRAV", "ESIG": "DELESIG", "INPUTX": "DELINPX", "INPUTE": "DELINPE"}


def state_matrix(m: dict, k: int = -1) -> np.ndarray:
    """A of M qdd + C qd + K q = 0 from the matrices of a frame."""
    n = len(m["m0"])
    zero = np.zeros((n, n))
    damping = m["c0"] + m["d0"]
    stiffness = m["k0"] + m["n0"] + m["g0"]
    lower = -np.linalg.solve(m["m0"], np.hstack([stiffness[:, :n], damping])) if n else np.zeros((0, 0))
    return np.vstack([np.hstack([zero, np.eye(n)]), lower]) if n else zero


def differences(case: Case) -> Found:
    """The linearized equations of mode 4 are the differences of the motion of mode 1."""
    matrices = case.base.frames[0].matrices
    if case.model.has("PLWHEEL", "WHEEL", "TWHEEL") or "m0" not in matrices:
        return NOTHING
    dynamics = Dynamics(spacar.frames(1, case.deck(mode=1), **case.model.options).mechanism)
    y = np.array(dynamics.start())
    a = np.zeros((len(y), len(y)))
    for j in range(len(y)):
        steps = []
        for h in (2e-5, 1e-5):
            plus, minus = (np.array(dynamics.rhs(0.0, moved(y, j, s * h), 1e-15)) for s in (1, -1))
            steps.append((plus - minus) / (2 * h))
        a[:, j] = (4 * steps[1] - steps[0]) / 3
    return case.close(a, state_matrix(matrices), "state matrix", DIFFERENCE)


def moved(y: np.ndarray, j: int, h: float) -> np.ndarray:
    z = y.copy()
    z[j] += h
    return z


def state_space(case: Case) -> Found:
    """Mode 9 is mode 4 at the stationary state."""
    if case.divides or case.model.has("PLWHEEL", "WHEEL", "TWHEEL") or case.model.rows("ITERSTEP")[0][5] > 1:
        return NOTHING
    model = replace(started(case.model, case.base, -1).without("ITERSTEP"), mode=4)
    got = case.run(model)
    if beyond_dead_point(case.base):
        return NOTHING  # start values lead to the mirror image, on this side of it
    names = [n for n in ("A", "B", "C", "D", "m0", "c0", "d0", "k0", "n0", "g0")]
    a, b = (dict(f.matrices) | dict(f.state_space) for f in (case.base.frames[-1], got.frames[0]))
    force = max((float(np.abs(a[n]).max(initial=0.0)) for n in ("k0", "n0", "g0") if n in a), default=0.0)
    found = [case.close(a[n], b[n], n, 1e-9, force if n in ("k0", "n0", "g0") else 1.0) for n in names if n in a]
    return worst(found)


def sparse_form(case: Case) -> Found:
    """The sparse form of large models has the same A, B, C, D, and the transfer function and resolvent of these."""
    with mock.patch.object(form, "LARGE", -1):
        sparse = case.run()
    found = []
    for frame, other in zip(case.base.frames, sparse.frames, strict=True):
        if "asp" not in other.state_space or "A" not in frame.state_space:
            return NOTHING
        system = of_frame(other.state_space, sparse.header)
        want, got = frame.state_space, dict(zip("ABCD", system.state_space(), strict=True))
        names = [name for name in "ABCD" if name in want]
        found += [case.close(want[name], got[name], name, 1e-13 * case.condition, 1.0) for name in names]
        if not want["A"].size or not want["B"].size or not want["C"].size:
            continue
        omega = np.array([0.5, 2.0, 2.1, 40.0])
        for w, of_sparse in zip(omega, response(system, omega), strict=True):
            resolvent = 1j * w * np.eye(len(want["A"])) - want["A"]
            of_dense = want["C"] @ np.linalg.solve(resolvent, want["B"].astype(complex)) + want.get("D", 0.0)
            error = 1e-12 * case.condition * np.linalg.cond(resolvent)
            found.append(case.close(of_dense, of_sparse, f"response at {w} rad/s", error, 1.0))
            states = np.linalg.solve(resolvent, want["B"][:, 0].astype(complex))
            found.append(case.close(states, system.resolvent(1j * w)(want["B"][:, 0]), f"states at {w}", error, 1.0))
    return worst(found)


def beyond_dead_point(result: spacar.Result) -> bool:
    """Has the determinant of the position matrix another sign at the last state than in the reference configuration?"""
    kinematics = Dynamics(result.mechanism).kinematics
    if not len(kinematics.c):
        return False
    signs = []
    for x in (result.mechanism.x0, result.frames[-1].x):
        kinematics.x = x
        kinematics.sweep.strain(x)
        kinematics.refactor()
        signs.append(kinematics.position_system.determinant_sign())
    return signs[0] != signs[1]


def eigen_and_buckling(case: Case) -> Found:
    """Mode 10 is mode 7 and mode 8; the eigenvalues are those of its own matrices."""
    seven, eight = case.run(mode=7), case.run(mode=8)
    found = (
        [case.close(case.base["lmult"], eight["lmult"], "lmult", 1e-10)] if "lmult" in eight.frames[-1].matrices else []
    )
    if "eigval" not in case.base.frames[-1].matrices:
        return worst(found)
    a, b = (sorted_complex(r["eigval"][-1]) for r in (case.base, seven))
    found.append(case.close(a, b, "eigval", 1e-10))
    matrices = case.base.frames[-1].matrices
    if len(matrices["m0"]):
        want = np.linalg.eigvals(state_matrix(matrices))
        off = max((float(np.abs(want - v).min()) for v in a), default=0.0)
        if not case.model.has("MODES"):
            off = max(off, max((float(np.abs(a - v).min()) for v in want), default=0.0))
        size = float(np.abs(want).max()) ** 2 * 1e-8  # double eigenvalues: the square root of rounding
        found.append((off / size if size else 0.0, f"eigenvalues of the matrices: {off:.3g}"))
    return worst(found)


def sorted_complex(pairs: np.ndarray) -> np.ndarray:
    values = pairs @ [1, 1j]
    return values[np.lexsort((np.round(values.imag, 6), np.round(values.real, 6)))]


def changed(model: Model, keyword: str, subject: Any, place: int, by: float) -> Model:
    """One number of the second block increased; `place` counts the words behind the keyword from 1."""

    def row(r, block):
        if block == 2 and r[0] == keyword and (subject is None or r[1] == subject):
            words: list[Any] = []
            left = place
            for v in r[1:]:
                width = len(v) if isinstance(v, Vector) else 1
                if 0 < left <= width:
                    v = type(v)(c + by * (i == left - 1) for i, c in enumerate(v)) if isinstance(v, Vector) else v + by
                left -= width
                words.append(v)
            return [(r[0], *words)]
        return [r]

    return model.mapped(row)


def compliances(case: Case) -> Found:
    """Directional compliances are displacements by small loads."""
    free = [n for n, role in case.model.roles.items() if role == "position" and not held(case.model, n)]
    if not free:
        return NOTHING
    node = case.rng.choice(free)
    d = 2 if case.model.planar else 3
    c = case.rng.randrange(1, d + 1)
    model = case.model
    if not any(r[1] == node for r in model.rows("XF")):
        model = model.more(2, ("XF", node, Vector((0.0,) * d)))
    h, steps = 1e-3, []
    for s in (h, h / 2):
        up, down = (case.run(changed(model, "XF", node, 1 + c, k * s)).node(node, c)[-1] for k in (1, -1))
        steps.append((up - down) / (2 * s))
    want = (4 * steps[1] - steps[0]) / 3
    got = case.base.node(node, c, "xcompl")[-1]
    return case.close(want, got, f"xcompl of node {node} {c}", DIFFERENCE, 1e-2)


def held(model: Model, node: int) -> bool:
    return any(r[1] == node and r[0] in ("FIX", "INPUTX", "KINX") for r in model.rows("FIX", "INPUTX", "KINX", block=1))


def sensitivities(case: Case) -> Found:
    """Derivatives by numbers of the deck are differences of runs."""
    if case.model.has("PLWHEEL", "WHEEL", "TWHEEL"):
        return NOTHING
    rows = [r for r in case.model.rows("XF", "ESTIFF", "EM", "XM", "GRAVITY", block=2)]
    if not rows:
        return NOTHING
    r = case.rng.choice(rows)
    alone = r[0] == "GRAVITY"
    place = 1 if alone else 2
    first = r[1] if alone else r[2]
    value = first[0] if isinstance(first, Vector) else float(first)
    if value == 0.0:
        return NOTHING
    name = f"{r[0]}[{place}]" if alone else f"{r[0]}.{int(r[1])}[{place}]"
    free = [n for n, role in sorted(case.model.roles.items()) if role == "position" and not held(case.model, n)]
    if not free:
        return NOTHING
    node = case.rng.choice(free)
    texts = [f"x[{node},1]@end", f"x[{node},2]@end"]
    found = spacar.sensitivity(case.deck(mode=10), [name], texts, **case.model.options)

    def at(by: float) -> np.ndarray:
        return case.run(changed(case.model, r[0], None if alone else r[1], place, by), mode=7).node(node)[-1, :2]

    h = 2e-3 * abs(value)
    slopes = [(at(s) - at(-s)) / (2 * s) for s in (h, h / 2)]
    want = (4 * slopes[1] - slopes[0]) / 3
    return case.close(want, found.derivatives[:, 0], f"d x[{node}] / d {name}", DIFFERENCE, 1e-2 / abs(value))


def load_steps(case: Case) -> Found:
    """Another number of load steps, and the additional loading as part of the initial one, give the same state."""
    model = case.model
    step = model.rows("ITERSTEP")[0]
    kind = step[5]
    if kind >= 2:
        added = merged(model)
        if added is None:
            return NOTHING
        other = case.run(added)
    else:
        try:
            other = case.run(model.without("ITERSTEP").more(2, (*step[:2], step[2] + 2, *step[3:])))
        except SpacarError as error:
            # The force that holds a start fades along the first step: of other steps another path leads from there.
            if error.code == "statics.limit-point" and model.has("STARTDX", "STARTDE"):
                return NOTHING
            raise
    last = {k: v[-1:] for k, v in case.values.items()}
    end = {k: v[-1:] for k, v in quantities(model, other).items()}
    return case.same(last, end, 1e-11 * case.condition)


def torsion(case: Case) -> Found:
    """Stresses 2, 7, 8 of a BEAMW are derivatives of its energy, the integral of (GIt alpha^2 + ECw alpha'^2) / 2 with
    the twist rate alpha of a cubic twist angle (theory-warping.md 3)."""
    model, result = case.model, case.base
    if case.divides or model.has("ESIG", "USERSIG", "DELESIG", "BEAMSEC"):
        return NOTHING
    n, place = result.mechanism.numbering, {r[1]: np.array(r[2]) for r in model.rows("X", block=1)}
    constants = {r[1]: r[2:] for r in model.rows("ESTIFF")}
    xi, weight = np.polynomial.legendre.leggauss(4)
    xi, weight = (1.0 + xi) / 2.0, weight / 2.0
    found = []
    for _, number, p, _, _, q, *_ in model.rows("BEAMW"):
        if number in constants and all(n.e_index(number, m) >= n.e_class["input"].stop for m in (2, 7, 8)):
            length, GIt, ECw = float(np.linalg.norm(place[q] - place[p])), constants[number][1], constants[number][6]
            e, want = ([result.element(number, m, of)[-1] for m in (2, 7, 8)] for of in ("e", "sig"))
            rate = np.array([0 * xi + 1, -1 + 4 * xi - 3 * xi**2, 3 * xi**2 - 2 * xi]) / length**2
            slope = np.array([0 * xi, 4 - 6 * xi, 6 * xi - 2]) / length**3
            got = length * ((GIt * (e @ rate) * rate + ECw * (e @ slope) * slope) @ weight)
            stiff = GIt / length**3 + ECw / length**5  # times a metre, to which positions are known to GENERAL
            found.append(case.close(want, got, f"torsion of element {number}", GENERAL, stiff))
    return worst(found)


def merged(model: Model) -> Model | None:
    """Initial and additional loading together as initial loading."""
    driven = {(d.owner, d.index) for d in model.drives}
    if model.has("DELOMF") or any(r[1:3] in driven for r in model.rows("DELINPX", "DELINPE")):
        return None
    added = {r[:3] if r[0] in ("DELINPX", "DELINPE") else r[:2] if r[0] != "DELGRAV" else r[:1]: r
             for r in model.rows(*INCREMENTS.values())}  # fmt: skip
    done = set()

    def row(r, block):
        if block == 2 and r[0] == "ITERSTEP":
            return [(*r[:5], 0, *r[6:])]
        if block != 2 or r[0] not in INCREMENTS:
            return [] if r[0] in INCREMENTS.values() else [r]
        key = (INCREMENTS[r[0]], *r[1 : 3 if r[0].startswith("INPUT") else 2 if r[0] != "GRAVITY" else 1])
        if key not in added:
            return [r]
        done.add(key)
        plus = added[key]
        if key[0] in ("DELINPX", "DELINPE"):
            return [(*r[:3], r[3] + plus[3], *r[4:])]
        n = len(key)
        a, b = r[n:], plus[n:]
        if [type(v) for v in a] != [type(v) for v in b] and r[0] == "XF":
            done.discard(key)
            return [r]
        return [(*r[:n], *(type(v)(np.add(v, w)) if isinstance(v, Vector) else v + w for v, w in both(a, b)))]

    other = model.mapped(row)
    rest = [
        (next(k for k, v in INCREMENTS.items() if v == r[0]), *r[1:]) for key, r in added.items() if key not in done
    ]
    if any(
        r[0] in ("INPUTX", "INPUTE") or (r[0] == "XF" and any(s[:2] == r[:2] for s in other.rows("XF"))) for r in rest
    ):
        return None
    return other.more(2, *rest)


def both(a: tuple, b: tuple) -> list[tuple]:
    """Pairs of values; missing ones are zero."""
    n = max(len(a), len(b))
    return list(zip((*a, *(0.0,) * (n - len(a))), (*b, *(0.0,) * (n - len(b))), strict=True))


def small_division(case: Case) -> Found:
    """Loads of a millionth: the nodes of the file move as much however finely beams are divided (linear theory: cubic
    beams without warping are exact at their ends, with shear, preload, prescribed bending and their own weight)."""
    small = None if case.model.has("BEAMW") else scaled(case.model, 1e-6)
    finer = None if small is None else case.divided(case.rng.choice((2, 3)), case.deck(small, 8))
    if finer is None:
        return NOTHING
    coarse, fine = case.run(small, mode=8), case.result(finer, 8)
    start = coarse.mechanism.x0
    size = float(np.abs(coarse["x"][-1] - start).max(initial=0.0))
    found = []
    for node in case.model.roles:
        off = float(np.abs(coarse.node(node)[-1] - fine.node(node)[-1]).max())
        limit = 1e-3 * size + 1e-12 * case.condition
        found.append((off / limit, f"node {node} moves {off:.3g} less of {size:.3g}"))
    return worst(found)


def scaled(model: Model, by: float) -> Model | None:
    """All loads by a factor; None where there is more than loads."""
    if model.has("USERSIG", "USERINP", "XGYRO", "PLTUBE", "TUBE", "DRPINBOD", "PLWHEEL", "WHEEL", "TWHEEL"):
        return None
    places = {r[1]: r[2] for r in model.rows("X", block=1)}

    def row(r, block):
        if r[0] in ("XF", "ESIG", "DELXF", "DELESIG"):
            return [(*r[:2], *times(r[2:], by))]
        if r[0] in ("GRAVITY", "DELGRAV"):
            return [(r[0], *times(r[1:], by))]
        if block == 2 and r[0] in ("INPUTX", "INPUTE", "STARTDE", "STARTDX", "DELINPX", "DELINPE"):
            at = places[r[1]][r[2] - 1] if r[0] in ("INPUTX", "STARTDX") and model.roles[r[1]] == "position" else 0.0
            return [(*r[:3], at + by * (r[3] - at), *times(r[4:], by))]
        return [r]

    return model.mapped(row)


def times(values: tuple, by: float) -> list:
    return [type(v)(by * c for c in v) if isinstance(v, Vector) else by * v for v in values]
