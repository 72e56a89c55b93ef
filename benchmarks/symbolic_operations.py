"""Operation counts of the symbolic part with and without Z variables, and times of the generated right-hand sides.

    python benchmarks/symbolic_operations.py        a table on the terminal, the numbers in symbolic_operations.json

Counts are SymPy `count_ops` of the upper triangle of I and the right-hand side: before cse ("raw"), then per step
and once per run after cse. Reference counts: symbolic.md, section 4.4.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from spacar.symbolic import MultibodySystem
from spacar.symbolic.compiled_program import CompiledFunction, compiler
from spacar.symbolic.model_reader import read_model

HERE = Path(__file__).parent
MODEL = HERE.parent / "data" / "symbolic" / "manipulator.toml"
REFERENCE = {"held, no Z": 2177, "held, Z": 915, "recursive": 402}


def chain(n: int) -> MultibodySystem:
    """A spatial chain of n rigid links, two rotations per joint."""
    S = MultibodySystem(gravity=("0", "0", "-g"))
    m, L, I1, I2 = S.parameters("m L I1 I2")
    frame, point = S.N, S.O
    for k in range(1, n + 1):
        a, _ = S.coordinate(f"a{k}", speed=f"u{k}")
        b, _ = S.coordinate(f"b{k}", speed=f"v{k}")
        frame = S.frame(f"B{k}", S.frame(f"H{k}", frame, 3, a), 2, b)
        S.rigid_body(f"link{k}", frame, at=S.point(f"G{k}", point, L / 2 * frame[1]), mass=m, inertia=(I1, I2, I2))
        point = S.point(f"P{k}", point, L * frame[1])
    return S


def links(n: int) -> MultibodySystem:
    """A planar chain of n rigid links with parameters of their own."""
    S = MultibodySystem(gravity=("0", "-g", "0"))
    frame, end = S.N, S.O
    for k in range(1, n + 1):
        q, _ = S.coordinate(f"q{k}", speed=f"s{k}")
        frame = S.frame(f"B{k}", frame, 3, q)
        centre = S.point(f"C{k}", end, S.expression(f"c{k}") * frame[1])
        S.rigid_body(f"link{k}", frame, centre, f"m{k}", (0, 0, f"J{k}"))
        end = S.point(f"P{k}", end, S.expression(f"L{k}") * frame[1])
    return S


def flexible(n: int) -> MultibodySystem:
    """A chain of n beams with the default field: three shapes and foreshortening."""
    S = MultibodySystem(gravity=("0", "-g", "0"))
    frame, end = S.N, S.O
    for k in range(1, n + 1):
        q, _ = S.coordinate(f"q{k}", speed=f"s{k}")
        B = S.frame(f"B{k}", frame, 3, q)
        frame = end = S.beam(f"link{k}", B, end, f"L{k}", f"rho{k}", EI=f"EI{k}").tip
    return S


def kane(n: int) -> dict[str, Any]:
    """The rigid chain by KanesMethod of SymPy, its mass matrix and forcing with cse."""
    import sympy as sp
    from sympy.physics import mechanics as me

    began = time.process_time()
    g = sp.Symbol("g")
    q, s = me.dynamicsymbols(f"q1:{n + 1}"), me.dynamicsymbols(f"s1:{n + 1}")
    N, P = me.ReferenceFrame("N"), me.Point("O")
    P.set_vel(N, 0)
    frame, bodies, forces, rates = N, [], [], [a.diff() - b for a, b in zip(q, s, strict=True)]
    known = {a.diff(): b for a, b in zip(q, s, strict=True)}
    for k in range(n):
        m, J, L, c = sp.symbols(f"m{k + 1} J{k + 1} L{k + 1} c{k + 1}")
        B = frame.orientnew(f"B{k}", "Axis", (q[k], frame.z))
        B.set_ang_vel(N, sum(s[: k + 1]) * N.z)
        C = P.locatenew(f"C{k}", c * B.x)
        C.v2pt_theory(P, N, B)
        bodies.append(me.RigidBody(f"b{k}", C, B, m, (J * me.outer(B.z, B.z), C)))
        forces.append((C, -m * g * N.y))
        P, frame = C.locatenew(f"P{k}", (L - c) * B.x), B
        P.v2pt_theory(C, N, B)
    method = me.KanesMethod(N, q_ind=q, u_ind=s, kd_eqs=rates)
    method.kanes_equations(bodies, forces)
    derived = time.process_time() - began
    M, f = method.mass_matrix.xreplace(known), method.forcing.xreplace(known)
    flat = [*(M[i, j] for i in range(n) for j in range(i, n)), *f]
    shared, results = sp.cse(flat, order="none")
    done = time.process_time() - began
    operations = sum(sp.count_ops(e) for e in [*(e for _, e in shared), *results])
    raw = sum(sp.count_ops(e) for e in flat)
    seconds = {"seconds": round(derived, 2), "program": round(done - derived, 2)}
    return {"raw": int(raw), "step": int(operations), "once": 0, **seconds}


def count(system: MultibodySystem, strategy: str, recurrence: bool = True) -> dict[str, Any]:
    began = time.process_time()
    eq = system.derive(strategy, recurrence)
    derived = time.process_time() - began
    counts = eq.program().counts()
    program = time.process_time() - began - derived
    return {"raw": eq.count_ops(), **counts, "seconds": round(derived, 2), "program": round(program, 2)}


def per_call(function: Any, y: Any, repeat: int = 2000) -> float:
    """Microseconds of one right-hand side, the best of five."""
    best = np.inf
    for _ in range(5):
        began = time.perf_counter()
        for _ in range(repeat):
            function(0.0, y)
        best = min(best, time.perf_counter() - began)
    return round(1e6 * best / repeat, 2)


def main() -> None:
    rows = {
        "held, no Z": count(read_model(MODEL).system, "held", recurrence=False),
        "held, Z": count(read_model(MODEL).system, "held"),
        "recursive": count(read_model(MODEL).system, "recursive"),
    }
    for n in (1, 2, 3):
        for strategy in ("held", "recursive"):
            rows[f"chain of {n}, {strategy}"] = count(chain(n), strategy)
    rows["chain of 6, recursive"] = count(chain(6), "recursive")
    for n in (2, 4, 8):
        rows[f"{n} rigid links, KanesMethod + cse"] = kane(n)
        for strategy in ("held", "recursive"):
            rows[f"{n} rigid links, {strategy}"] = count(links(n), strategy)
    for n in (2, 4):
        for strategy in ("held", "recursive"):
            rows[f"{n} default beams, {strategy}"] = count(flexible(n), strategy)
    print(f"{'derivation':34s}{'raw':>8s}{'step':>8s}{'once':>8s}{'derive s':>10s}{'program s':>10s}{'reference':>11s}")
    for name, row in rows.items():
        reference = REFERENCE.get(name, "")
        counts = f"{row['raw']:8d}{row['step']:8d}{row['once']:8d}"
        print(f"{name:34s}{counts}{row['seconds']:10.2f}{row['program']:10.2f}{reference!s:>11s}")
    model = read_model(MODEL)
    times: dict[str, float] = {}
    for strategy in ("held", "recursive"):
        program = model.system.derive(strategy).program(model.outputs)
        y = np.full(len(program.state), 1e-3)
        times[f"{strategy}, Python"] = per_call(program.function(model.values), y.tolist())
        if compiler():
            f = CompiledFunction(program, model.values)
            times[f"{strategy}, C"] = per_call(f, y)
            states = np.tile(y, (2000, 1))
            whole = per_call(lambda t, s, f=f: f.many(t, s), states, 5)
            times[f"{strategy}, C, many states"] = round(whole / len(states), 3)
    for name, value in times.items():
        print(f"{name:28s}{value:8.2f} µs per right-hand side (I, f, LDLᵀ)")
    record = {"python": sys.version.split()[0], "operations": rows, "microseconds": times}
    (HERE / "symbolic_operations.json").write_text(json.dumps(record, indent=2) + "\n")


if __name__ == "__main__":
    main()
