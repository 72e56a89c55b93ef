"""Relations between runs of one model: by how much the largest difference exceeds what is allowed, and where.

The table RELATIONS says in which modes each holds.
"""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from spacar_formats.sbf import SbfFile

import spacar
from spacar.deck.rewrite.divide import TORSION
from spacar.errors import SpacarError
from spacar.frame import E_FIELDS, X_FIELDS
from spacar.integrators.methods import METHODS
from spacar.kinematics.element_sweep import ElementSweep
from spacar.modes import MODES

from . import transformations
from .case import BEYOND, GENERAL, NOTHING, Case, Found, alike, worst
from .compare import EPS, quantities
from .linear_relations import (
    INCREMENTS,
    compliances,
    differences,
    eigen_and_buckling,
    load_steps,
    sensitivities,
    small_division,
    sparse_form,
    state_space,
    torsion,
)
from .motion_relations import energy, inverse, momentum, restarted, rigid_parts, started
from .options import with_mass
from .spatial import as_spatial, planar_again

_UNITS = importlib.util.spec_from_file_location("units_of_decks", Path(__file__).parents[1] / "extremes/units.py")
assert _UNITS is not None
assert _UNITS.loader is not None
units = sys.modules["units_of_decks"] = importlib.util.module_from_spec(_UNITS)
_UNITS.loader.exec_module(units)


def transformed(name: str) -> Callable[[Case], Found]:
    def relation(case: Case) -> Found:
        if name == "exchanged" and of_one_part(case):
            return NOTHING
        model, back = getattr(transformations, name)(case.model, case.rng)
        want, got = case.values, quantities(case.model, case.run(model), back)
        if name == "exchanged" and case.divides:
            want = {k: v for k, v in want.items() if k[0] == "node"}  # the first of several beams is at p
        return case.same(want, got)

    return relation


def of_one_part(case: Case) -> bool:
    """Does the result depend on which end of a divided beam is the first? With start values its inner nodes start from
    there."""
    pushed = {int(p.owner) for p in case.model.pushes if isinstance(p.owner, transformations.Element)}
    parted = any("lies in its last part" in line for line in case.base.report)
    displaced = case.divides and case.model.has("STARTDX", "STARTDE")
    return parted or displaced or bool(pushed & case.base.mechanism.deck.divided.keys())


def engines(case: Case) -> Found:
    """NumPy and C."""
    other = not case.model.options.get("compiled", True)
    return case.agrees(case.run(compiled=other), error=GENERAL * case.condition)


def undeformed(case: Case) -> Found:
    """At the coordinates of X all deformations are zero, but projections of bodies that DRPINBOD counts, and the frames
    of the elements are rotations."""
    mechanism = case.base.mechanism
    sweep = ElementSweep(mechanism)
    sweep.follow(mechanism.x0, np.zeros(sweep.ne))
    sweep.strain(mechanism.x0)
    told = {statement.integer(0) for statement in mechanism.deck.of("DRPINBOD")}
    free = [i for i in range(sweep.ne) if mechanism.numbering.e_owner(i)[0] not in told]
    off = np.abs(sweep.e / mechanism.deformation_scale)[free].max(initial=0.0)
    both = [F for batch in mechanism.batches for F in (batch.family.frame_p, batch.family.frame_q) if F is not None]
    frames = np.concatenate([np.zeros((0, 9)), *both]).reshape(-1, 3, 3)
    turned = np.abs(np.cross(frames[:, 0], frames[:, 1]) - frames[:, 2]).max(initial=0.0)
    skew = max(turned, np.abs(frames @ frames.swapaxes(1, 2) - np.eye(3)).max(initial=0.0))
    return worst([
        (float(off / (64 * EPS)), f"a deformation of {off:.3g} of its size at the coordinates of X"),
        (float(skew / (64 * EPS)), f"a frame of an element is no rotation by {skew:.3g}"),
    ])


def starts(case: Case) -> Found:
    """NumPy and C where a motion from the last state begins: accelerations, stresses and linearized equations."""
    still = started(case.model, case.base, -1)
    still = still.without("TIMESTEP", "INTEGRAT", "ERROR", "ITERSTEP", "MODES", *INCREMENTS.values())
    runs = alike(*(partial(case.run, still, mode=4, compiled=compiled) for compiled in (True, False)))
    if runs is None:
        return undeformed(case)  # wheels that the loads, which are left out, hold on the ground
    a, b = runs
    found = [undeformed(case), case.same(*(quantities(still, r) for r in (a, b)), GENERAL * case.positions)]
    for table in ("matrices", "state_space"):
        want, got = (getattr(r.frames[0], table) for r in (a, b))
        found += [case.close(want[n], got[n], n, GENERAL * case.condition, 1.0) for n in want]
    return worst(found)


