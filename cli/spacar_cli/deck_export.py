"""`spacar symbolic export NAME.dat`: the model of a deck, as it is or as a program, and its motion beside mode 1."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from spacar_formats.safety import replacing, write_text

import spacar
from spacar.deck import read_deck
from spacar.errors import AnalysisError, SpacarError, UsageError
from spacar.mechanism import build
from spacar.result import Result
from spacar_cli.deck_as_model import DeckModel
from spacar_cli.deck_as_text import MARK
from spacar_cli.deck_by_dimension import PlanarModel, SpatialModel

if TYPE_CHECKING:
    from spacar.symbolic.simulated_motion import SimulatedMotion

TIME = 1.0  # of a deck without TIMESTEP [s]
STEPS = 100
RTOL = 1e-9
RIGID_LIMIT = 1e-4  # of the size of the mechanism: far above both integrations, far below a wrong model


@dataclass(frozen=True)
class Compared:
    """Largest differences of positions [m] and angles [rad], with node and time; size of the mechanism [m]."""

    position: tuple[float, int, float]
    angle: tuple[float, int, float]
    deflection: float
    size: float
    times: np.ndarray

    def lines(self, flexible: bool, shapes: int) -> list[str]:
        d, node, t = self.position
        rows = [
            f"comparison   with mode 1 at {len(self.times)} times from 0 to {self.times[-1]:g} s, rtol {RTOL:g}",
            f"positions    differ by at most {d:.3g} m (node {node}, t = {t:.4g} s), {d / self.size:.2g} of the size",
        ]
        d, node, t = self.angle
        if node:
            rows.append(f"angles       differ by at most {d:.3g} rad (node {node}, t = {t:.4g} s)")
        if not flexible:
            return [*rows, "error        that of both integrations: the parts are rigid"]
        part = f", {100 * self.position[0] / self.deflection:.2g} %" if self.deflection > 0 else ""
        text = f"error        of {shapes} assumed shapes a beam against its element, besides that of both integrations;"
        return [*rows, f"{text} largest deflection {self.deflection:.3g} m{part}"]


def export_deck(
    path: Path, language: str | None, strategy: str, jacobian: bool, output: Path | None, shapes: int,
    time: float | None,
) -> list[str]:  # fmt: skip
    """Write NAME.toml, or a program in `language`; the lines that say what was written and how the motions compare.

    Raises UsageError for what cannot be exported, AnalysisError when rigid parts move otherwise than in mode 1.
    """
    from spacar.symbolic.compiled_program import compiler
    from spacar.symbolic.emit import LANGUAGES
    from spacar.symbolic.model_reader import read_model_text

    target = output or path.with_suffix(LANGUAGES[language] if language else ".toml")
    if target == path:
        raise UsageError(f"{target} is the deck itself: choose another file with --output")
    if language is None and target.is_file() and not target.read_text("utf-8", "replace").startswith(MARK):
        raise UsageError(f"{target} is a model of yours: choose another file with --output")
    deck = read_deck(path, 1)
    duration = time or build(deck, 1).settings.duration
    options: dict[str, Any] = {"duration": duration or TIME, "n_steps": STEPS, "rtol": RTOL, "atol": RTOL}
    try:
        first = next(iter(spacar.frames(1, deck, **options)))
        mechanism = build(deck, 1)
        kind = PlanarModel if mechanism.numbering.planar else SpatialModel
        made: DeckModel = kind(mechanism, first.x, first.xd, shapes)
        text = made.text()
        result = spacar.run(1, deck, **options)
    except AnalysisError as error:
        advice = "" if duration else f" (the deck has no TIMESTEP, so that {TIME:g} s were tried: give another --time)"
        raise AnalysisError(f"{path.name}, mode 1: {error}{advice}", error.code) from None
    model = read_model_text(text, path.with_suffix(".toml"))
    try:
        eq = model.system.derive(strategy)
        checked = eq.check()
        checked.demand()
        program = eq.program(model.outputs)
        times = np.ravel(result["t"])
        function = program.compile(model.values) if compiler() else None
        run = program.simulate(
            model.values, model.start, t_end=float(times[-1]), at=times, rtol=RTOL, function=function
        )
    except SpacarError as error:
        failure = AnalysisError if isinstance(error, AnalysisError) else UsageError
        raise failure(f"{path.name}: {error}", error.code) from None
    flexible = bool(model.system.beams)
    compared = compare(made, result, run)
    if not flexible and compared.position[0] > RIGID_LIMIT * compared.size:
        found = compared.lines(False, shapes)[1]
        raise AnalysisError(f"{path.name}: the model moves otherwise than mode 1: {found}", "export")
    counts = program.counts()
    if language is None:
        write_text(target, text)
        said = f"{target}: {len(eq.coordinates)} coordinates, {len(model.system.constraints)} constraints"
    else:
        with replacing(target) as side:
            program.write(side, language, jacobian)
        said = f"{target}: {counts['step']} operations per step, {counts['once']} once"
    return [said, f"check        {checked}", *run.notes, *compared.lines(flexible, shapes)]


def compare(made: DeckModel, result: Result, run: SimulatedMotion) -> Compared:
    """Positions of all position nodes and angles of all orientation nodes at the times of both."""
    x, times, lnp = result["x"], np.ravel(result["t"]), made.numbering.lnp
    position, angle, deflection = (0.0, 0, 0.0), (0.0, 0, 0.0), 0.0
    for node, point in made.points.items():
        ours = np.column_stack([run[f"{point}.{a}"] for a in made.axes])
        gap = np.linalg.norm(ours - x[:, lnp[node - 1, : made.dimension] - 1], axis=1)
        k = int(np.argmax(gap))
        position = max(position, (float(gap[k]), node, float(times[k])))
    for node in made.turned_about_z():
        turn = np.abs(run[f"angle{node}"] - x[:, lnp[node - 1, 0] - 1])
        k = int(np.argmax(turn))
        angle = max(angle, (float(turn[k]), node, float(times[k])))
    for part in made.parts:
        if made.kind(part) == "beam":  # the largest distance of the end at q from the tangent at p
            p, turned, q, _ = part.nodes
            now = x[:, lnp[q - 1, : made.dimension] - 1] - x[:, lnp[p - 1, : made.dimension] - 1]
            tangent = made.turned(made.span(part), x[:, lnp[turned - 1] - 1])
            along = np.sum(now * tangent, axis=1)
            deflection = max(deflection, float(np.linalg.norm(now - along[:, None] * tangent, axis=1).max()))
    return Compared(position, angle, deflection, max(result.mechanism.length, 1e-300), times)
