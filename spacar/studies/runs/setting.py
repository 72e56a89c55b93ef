"""Speed against accuracy: one model with many settings of mesh and integration, timed and compared with a reference.

A `Setup` is one way to compute the same thing. Every setup is run (the reference ones too) to a row with the values of
the chosen variables at the output times, its median processor time and the number of its right-hand sides;
`spacar.studies.policies.trade` turns rows into errors, in the norm of `spacar.studies.runs.result_quantities`.
"""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from spacar.calls import frames, integrator
from spacar.deck import Deck
from spacar.deck.deck import rebuilt
from spacar.deck.deck_writer import rows
from spacar.deck.rewrite.coarser import merged
from spacar.deck.rewrite.in_plane import planar
from spacar.deck.rewrite.refine import linear_strain, refine, refine_divisible, rigid
from spacar.errors import UsageError
from spacar.integrators.methods import METHODS
from spacar.mechanism import build
from spacar.mechanism.inputs import settings
from spacar.mechanism.user_files import model_digest
from spacar.modes import find_mode
from spacar.result import Result
from spacar.studies.perturbation import perturbation, require_perturbation
from spacar.studies.policies.sweep import explain
from spacar.studies.runs.compared import compared
from spacar.studies.runs.quantities import Quantity, quantity
from spacar.studies.runs.result_quantities import free_coordinates
from spacar.studies.runs.rows import Row, key

MOST_VARIABLES = 600  # that are compared when the user names none
LONG = 1.0  # seconds, after which a run with a limit is not repeated: its time is known well enough


@dataclass(frozen=True)
class Setup:
    """One way to compute. `elements` per beam of the file; beams flexible, "rigid" or "rigid 1 3" (these); strain full
    or linear (LDEFORM); `planar`: planar elements; `merged`: alike beams in one line are one; `transfer`: output of
    OUTLEVEL as in the file.

    `integrator`, `tolerance` (relative; the absolute one keeps its ratio of ERROR) of variable step codes, `substeps`
    per output step of fixed step codes; None in the stationary modes. `method` full, or perturbation (with `substeps`).
    """

    elements: int = 1
    beams: str = "flexible"
    strain: str = "full"
    integrator: int | None = None
    tolerance: float | None = None
    substeps: int | None = None
    method: str = "full"
    measure: str = ""  # of the deformations of beams, "angle" or "sine"; "": that of the file
    general: bool = False  # equations in NumPy where they could be in C
    planar: bool = False
    merged: bool = False
    transfer: bool = True

    @property
    def model(self) -> str:
        parts = ["rigid beams"]
        if self.beams != "rigid":
            parts = ["as given" if self.elements == 1 else f"{self.elements} elements a beam"]
            parts += [f"{self.measure} measure"] * bool(self.measure) + [self.beams] * (self.beams != "flexible")
        parts += ["linear strain"] * (self.strain == "linear") + ["merged beams"] * self.merged
        parts += ["planar"] * self.planar
        return ", ".join(parts + ["OUTLEVEL 0 0"] * (not self.transfer))

    @property
    def integration(self) -> str:
        """Integration in words; empty in the stationary modes."""
        if self.method == "perturbation":
            return f"perturbation, {self.substeps} steps an output"
        if self.integrator is None:
            return ""
        how = f"tol {self.tolerance:.3g}" if self.substeps is None else f"{self.substeps} steps an output"
        return f"{self.integrator} {how}" + (", general" if self.general else "")


@dataclass(frozen=True)
class Trade:
    """The question: a checked deck in a mode, variables, repeats of the timing, options of `spacar.run`.

    Without variables, in the stationary modes only, it is about what `spacar.studies.runs.result_quantities` says:
    coordinates and reactions of the nodes of the deck, the lowest frequencies and load multipliers.
    """

    mode: int
    deck: Deck
    variables: tuple[Quantity, ...]
    repeats: int = 3
    options: dict[str, Any] = field(default_factory=dict)
    named: bool = False  # did the user choose the variables?

    @property
    def stationary(self) -> bool:
        return find_mode(self.mode).stationary

    def key(self, setup: Setup) -> str:
        """What tells the row of this setup from others."""
        asked, options = [v.text for v in self.variables], sorted(self.options.items())
        return key(model_digest(self.deck), self.mode, asked, self.repeats, options, asdict(setup))


class Job(NamedTuple):
    """A setup on its way to a process."""

    trade: Trade
    setup: Setup
    limit: float | None = None  # seconds; a run that takes longer is stopped and has failed


