"""The script inside a functional mock-up unit: the mechanism of `plant.json` beside it, run by spacar.

It is copied into the unit as it is; nothing of a model is written into it. pythonfmu calls it by the class.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

from spacar.simulation.co_simulation import CoSimulation
from spacar.simulation.plant import Spasim


class SpacarPlant(Fmi2Slave):
    """Inputs and outputs of the mechanism as variables of the unit [SI units]."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        folder = Path(options.get("resources") or Path(__file__).parent)
        words = json.loads((folder / "plant.json").read_text(encoding="utf-8"))
        self.modelName = words["name"]
        self.description = f"mechanism {words['title']}, simulated by spacar"
        self._make = lambda t: CoSimulation(Spasim(folder / words["model"]), t, words["rtol"], words["atol"])
        self._plant = self._make(0.0)
        self._known: np.ndarray | None = None
        for k, (name, text) in enumerate(zip(words["inputs"], words["input_texts"], strict=True)):
            self.register_variable(
                Real(
                    name, causality=Fmi2Causality.input, variability=Fmi2Variability.continuous, description=text,
                    getter=lambda k=k: float(self._plant.u[k]), setter=lambda v, k=k: self._set(k, v),
                )
            )  # fmt: skip
        for k, (name, text) in enumerate(zip(words["outputs"], words["output_texts"], strict=True)):
            self.register_variable(
                Real(
                    name, causality=Fmi2Causality.output, variability=Fmi2Variability.continuous, description=text,
                    getter=lambda k=k: self._get(k),
                )
            )  # fmt: skip

    def _set(self, k: int, value: float) -> None:
        self._plant.u[k], self._known = value, None

    def _get(self, k: int) -> float:
        if self._known is None:
            self._known = self._plant.outputs()
        return float(self._known[k])

    def setup_experiment(
        self, start_time: float, stop_time: float | None = None, tolerance: float | None = None
    ) -> None:
        u = self._plant.u
        self._plant, self._known = self._make(start_time), None
        self._plant.u[:] = u

    def do_step(self, current_time: float, step_size: float) -> bool:
        self._plant.t = current_time
        self._plant.advance(step_size)
        self._known = None
        return True
