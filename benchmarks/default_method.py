"""The default method against the fastest code: processor time and right-hand sides at the ERROR of the file.

python benchmarks/default_method.py [--general] [MODEL | FILE ...]

Regret: time of INTEGRAT -1 over the least of codes 0, 155, 853, 553, 595 (a code is stopped at LIMIT times the least so
far, or at LONGEST). Whole runs from the deck to the last frame in memory, the least of three below a second.
"""

from __future__ import annotations

import sys
import time
from statistics import median

import models

import spacar
from spacar.deck import parse_deck
from spacar.errors import AnalysisError

CODES = (0, 155, 853, 553, 595)
LIMIT, LONGEST = 6.0, 12.0
REPEATS, SHORT = 3, 1.0


def damper(c: float, duration: float, k: float = 1.0, start: float = 0.1) -> str:
    """1 kg on a spring and a damper."""
    return models.deck(
        ["PLTRUSS 1 1 2", "X 2 1. 0.", "FIX 1", "FIX 2 2", "DYNE 1 1"],
        ["XM 2 1.", f"ESTIFF 1 {k!r}", f"EDAMP 1 {c!r}", f"STARTDE 1 1 {start!r} 0.", f"TIMESTEP {duration!r} 20"],
    )


def train(n: int, k: float, c: float, duration: float, forced: bool = False) -> str:
    """n masses in a row on springs k with dampers c, the first one soft (k = 1): stiff rows move as one."""
    kinematics = [f"PLTRUSS {i} {i} {i + 1}" for i in range(1, n + 1)] + [f"X {i + 1} {i}. 0." for i in range(1, n + 1)]
    kinematics += ["FIX 1", *(f"FIX {i + 1} 2" for i in range(1, n + 1)), *(f"DYNE {i} 1" for i in range(1, n + 1))]
    dynamics = [f"XM {i + 1} 1." for i in range(1, n + 1)] + ["ESTIFF 1 1.", "STARTDE 1 1 0.2 0."]
    dynamics += [f"ESTIFF {i} {k!r}" for i in range(2, n + 1)]
    dynamics += [f"EDAMP {i} {c!r}" for i in range(2, n + 1)] if c else []
    dynamics += [f"XF {n + 1} 0.3 0."] if forced else []
    return models.deck(kinematics, [*dynamics, f"TIMESTEP {duration!r} 20"])


def stiff_rod(k: float, c: float, duration: float) -> str:
    """Pendulum whose rod is a spring."""
    damped = [f"EDAMP 1 {c!r}"] if c else []
    return models.deck(
        ["PLTRUSS 1 1 2", "X 2 1. 0.", "FIX 1", "DYNX 2", "RLSE 1"],
        ["XM 2 1.", f"ESTIFF 1 {k!r}", *damped, "GRAVITY 0. -9.81", f"TIMESTEP {duration!r} 30"],
    )


def released(n: int, duration: float, damping: float = 0.0) -> str:
    """Unit cantilever released under gravity 1, viscous parts of its bending `damping` times the stiffness."""
    damped = tuple(f"EDAMP {i + 1} 0. {damping!r}" for i in range(n)) if damping else ()
    return models.cantilever(n, EI=1.0, length=1.0, dynamics=("GRAVITY 0. -1.", f"TIMESTEP {duration!r} 18", *damped))


def oscillator(periods: float) -> str:
    return damper(0.0, 6.283185307179586 * periods).replace("EDAMP 1 0.0\n", "")


def spatial(n: int, duration: float) -> str:
    return models.spatial_chain(n).replace("TIMESTEP 0.01 1", f"TIMESTEP {duration!r} 10")


