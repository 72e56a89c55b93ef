"""A drawn model with its runs: what relations work on."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

import spacar
from spacar.deck import Deck
from spacar.errors import SpacarError, UsageError
from spacar.modes import MODES

from .cases import model_of
from .compare import EPS, disagreement, quantities, stiffness_of
from .model import Model
from .options import OPTIONS, asked
from .transformations import Back

Found = tuple[float, str]
NOTHING: Found = (0.0, "the relation says nothing about this model")
GENERAL = 1e-11  # of the size of the mechanism: how exactly positions are known in NumPy (developer guide, evaluators)
CONDITION = 300.0  # models with a larger condition number of the positions are drawn anew
BEYOND = ("statics.limit-point", "statics.no-solution", "element.range", "element.lift-off", "position.singular",
          "position.no-convergence", "statics.not-steady", "study.refine")  # fmt: skip


@dataclass
class Case:
    """A model, a folder for its files, and the random choices of its relations."""

    model: Model
    folder: Path
    rng: random.Random

    def deck(self, model: Model | None = None, mode: int | None = None) -> Deck:
        """The checked deck; user functions stand in a folder of their own."""
        model = model or self.model
        folder = Path(tempfile.mkdtemp(dir=self.folder)) if model.pushes or model.drives else self.folder
        return model.deck(folder, mode)

    def run(self, model: Model | None = None, mode: int | None = None, **options: Any) -> spacar.Result:
        model = model or self.model
        mode = model.mode if mode is None else mode
        nominal = self.run(model, 2) if MODES[mode].takes_setpoints else None
        return spacar.run(mode, self.deck(model, mode), nominal=nominal, **{**given(model, mode), **options})

    def divided(self, n: int, deck: Deck | None = None) -> Deck | None:
        """The deck with n beams in the place of each; None where none can be divided."""
        deck = deck or self.deck()
        try:
            return spacar.frames(deck.mode, deck, elements=n).mechanism.deck
        except UsageError as error:
            if error.code != "study.refine":
                raise
            return None

    def result(self, deck: Deck, mode: int | None = None) -> spacar.Result:
        """A run of a deck that was made of that of the model."""
        return spacar.run(self.model.mode if mode is None else mode, deck, **self.model.options)

    @cached_property
    def positions(self) -> float:
        """Condition number of the positions at the start."""
        return float(self.run(mode=0).header["condition"])

    @cached_property
    def condition(self) -> float:
        """That of the positions times that of the mass matrix of a motion, or the stiffness of a stationary state."""
        row = MODES[self.model.mode]
        positions = max(self.positions, float(self.base.header.get("condition", 1.0)))  # of divided beams too
        if row.integrated:
            start = self.base if row.linearized else self.run(mode=4)
            mass = start.frames[0].matrices.get("m0", np.zeros((0, 0)))
            return positions * (float(np.linalg.cond(mass)) if mass.size else 1.0)
        return positions * condition_of(self.base.frames[-1].matrices)

    @property
    def divides(self) -> bool:
        """Beams are divided in the run: elements of the file are parts of theirs."""
        return "elements" in self.model.options or self.model.has("BEAMSEC")

    @cached_property
    def base(self) -> spacar.Result:
        return self.run()

    @cached_property
    def values(self) -> dict:
        return quantities(self.model, self.base)

    def agrees(self, result: spacar.Result, back: Back | None = None, error: float = 0.0) -> Found:
        """The result is that of the model itself."""
        return self.same(self.values, quantities(self.model, result, back), error)

    def same(self, a: dict, b: dict, error: float = 0.0) -> Found:
        parts = max(self.model.options.get("elements", 1), *((*r[4:], 1)[0] for r in self.model.rows("BEAMSEC")), 1)
        stiffness = stiffness_of(self.model) * parts**2  # of the parts of beams
        return disagreement(a, b, self.condition, stiffness, max(error, asked(self.model)))

    def close(self, want: Any, got: Any, what: str, error: float = 0.0, scale: float = 0.0) -> Found:
        """Two arrays agree within 64 eps times the condition, or `error`, of their size (of `scale` at least)."""
        want, got = np.asarray(want), np.asarray(got)
        if want.shape != got.shape:
            return np.inf, f"{what}: {got.shape} in place of {want.shape}"
        same = (np.isnan(want) & np.isnan(got)) | (want == got)
        want, got = np.where(same, 0.0, want), np.where(same, 0.0, got)
        size = max(np.abs(want).max(initial=0.0), scale)
        limit = max(64 * EPS * self.condition, error, asked(self.model)) * size
        off = float(np.abs(got - want).max(initial=0.0))
        if not np.isfinite(got).all():
            return np.inf, f"{what} is not finite"
        return (off / limit if limit else off), f"{what}: {off:.3g}, allowed {limit:.3g}"


def given(model: Model, mode: int) -> dict[str, Any]:
    """Options of the model that the mode takes."""
    return {k: v for k, v in model.options.items() if k != "elements" or MODES[mode].forces}


def condition_of(matrices: dict) -> float:
    """Condition number of the stiffness of a linearization; 1 where there is none."""
    if not {"k0", "n0", "g0"} <= matrices.keys() or not matrices["k0"].size:
        return 1.0
    return float(np.linalg.cond(matrices["k0"] + matrices["n0"] + matrices["g0"]))


@dataclass(frozen=True)
class Spec:
    """What a case must have; `attempt` is the first one that can be used."""

    seed: int
    types: tuple[str, ...]
    properties: tuple[str, ...]
    mode: int
    option: str = "as it is"
    attempt: int = 0

    def model(self) -> Model | None:
        """None where the option has no place."""
        name = 1000 * self.attempt + self.seed
        model = model_of(name, self.types, self.properties, self.mode)
        return OPTIONS[self.option].change(model, random.Random(name))

    def case(self, folder: Path, refused: list[tuple[str, Spec]] | None = None) -> Case | None:
        """None where the model is badly conditioned, comes to a dead point or goes beyond its theory; then `refused`
        gets the code."""
        model = self.model()
        if model is None:
            return None
        case = Case(model, folder, random.Random(self.seed))
        try:
            if not (case.positions < CONDITION and case.values):
                return None
            dead = any(np.isnan(f.matrices.get("k0", 0.0)).any() for f in case.base.frames)
            return None if dead else case
        except SpacarError as error:
            if error.code not in BEYOND:
                raise AssertionError(f"{error.code}: {error}\n{model.text()}") from error
            if refused is not None:
                refused.append((error.code, self))
            return None


def drawn(spec: Spec, folder: Path, refused: list[tuple[str, Spec]] | None = None) -> tuple[Spec, Case]:
    """The first attempt that can be used: well-conditioned, and its loads do not carry it beyond a limit point, a range
    of the theory or off the ground. Any other refusal is a finding."""
    for attempt in range(spec.attempt, 100):
        found = replace(spec, attempt=attempt)
        if (case := found.case(folder, refused)) is not None:
            return found, case
    raise AssertionError(f"{spec}: no model")


def alike(*runs: Callable[[], Any]) -> list[Any] | None:
    """The results; None where all runs go beyond the theory for the same reason. Raises SpacarError where some do."""
    found, refused = [], []
    for run in runs:
        try:
            found.append(run())
        except SpacarError as error:
            refused.append(error)
    if refused and (found or len({e.code for e in refused}) > 1 or refused[0].code not in BEYOND):
        raise refused[0]
    return None if refused else found


def worst(found: Sequence[Found]) -> Found:
    return max(found, key=lambda f: f[0], default=NOTHING)
