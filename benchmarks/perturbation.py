"""The perturbation method on the flexible manipulator: error and time against the full non-linear simulation.

    python benchmarks/perturbation.py [--json]

Models: data/robotflexinv.dat (mode 2, rigid), robotflexinvlin.dat (mode 3), robotflexsim.dat (non-linear plant). Both
start from the static deflection and have the same feedback: computed torque with omega 28 rad/s, damping 0.85. For
every number of modes kept (of 11; the others answer quasi-statically) the largest and the mean deviation of the tip
from the non-linear simulation, in parts of its largest deflection, and how much faster the linear simulation is. The
times of modes 2 and 3 are needed once for a motion and are listed apart.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import spacar
from spacar.simulation import (
    Spasim,
    TimeVarying,
    closed_loop,
    computed_torque,
    reduce_modes,
    simulate_ltv,
    static_start,
    tracking_gains,
    with_gain,
)

DATA = Path(__file__).parents[1] / "data"
OMEGA, DAMPING = 28.0, 0.85
MODES = (3, 4, 5, 6, 8, 11)
TIP = slice(6, 9)  # outputs 7 to 9
REPETITIONS = 3


def measure() -> dict[str, Any]:
    """All numbers of the table."""
    begun = perf_counter()
    inverse = spacar.run(2, DATA / "robotflexinv.dat")
    mode_2 = perf_counter() - begun
    begun = perf_counter()
    linear = TimeVarying.of(spacar.run(3, DATA / "robotflexinvlin.dat", nominal=inverse))
    mode_3 = perf_counter() - begun
    nominal = TimeVarying.of(inverse)
    system = static_start(with_gain(linear, *tracking_gains(linear, OMEGA, DAMPING)))

    plant = Spasim(DATA / "robotflexsim.dat")
    law = computed_torque(nominal, linear, OMEGA, DAMPING, positions=[1, 2, 3], rates=[4, 5, 6], interpolation="spline")
    begun = perf_counter()
    start = {plant.name: plant.start() + system.x0}
    response = closed_loop(plant, law, nominal.t, feedback="1-6", x0=start, rtol=1e-6, atol=1e-7)
    full = response[plant.name][:, TIP]
    nonlinear = perf_counter() - begun
    size = float(np.abs(full - nominal.y0[:, TIP]).max())

    rows = []
    for name, data in [("all, not reduced", system), *((m, reduce_modes(system, m).system) for m in MODES)]:
        seconds = min(_timed(data) for _ in range(REPETITIONS))
        off = np.abs(simulate_ltv(data).y[:, TIP] - full) / size
        rows.append(
            {"modes": name, "largest": float(off.max()), "mean": float(off.mean()), "seconds": seconds,
             "speed_up": nonlinear / seconds}
        )  # fmt: skip
    return {"deflection": size, "mode_2": mode_2, "mode_3": mode_3, "nonlinear": nonlinear, "rows": rows}


def _timed(data: TimeVarying) -> float:
    begun = perf_counter()
    simulate_ltv(data)
    return perf_counter() - begun


def main() -> None:
    found = measure()
    if "--json" in sys.argv:
        print(json.dumps(found))
        return
    print(f"largest deflection of the tip {found['deflection'] * 1e3:.3f} mm")
    print(f"mode 2 {found['mode_2']:.2f} s, mode 3 {found['mode_3']:.2f} s, non-linear {found['nonlinear']:.2f} s")
    print(f"{'modes kept':>16} {'largest error':>14} {'mean error':>12} {'seconds':>9} {'speed-up':>9}")
    for r in found["rows"]:
        print(f"{r['modes']!s:>16} {r['largest']:14.2e} {r['mean']:12.2e} {r['seconds']:9.4f} {r['speed_up']:9.0f}")


if __name__ == "__main__":
    main()