def default_variables(mode: int, deck: Deck) -> tuple[Quantity, ...]:
    """All coordinates that the motion determines: calculable, dynamic, kinematic; none in the stationary modes, where
    more counts than coordinates. Raises UsageError when too many."""
    if find_mode(mode).stationary:
        return ()
    mechanism = build(deck, mode)
    names = [mechanism.numbering.x_owner(i) for i in free_coordinates(mechanism).tolist()]
    if not 0 < len(names) <= MOST_VARIABLES:
        text = f"the model has {len(names)} free coordinates; choose with --variable, for instance 'x[3,1]'"
        raise UsageError(text, "study.trade")
    return tuple(quantity(f"x[{node},{c}]") for node, c in names)


def setups(
    trade: Trade, integrators: Sequence[int], tolerances: Sequence[float], substeps: Sequence[int],
    elements: Sequence[int] = (1,), rigid_too: bool = False, linear_too: bool = False,
    perturbation_too: bool = False,
) -> list[Setup]:  # fmt: skip
    """Every model with every integration (stationary modes: every model). Raises UsageError for models or methods that
    do not exist."""
    models = [Setup(n) for n in elements]
    models += [Setup(n, strain="linear") for n in elements] if linear_too else []
    models += [Setup(beams="rigid")] if rigid_too else []
    for n in elements:
        refine(trade.deck, n) if n != 1 else None
    for model in models:
        variant(trade.deck, model)
    if trade.stationary:
        if perturbation_too:
            raise UsageError("the perturbation method is for mode 1", "study.perturbation")
        return models
    found = []
    for model in models:
        for wanted in integrators:
            code, _ = integrator(wanted, "integrator")
            if METHODS[code].variable_step:
                found += [replace(model, integrator=code, tolerance=tol) for tol in tolerances]
            else:
                found += [replace(model, integrator=code, substeps=k) for k in substeps]
        if perturbation_too and model.beams == "flexible":
            require_perturbation(variant(trade.deck, model), **trade.options)
            found += [replace(model, substeps=k, method="perturbation") for k in substeps]
    return found


def variant(deck: Deck, setup: Setup) -> Deck:
    """The model of a setup. Raises UsageError when the deck has no such variant."""
    if setup.planar:
        deck = planar(deck)
    if setup.beams != "flexible":
        deck = rigid(deck, map(int, setup.beams.split()[1:]))
    if setup.merged:
        deck = merged(deck)[0]
    if setup.strain == "linear":
        deck = linear_strain(deck)
    if not setup.transfer:
        kept = [s for s in deck.statements if s.keyword != "OUTLEVEL"]
        first, second, third = rows(kept)
        deck = rebuilt(deck, first, [*second, ("OUTLEVEL", 0, 0)], third, what=" (OUTLEVEL 0 0)")
    return refine_divisible(deck, setup.elements)[0] if setup.elements != 1 and setup.beams != "rigid" else deck


def run_setup(job: Job) -> Row:
    """Run one setup as often as wanted, to a row; a failure is a row with its reason."""
    trade, setup = job.trade, job.setup
    row: Row = {"case": trade.key(setup), **asdict(setup), "status": "failed"}
    try:
        deck = variant(trade.deck, setup)
        options = setup_options(trade, setup)
        seconds = []
        for _ in range(trade.repeats):
            begun = time.process_time()
            result = _run(trade, setup, deck, options, job.limit)
            seconds.append(time.process_time() - begun)
            if job.limit is not None and ((len(seconds) + 1) * seconds[-1] > job.limit or sum(seconds) > LONG):
                break
        found = compared(trade.deck, trade.mode, trade.variables, result, fewer=setup.merged or setup.planar)
        row["names"], row["values"] = list(found.names), found.values.tolist()
        row["amplitude"] = [a if np.isfinite(a) else None for a in found.amplitude]
        row["seconds"] = float(np.median(seconds))
        row["rhs"] = int(sum(f.statistics.get("rhs", 0) for f in result.frames))
        row["status"] = "done"
    except Exception as error:
        row["reason"] = explain(error)
        row["stopped"] = getattr(error, "code", "") == "study.stopped"
    return row


def _run(trade: Trade, setup: Setup, deck: Deck, options: dict[str, Any], limit: float | None = None) -> Result:
    if setup.method == "perturbation":
        return perturbation(deck, setup.substeps or 1, **options)
    run = frames(trade.mode, deck, **options)
    if limit is not None:
        run.end = time.process_time() + limit
    return Result.collect(run)


def setup_options(trade: Trade, setup: Setup) -> dict[str, Any]:
    options = dict(trade.options)
    if setup.measure:
        options["beams"] = setup.measure
    if setup.general:
        options["compiled"] = False
    if setup.integrator is not None:
        given = settings(trade.deck, **options)
        options["integrator"] = setup.integrator
        if setup.tolerance is not None:
            ratio = given.atol / given.rtol if given.rtol > 0.0 else 1.0
            options |= {"rtol": setup.tolerance, "atol": setup.tolerance * ratio}
        elif given.duration is not None:
            options["step"] = given.duration / given.n_steps / (setup.substeps or 1)
    return options
