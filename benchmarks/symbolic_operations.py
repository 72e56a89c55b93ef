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


def count(system: MultibodySystem, strategy: str, recurrence: bool = True) -> dict[str, Any]:
    began = time.process_time()
    eq = system.derive(strategy, recurrence)
    derived = time.process_time() - began
    return {"raw": eq.count_ops(), **eq.program().counts(), "seconds": round(derived, 2)}


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
    print(f"{'derivation':28s}{'raw':>8s}{'step':>8s}{'once':>8s}{'seconds':>9s}{'reference':>11s}")
    for name, row in rows.items():
        reference = REFERENCE.get(name, "")
        print(f"{name:28s}{row['raw']:8d}{row['step']:8d}{row['once']:8d}{row['seconds']:9.2f}{reference!s:>11s}")
    model = read_model(MODEL)
    times: dict[str, float] = {}
    for strategy in ("held", "recursive"):
        program = model.system.derive(strategy).program(model.outputs)
        y = np.full(len(program.state), 1e-3)
        times[f"{strategy}, Python"] = per_call(program.function(model.values), y.tolist())
        if compiler():
            times[f"{strategy}, C by ctypes"] = per_call(CompiledFunction(program, model.values), y)
    for name, value in times.items():
        print(f"{name:28s}{value:8.2f} µs per right-hand side (I, f, LDLᵀ)")
    record = {"python": sys.version.split()[0], "operations": rows, "microseconds": times}
    (HERE / "symbolic_operations.json").write_text(json.dumps(record, indent=2) + "\n")


if __name__ == "__main__":
    main()