MODELS: dict[str, str] = {
    **{f"damper 1e{k}": damper(10.0**k, 1.0) for k in range(1, 13)},
    "damper 1e5, stiff spring": damper(1e5, 1.0, k=1e5),
    "damper 30, long": damper(30.0, 200.0),
    "dampers in a row, 4": train(4, 100.0, 1e5, 20.0, forced=True),
    "dampers in a row, 12": train(12, 1e3, 1e3, 30.0, forced=True),
    "springs in a row, 4": train(4, 1e6, 0.0, 40.0),
    "springs in a row, 20": train(20, 1e6, 0.0, 60.0),
    "springs in a row, forced": train(4, 1e6, 0.0, 40.0, forced=True),
    "stiff rod 1e6": stiff_rod(1e6, 0.0, 10.0),
    "stiff rod 1e8": stiff_rod(1e8, 0.0, 10.0),
    "stiff rod 1e6, damped": stiff_rod(1e6, 100.0, 10.0),
    "stiff rod 1e8, damped": stiff_rod(1e8, 2e4, 10.0),
    "oscillator, 3 periods": oscillator(3.0),
    "oscillator, 2000 periods": oscillator(2000.0),
    "cantilever, 2": released(2, 1.8),
    "cantilever, 8": released(8, 1.8),
    "cantilever, 16": released(16, 1.8),
    "cantilever, 32": released(32, 1.8),
    "cantilever, 8, damped": released(8, 5.0, 0.02),
    "cantilever, 16, damped": released(16, 5.0, 0.002),
    "spatial cantilever, 2": spatial(2, 0.5),
    "spatial cantilever, 6": spatial(6, 0.5),
    "slider-crank, rod of 2": models.slider_crank(2, 0.1, 50),
    "slider-crank, rod of 8": models.slider_crank(8, 0.1, 50),
    "pendulum, 6 rods": models.pendulum(6, 2.0, 20),
    "spatial pendulum, 3 rods": models.spatial_pendulum(3, 1.0, 20),
    "rigid slider-crank": models.free_slider_crank(10.0, 50),
    "crankfl": models.example("crankfl"),
    "screw": models.example("screw"),
    "trike2": models.example("trike2"),
}


def one(deck: object, code: int, most: float, **options: object) -> tuple[float, int]:
    """Processor time [s] (inf: failed or stopped) and right-hand sides of a run."""
    seconds: list[float] = []
    rhs = 0
    while not seconds or (len(seconds) < REPEATS and sum(seconds) < SHORT):
        rhs, begun = 0, time.process_time()
        try:
            for frame in spacar.frames(1, deck, integrator=code, **options):
                rhs += frame.statistics.get("rhs", 0)
                if time.process_time() - begun > most:
                    return float("inf"), rhs
        except AnalysisError:
            return float("inf"), rhs
        seconds.append(time.process_time() - begun)
    return min(seconds), rhs


def main(words: list[str]) -> None:
    options: dict[str, object] = {"compiled": False} if "--general" in words else {}
    names = [word for word in words if not word.startswith("--")]
    print(f"| model | {' | '.join(map(str, CODES))} | default | regret |\n|{'---|' * (len(CODES) + 3)}")
    regrets = []
    for name in names or MODELS:
        deck = parse_deck(MODELS[name], mode=1) if name in MODELS else spacar.read_deck(name, 1)
        found: dict[int, tuple[float, int]] = {}
        for code in (595, 155, 0, 853, 553):
            least = min((seconds for seconds, _ in found.values()), default=LONGEST)
            found[code] = one(deck, code, min(LONGEST, max(LIMIT * least, 0.1)), **options)
        least = min(seconds for seconds, _ in found.values())
        own, rhs = one(deck, -1, LONGEST, **options)
        regrets.append(own / least)
        cells = [f"{found[code][0]:.3g} s, {found[code][1]}" for code in CODES]
        print(f"| {name} | {' | '.join(cells)} | {own:.3g} s, {rhs} | {own / least:.2f} |", flush=True)
    regrets.sort()
    print(f"\nregret: median {median(regrets):.2f}, largest {regrets[-1]:.2f}, of {len(regrets)} models")


if __name__ == "__main__":
    main(sys.argv[1:])
