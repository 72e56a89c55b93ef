"""The worked example of docs/sensitivity.md: a leaf-spring guide whose first unwanted frequency becomes as high as the
stress allows, with exact derivatives and, to compare, with differences.

    python docs/optimize_guide.py

Two leaves of six parts each carry a body that is driven 15 mm to the side and held there, so all its natural
frequencies are unwanted. Free are the thicknesses of the parts, the heights where they meet, and where the leaves
stand; both leaves are alike. Lengths in mm.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import OptimizeResult, minimize

import spacar

PARTS, HEIGHT, STROKE = 6, 100.0, 15.0
LIMIT = 600e6  # of the von Mises stress [N/m^2]
MODES = (1, 2, 3)  # frequencies of the body that must be high; they may change their order
STEPS = ("start", "3", "end")  # of the stroke


def guide() -> str:
    """The input file: nodes 2k + 1 of the left leaf, 2k + 21 of the right one, from the ground up; 41 the body."""
    lines = ["UNITS mm", "MATERIAL spring 2.0e5 0.3 7.8e-6"]
    lines += [f"SECTION part{k} RECT 30 0.4" for k in range(1, PARTS + 1)]
    released = {7: "1 2 3 4 5 6", 1: "3"}  # the right leaf closes the loop, the drive takes one bending mode
    for k in range(PARTS + 1):
        y = HEIGHT * k / PARTS
        lines += [f"X {2 * k + 1} -30 {y!r} 0", f"X {2 * k + 21} 30 {y!r} 0"]
    lines.append(f"X 41 0 {HEIGHT!r} 0")
    for k in range(1, PARTS + 1):
        for element, first in ((k, 2 * k - 1), (k + PARTS, 2 * k + 19)):
            lines.append(f"BEAM {element} {first} {first + 1} {first + 2} {first + 3} 0 0 1")
            lines.append(f"BEAMSEC {element} part{k} spring")
            free = released.get(element, "")
            held = " ".join(m for m in "123456" if m not in free)
            lines += [f"DYNE {element} {held}"] * bool(held) + [f"RLSE {element} {free}"] * bool(free)
    top = 2 * PARTS + 1
    lines += [f"BEAM 13 {top} {top + 1} 41 42 0 0 1", f"BEAM 14 41 42 {top + 20} {top + 21} 0 0 1"]
    lines += ["FIX 1", "FIX 2", "FIX 21", "FIX 22", "INPUTX 41 1", "END", "HALT"]
    lines += ["XM 41 0.3", "XM 42 150 0 0 300 0 250", f"DELINPX 41 1 {STROKE!r}", "ITERSTEP 20 4 1e-8 1 2"]
    return "\n".join([*lines, "END", "END", ""])


def parameters() -> tuple[list[str], np.ndarray, np.ndarray, np.ndarray]:
    """Names of the numbers of the deck, start values, lower and upper bounds [mm]."""
    names = [f"SECTION.part{k}[t]" for k in range(1, PARTS + 1)]
    names += [f"X.{2 * k + 1}[3] & X.{2 * k + 21}[3]" for k in range(1, PARTS)]
    names += [" & ".join(f"X.{2 * k + side}[2]" for k in range(PARTS + 1)) for side in (1, 21)]
    heights = HEIGHT * np.arange(1, PARTS) / PARTS
    start = np.concatenate((np.full(PARTS, 0.4), heights, (-30.0, 30.0)))
    low = np.concatenate((np.full(PARTS, 0.15), heights - 7.0, (-35.0, 20.0)))
    high = np.concatenate((np.full(PARTS, 3.0), heights + 7.0, (-20.0, 35.0)))
    return names, start, low, high


@dataclass
class Guide:
    """The guide at any values of its parameters.

    analyses  how often the model was analysed;  course: after every iteration the analyses and the lowest frequency
    """

    exact: bool = True
    analyses: int = 0
    course: list[tuple[int, float]] = field(default_factory=list)
    known: dict[bytes, spacar.Sensitivity] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.deck = spacar.parse_deck(guide(), "guide.dat", 10)
        self.names, self.start, self.low, self.high = parameters()
        self.frequencies = [f"frequency[{k}]@{step}" for step in STEPS for k in MODES]
        self.stresses = [f"mises[{k}]@end" for k in range(1, 2 * PARTS + 1)]

    def at(self, p: np.ndarray) -> spacar.Sensitivity:
        """Quantities, and with `exact` their derivatives, from one analysis."""
        key = p.tobytes()
        if key not in self.known:
            self.analyses += 1
            names = self.names if self.exact else []
            deck = self.deck if self.exact else changed(self.deck, self.names, p)
            self.known[key] = spacar.sensitivity(
                deck, names, [*self.frequencies, *self.stresses], at=p if self.exact else None
            )
        return self.known[key]

    def derivatives(self, p: np.ndarray) -> np.ndarray:
        """(quantities, parameters): exact, or forward differences with steps of 1e-6 of the values."""
        if self.exact:
            return self.at(p).derivatives
        base, columns = self.at(p).values, []
        for j in range(len(p)):
            moved = p.copy()
            moved[j] *= 1.0 + 1e-6
            columns.append((self.at(moved).values - base) / (moved[j] - p[j]))
        return np.array(columns).T


def changed(deck: spacar.Deck, names: list[str], p: np.ndarray) -> spacar.Deck:
    """The deck with other numbers, for analyses without derivatives."""
    from spacar.studies.assignments import change, setting

    return change(deck, [setting(n) for n in names], p.tolist())


def optimize(model: Guide, iterations: int = 60) -> OptimizeResult:
    """Maximize b subject to b <= every frequency and every stress <= LIMIT: variables p (scaled) and b (100 Hz).

    With b the problem stays smooth where the lowest frequency is another one than before.
    """
    n, nf = len(model.start), len(model.frequencies)
    size = model.high - model.low

    def values(z: np.ndarray) -> np.ndarray:
        found = model.at(model.low + z[:n] * size).values
        return np.concatenate((found[:nf] / 100.0 - z[n], 1.0 - found[nf:] / LIMIT))

    def slopes(z: np.ndarray) -> np.ndarray:
        found = model.derivatives(model.low + z[:n] * size) * size
        upper, lower = found[:nf] / 100.0, -found[nf:] / LIMIT
        return np.block([[upper, -np.ones((len(upper), 1))], [lower, np.zeros((len(lower), 1))]])

    def note(z: np.ndarray) -> None:
        found = model.at(model.low + z[:n] * size).values
        model.course.append((model.analyses, float(found[:nf].min())))

    downhill = np.append(np.zeros(n), -1.0)
    lowest = float(model.at(model.start).values[:nf].min())
    model.course.append((1, lowest))
    return minimize(
        lambda z: -z[n], np.append((model.start - model.low) / size, lowest / 100.0), jac=lambda z: downhill,
        method="SLSQP", bounds=[(0.0, 1.0)] * n + [(0.0, None)], callback=note,
        constraints={"type": "ineq", "fun": values, "jac": slopes}, options={"maxiter": iterations, "ftol": 1e-4},
    )  # fmt: skip


def found_parameters(model: Guide, found: OptimizeResult) -> np.ndarray:
    """Parameters [mm] of the result of `optimize`."""
    return np.asarray(model.low + found.x[:-1] * (model.high - model.low))


def report(model: Guide, found: OptimizeResult) -> str:
    p = found_parameters(model, found)
    q = model.at(p).values
    n = len(model.frequencies)
    return (
        f"{found.nit} iterations, {model.analyses} analyses: lowest frequency {q[:n].min():.2f} Hz, largest stress "
        f"{q[n:].max() / 1e6:.1f} MPa\n  thickness {np.round(p[:PARTS], 3)} mm\n"
        f"  heights {np.round(p[PARTS:-2], 2)} mm, leaves at {np.round(p[-2:], 2)} mm\n  {found.message}"
    )


if __name__ == "__main__":
    for exact in (True, False):
        guide_ = Guide(exact)
        first = guide_.at(guide_.start).values
        n = len(guide_.frequencies)
        print("start", f"{first[:n].min():.2f} Hz, {first[n:].max() / 1e6:.1f} MPa")
        print("exact derivatives:" if exact else "differences:", report(guide_, optimize(guide_)))