def other_units(case: Case) -> Found:
    """Units of powers of two, time among them: the same digits. What user functions say has units too."""
    if case.model.has("INTEGRAT") and METHODS[case.model.rows("INTEGRAT")[0][1]].needs_jacobian:
        return NOTHING  # ERROR has a unit there: the tolerance of an iteration
    system = units.System(*(2.0 ** case.rng.randint(-6, 6) for _ in range(3)))
    deck = case.deck()
    if deck.divided and (case.model.drives or case.model.pushes):
        return NOTHING  # the converted deck has the parts, whose numbers mean something else to a function
    dimensions = units.Dimensions(deck)

    def factor(owner: int, index: int, power: int = 1, more: tuple[int, int, int] = (0, 0, 0)) -> float:
        own = dimensions.node(owner) if owner in case.model.roles and is_node(owner) else dimensions.mode(owner, index)
        return system.factor(
            units.per(more, *(own,) * -power) if power < 0 else units.per(more, tuple(-k for k in own))
        )

    def is_node(owner: int) -> bool:
        return isinstance(owner, transformations.Node)

    pushes = []
    for p in case.model.pushes:
        force, stiff = (factor(p.owner, p.index, k, units.ENERGY) for k in (-1, -2))
        moved = replace(p, c=p.c * force, a=p.a * force, w=p.w / system.s, k=p.k * stiff, d=p.d * stiff * system.s)
        pushes.append(replace(moved, z0=p.z0 * factor(p.owner, p.index)))
    drives = [
        replace(d, z0=d.z0 * factor(d.owner, d.index), a=d.a * factor(d.owner, d.index), w=d.w / system.s)
        for d in case.model.drives
    ]
    functions = replace(case.model, pushes=tuple(pushes), drives=tuple(drives))
    converted = replace(units.convert(replace(deck, path=None), system), path=case.deck(functions).path)
    result = spacar.run(case.model.mode, converted, **case.model.options)
    scaled = [units.back(frame, result.mechanism, system) for frame in result.frames]
    numbering = result.mechanism.numbering
    found = {}
    for (kind, n, variable), want in case.values.items():
        table = numbering.le if kind == "element" else numbering.lnp
        rows = table[n - 1][table[n - 1] > 0] - 1
        found[kind, n, variable] = np.array([frame[variable][rows] for frame in scaled]).reshape(want.shape)
    return case.same(case.values, found)


def files(case: Case) -> Found:
    """The result file holds what the result in memory holds, bit by bit."""
    paths = case.base.save(case.folder / "saved")
    sbd = next(p for p in paths if p.suffix == ".sbd")
    with SbfFile(sbd) as file:
        for name in (*X_FIELDS, *E_FIELDS):
            want = case.base[name]
            for k in range(len(want)):
                if not np.array_equal(np.ravel(file.get(name, k + 1)), want[k]):
                    return np.inf, f"{name} of step {k + 1}"
    return 0.0, ""


def divisions(case: Case) -> Found:
    """Every way of dividing beams gives the same: --elements, the refined deck as text, twice two for four."""
    still = ("STARTDX", "STARTDE") if MODES[case.model.mode].stationary else ()  # a guess that is far for many elements
    deck = case.deck(with_mass(case.model).without("TIMESTEP", "INTEGRAT", *still))
    finer = case.divided(case.rng.choice((2, 3)), deck)
    if finer is None:
        return NOTHING
    try:
        a, four, again = map(case.result, (finer, case.divided(4, deck), case.divided(2, case.divided(2, deck))))
    except SpacarError as error:
        if error.code not in BEYOND:
            raise
        return NOTHING  # beyond its theory with the masses that divided beams need, or without its start
    if finer.divided.keys() & {int(d.owner) for d in case.model.drives if isinstance(d.owner, transformations.Element)}:
        return NOTHING  # what a function says of a beam is about its first part where the parts are written down
    text = replace(spacar.parse_deck(finer.to_text(), mode=case.model.mode), path=finer.path)
    nodes = [{k: v for k, v in quantities(case.model, r).items() if k[0] == "node"} for r in (four, again)]
    same = case.same(quantities(case.model, a), quantities(case.model, case.result(text)))
    same = worst([same, case.same(*nodes, error=64 * 16 * EPS * case.condition)])  # stiffness of a quarter: 16 times
    return worst([same, together(case, a)]) if MODES[case.model.mode].integrated else same


