"""What a run can be asked for besides its model: engine, integrator, division, measure of beams, load steps ...

An option changes a model, or gives None where it has no place; `modes` are those that take it.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from spacar.deck import ELEMENT_TYPES
from spacar.deck.deck import parse
from spacar.deck.rewrite.divide import obstacles
from spacar.deck.table_solvers import INTEGRATORS
from spacar.integrators.methods import METHODS
from spacar.kinematics.kinematics import CONVERGED
from spacar.modes import MODES, Mode
from spacar.stationary.loading import WITHOUT_N0
from spacar.stationary.newton import LENGTHS

from .model import Element, Model


def error_of(code: int) -> float:
    """ERROR of variable steps: what methods of low order reach with some hundred of them."""
    return 1e-5 if METHODS[code].order == 2 else 1e-7 if METHODS[code].order == 3 else 1e-10


@dataclass(frozen=True)
class Option:
    modes: Callable[[Mode], bool]
    change: Callable[[Model, random.Random], Model | None]


def options(**more: Any) -> Callable[[Model, random.Random], Model]:
    return lambda model, rng: replace(model, options={**model.options, **more})


def row(*words: Any, block: int = 2) -> Callable[[Model, random.Random], Model]:
    """A statement in place of one with the same keyword."""
    return lambda model, rng: model.without(words[0]).more(block, words)


def integrator(code: int) -> Callable[[Model, random.Random], Model]:
    def change(model: Model, rng: random.Random) -> Model:
        error = error_of(code)
        if (METHODS[code].order in (2, 3) or METHODS[code].needs_jacobian) and model.has("TIMESTEP"):
            model = model.without("TIMESTEP").more(2, ("TIMESTEP", 0.05, 4))
        return model.without("INTEGRAT", "ERROR").more(2, ("INTEGRAT", code, 0.025), ("ERROR", error, error))

    return change


def load_steps(place: int, value: int) -> Callable[[Model, random.Random], Model]:
    """A word of ITERSTEP; additional loading stays what it is."""

    def change(model: Model, rng: random.Random) -> Model:
        step = list(model.rows("ITERSTEP")[0])
        step += [0] * (8 - len(step))
        step[place] += value
        return model.without("ITERSTEP").more(2, tuple(step))

    return change


def with_mass(model: Model) -> Model:
    """With rotary inertia of every beam, which nodes between divided beams need; short steps for their frequencies."""
    beams = {e: k for e, k in model.types.items() if ELEMENT_TYPES[k].split and e not in sections_of(model)}
    heavy = model.mapped(lambda r, b: [] if r[0] == "EM" and r[1] in beams else [r])
    rows = [("EM", Element(e), 0.4, *(0.05 for _ in range(1 if model.planar else 3))) for e in beams]
    rows = [(*r, 0.0, 0.02) if beams[r[1]] == "BEAMW" else r for r in rows]
    return finely(heavy.more(2, *rows))


def finely(model: Model) -> Model:
    """With steps in which the fourth-order method is stable, omega h < 2.8: quarters of beams reach 1e4 rad/s."""
    if not (MODES[model.mode].integrated and model.has("TIMESTEP")):
        return model
    return model.without("TIMESTEP", "INTEGRAT").more(2, ("TIMESTEP", 0.002, 4), ("INTEGRAT", 140, 0.000125))


def sections_of(model: Model) -> set[int]:
    return {int(r[1]) for r in model.rows("BEAMSEC")}


def divided(model: Model, rng: random.Random) -> Model | None:
    flexible = {r[1] for r in model.rows("DYNE", "INPUTE", "RLSE", block=1)}
    if not any(ELEMENT_TYPES[k].split and Element(e) in flexible for e, k in model.types.items()):
        return None
    model = with_mass(model)
    if MODES[model.mode].stationary:
        model = model.without("STARTDX", "STARTDE")  # a guess that is far for many elements
    return replace(model, options={**model.options, "elements": rng.choice((2, 3))})


def sections(model: Model, rng: random.Random) -> Model | None:
    """Beams by section and material, some divided in the file."""
    beams = [Element(e) for e, k in model.types.items() if k in ("PLBEAM", "BEAM")]
    if not beams:
        return None
    chosen = rng.sample(beams, rng.randrange(1, len(beams) + 1))
    stiff = {int(e): dict.fromkeys(range(1, 7), 1.0) for e in chosen}
    whole = {beam for beam, *_ in obstacles(parse(model.text(), "case.dat", model.mode).statements, stiff, stiff)}
    model = model.mapped(lambda r, b: [] if r[0] in ("ESTIFF", "EM") and r[1] in chosen else [r])
    bar = ("SECTION", "bar", "CUSTOM", 0.8, 0.11, 0.13, 0.24), ("MATERIAL", "stuff", 100.0, 50.0, 0.5)
    parts = (("BEAMSEC", e, "bar", "stuff", *rng.choice(((),) if e in whole else ((), (2,)))) for e in chosen)
    return finely(model.more(1, *bar, *parts))


def dynamic(mode: Mode) -> bool:
    return mode.forces and not mode.gives_setpoints and not mode.takes_setpoints


OPTIONS: dict[str, Option] = {
    "as it is": Option(lambda m: True, options()),
    "NumPy": Option(lambda m: True, options(compiled=False)),
    "elements": Option(dynamic, divided),
    "sections": Option(dynamic, sections),
    "angle measure": Option(lambda m: True, options(beams="angle")),
    "sine measure": Option(lambda m: True, options(beams="sine")),
    "transfer functions": Option(lambda m: True, row("OUTLEVEL", 15, 3, block=1)),
    "start only": Option(lambda m: m.integrated, lambda model, rng: model.without("TIMESTEP", "INTEGRAT")),
    "N0 zero": Option(lambda m: m.stationary, load_steps(5, 1)),
    "path following": Option(lambda m: m.stationary, load_steps(7, 1)),
    "lowest modes": Option(lambda m: (m.linearized and m.stationary) or m.buckling, row("MODES", 2)),
    **{f"integrator {code}": Option(lambda m: m.integrated, integrator(code)) for code in INTEGRATORS},
}


def asked(model: Model) -> float:
    """What two runs may differ by, of the largest value: the ERROR of variable steps times what the steps make of it,
    a Jacobian from differences, what Newton's iteration leaves of its linear convergence without N0 and with wheels,
    and of a position along a trajectory."""
    if MODES[model.mode].gives_setpoints or MODES[model.mode].takes_setpoints:
        return 2 * CONVERGED
    rolls = MODES[model.mode].stationary and any(ELEMENT_TYPES[k].slips for k in model.types.values())
    if rolls or any(len(r) > 5 and r[5] in WITHOUT_N0 for r in model.rows("ITERSTEP")):
        return 2 * LENGTHS
    for r in model.rows("INTEGRAT"):
        method = METHODS[r[1]]
        return 100 * error_of(r[1]) if method.variable_step else 1e-7 if method.needs_jacobian else 0.0
    return 0.0
