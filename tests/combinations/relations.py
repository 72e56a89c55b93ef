"""Relations between runs of one model: by how much the largest difference exceeds what is allowed, and where."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

import spacar
from spacar.errors import SpacarError

from . import transformations
from .cases import model_of
from .compare import disagreement, quantities, stiffness_of
from .model import Model
from .transformations import Back

Found = tuple[float, str]
GENERAL = 1e-11  # of the size of the mechanism: how exactly positions are known in NumPy (developer guide, evaluators)
CONDITION = 300.0  # models with a larger condition number of the positions are drawn anew
BEYOND = ("statics.limit-point", "statics.no-solution", "element.range", "element.lift-off", "position.singular",
          "position.no-convergence")  # fmt: skip


@dataclass
class Case:
    """A model, a folder for its files, and the random choices of its relations."""

    model: Model
    folder: Path
    rng: random.Random

    def run(self, model: Model | None = None, mode: int | None = None, **options: Any) -> spacar.Result:
        model = model or self.model
        mode = model.mode if mode is None else mode
        folder = Path(tempfile.mkdtemp(dir=self.folder)) if model.pushes or model.drives else self.folder
        return spacar.run(mode, model.deck(folder, mode), **{**model.options, **options})

    @cached_property
    def positions(self) -> float:
        """Condition number of the positions at the start."""
        return float(self.run(mode=0).header["condition"])

    @cached_property
    def condition(self) -> float:
        """That of the positions times that of the stiffness matrix of a stationary state."""
        found = self.base.frames[-1].matrices
        if not {"k0", "n0", "g0"} <= found.keys() or not found["k0"].size:
            return self.positions
        return self.positions * float(np.linalg.cond(found["k0"] + found["n0"] + found["g0"]))

    @cached_property
    def base(self) -> spacar.Result:
        return self.run()

    @cached_property
    def values(self) -> dict:
        return quantities(self.model, self.base)

    def agrees(self, result: spacar.Result, back: Back | None = None, error: float = 0.0) -> Found:
        """The result is that of the model itself."""
        other = quantities(self.model, result, back)
        return disagreement(self.values, other, self.condition, stiffness_of(self.model), error)


def transformed(name: str) -> Callable[[Case], Found]:
    def relation(case: Case) -> Found:
        model, back = getattr(transformations, name)(case.model, case.rng)
        return case.agrees(case.run(model), back)

    return relation


def engines(case: Case) -> Found:
    """NumPy and C."""
    return case.agrees(case.run(compiled=False), error=GENERAL * case.condition)


RELATIONS: dict[str, Callable[[Case], Found]] = {
    "renumbered": transformed("renumbered"),
    "reordered": transformed("reordered"),
    "turned": transformed("turned"),
    "exchanged": transformed("exchanged"),
    "engines": engines,
}


def drawn(seed: int, types: Sequence[str], properties: Sequence[str], mode: int, folder: Path) -> Case:
    """The first case of a seed that is well-conditioned and that its loads do not carry beyond a limit point, a range
    of the theory or off the ground. Any other refusal is a finding."""
    for attempt in range(20):
        model = model_of(1000 * attempt + seed, types, properties, mode)
        case = Case(model, folder, random.Random(seed))
        try:
            if case.positions < CONDITION and case.values:
                return case
        except SpacarError as error:
            if error.code not in BEYOND:
                raise AssertionError(f"{error}\n{model.text()}") from error
    raise AssertionError("no model")