def together(case: Case, result: spacar.Result) -> Found:
    """The parts of a beam have together the elongation and the torsion that the file gives to it."""
    found = [NOTHING]
    for name, e, mode, value, *_ in case.model.rows("INPUTE", "STARTDE", block=2):
        parts = result.mechanism.deck.divided.get(int(e), ())
        if parts and mode in (1, TORSION[case.model.types[e]]):
            total = sum(result.element(k, mode)[0] for k in parts) * (1 if mode == 1 else len(parts))  # length x angle
            found.append(case.close(value, total, f"{name} {e} {mode} of {len(parts)} parts", GENERAL, 1.0))
    return worst(found)


def sweeps(case: Case) -> Found:
    """Cases of a sweep are single runs with these numbers."""
    rows = [r for r in case.model.rows("XM", "XF", "ESTIFF", "EM", block=2) if isinstance(r[2], float)]
    if not rows or "elements" in case.model.options:  # a sweep is about the numbers of the file
        return NOTHING
    r = case.rng.choice(rows)
    node = case.rng.choice(sorted(case.model.roles))
    name, values = f"{r[0]}.{int(r[1])}[2]", [r[2], 1.3 * r[2]]
    want = []
    for v in values:
        other = case.model.mapped(lambda s, b, v=v: [(*s[:2], v, *s[3:])] if s == r and b == 2 else [s])
        if (runs := alike(partial(case.run, other))) is None:
            return NOTHING  # beyond its theory with this number
        want.append(runs[0].node(node, 1)[-1])
    rows = spacar.sweep(case.deck(), {name: values}, f"y: x[{node},1]@end", mode=case.model.mode, **case.model.options)
    return case.close(want, [row["y"] for row in rows], f"sweep of {name}, x[{node},1]", GENERAL * case.condition, 1.0)


@dataclass(frozen=True)
class Relation:
    """What is compared, and in which modes it holds."""

    compare: Callable[[Case], Found]
    modes: tuple[int, ...]


ALL = tuple(m for m in MODES if m != 3)
MOTION = tuple(m for m, row in MODES.items() if row.integrated)
STILL = tuple(m for m, row in MODES.items() if row.stationary)
LINEAR = tuple(m for m in STILL if MODES[m].linearized)
RELATIONS: dict[str, Relation] = {
    "renumbered": Relation(transformed("renumbered"), ALL),
    "reordered": Relation(transformed("reordered"), ALL),
    "turned": Relation(transformed("turned"), ALL),
    "exchanged": Relation(transformed("exchanged"), ALL),
    "quartered": Relation(transformed("quartered"), ALL),
    "engines": Relation(engines, ALL),
    "starts": Relation(starts, tuple(m for m in (*MOTION, *STILL) if m != 3)),
    "other units": Relation(other_units, (*MOTION, *STILL)),
    "as spatial": Relation(as_spatial, (*MOTION, *STILL)),
    "planar again": Relation(planar_again, (*MOTION, *STILL)),
    "files": Relation(files, ALL),
    "divisions": Relation(divisions, (*MOTION, *STILL)),
    "sweeps": Relation(sweeps, (*MOTION, *STILL)),
    "rigid parts": Relation(rigid_parts, (*MOTION, *STILL)),
    "restarted": Relation(restarted, MOTION),
    "energy": Relation(energy, MOTION),
    "momentum": Relation(momentum, MOTION),
    "differences": Relation(differences, (4,)),
    "inverse": Relation(inverse, (2,)),
    "load steps": Relation(load_steps, STILL),
    "small division": Relation(small_division, STILL),
    "eigen and buckling": Relation(eigen_and_buckling, (10,)),
    "state space": Relation(state_space, (9,)),
    "sparse form": Relation(sparse_form, (4, 9)),
    "torsion": Relation(torsion, STILL),
    "compliances": Relation(compliances, (8,)),
    "sensitivities": Relation(sensitivities, (7, 8, 10)),
}


def disagreements(case: Case, names: Iterable[str], count: int = 99) -> dict[str, str]:
    """Of the first relations that say something about the model, `count` at most, those that do not hold, and where."""
    bad = {}
    for name in names:
        try:
            ratio, where = found = RELATIONS[name].compare(case)
        except SpacarError as error:  # what the model can, its other forms can
            ratio, where = found = (np.inf, f"{error.code}: {error}")
        if not ratio <= 1.0:
            bad[name] = f"{where} ({ratio:.3g} times)"
        count -= found is not NOTHING
        if not count:
            break
    return bad
