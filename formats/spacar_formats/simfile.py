"""The model file of a controlled simulation: sections with keys, and wires (docs/simulation.md).

    [simulation]             time, step, method, atol, rtol, max_step
    [NAME]                   block = one of sim_blocks.BLOCKS, and the keys of that block
    [wires]                  lines such as  robot:1-6 -> pd * -1

Blocks and their keys are a table (sim_blocks), from which follow the checks, `spacar keywords` and
docs/reference/blocks.md.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from spacar.arrays import EPS
from spacar.errors import SpacarError, UsageError
from spacar.simulation.blocks import Block
from spacar.simulation.diagram import Diagram
from spacar_formats.sim_blocks import BLOCKS, BY_NAME
from spacar_formats.sim_sections import Section, SimKey, read_sections

MOST_TIMES = 100_000_000
SETTINGS = (
    SimKey("time", "number", "length of the simulation, which starts at 0", None, "s"),
    SimKey("step", "number", "between two times of the results; the last one may be shorter", None, "s"),
    SimKey("method", "text", "code with variable steps: 135, 155, 853, 553, 595; -1: 155 or 595, as steps ask", "-1"),
    SimKey("rtol", "number", "relative tolerance of a step", "1e-6"),
    SimKey("atol", "number", "absolute tolerance of a step", "1e-8"),
    SimKey("max_step", "number", "largest step", "", "s"),
)


@dataclass(frozen=True)
class SimulationModel:
    """A diagram with the times and options of its simulation; warnings about the results it reads."""

    diagram: Diagram
    times: np.ndarray
    options: dict[str, Any]
    warnings: tuple[str, ...]


def read_model(path: Path) -> SimulationModel:
    """Read, check and connect. Raises UsageError (file, keys, signals), InputError (the mechanism)."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as cause:
        raise UsageError(f"{path}: {cause.strerror}", "files.not-readable") from None
    except UnicodeDecodeError as cause:
        raise UsageError(f"{path.name} is no model of a simulation: {cause}", "simulation.model-file") from None
    sections = read_sections(path, text)
    for needed in ("simulation", "wires"):
        if needed not in sections:
            raise UsageError(f"{path.name}: the section [{needed}] is missing", "simulation.model-file")
    diagram, warnings = Diagram(), []
    for name, section in sections.items():
        if name not in ("simulation", "wires"):
            block = _block(section)
            try:
                diagram.add(block)
            except UsageError as cause:
                raise section.error(str(cause)) from None
            warnings += section.warnings
    for line, wire in sections["wires"].wires:
        _wire(path, diagram, line, wire)
    times, options = _settings(sections["simulation"])
    return SimulationModel(diagram, times, options, tuple(dict.fromkeys(warnings)))


def _settings(s: Section) -> tuple[np.ndarray, dict[str, Any]]:
    s.expect(SETTINGS)
    duration, step = s.number("time"), s.number("step")
    if not (duration > 0.0 and 0.0 < step <= duration):
        text = f"time = {duration:g} and step = {step:g} must be positive, the step not larger than the time"
        raise s.error(text, "step")
    if duration / step > MOST_TIMES:
        text = f"at most {MOST_TIMES:.0e} times, as they stay in memory"
        raise s.error(f"time = {duration:g} with step = {step:g}: {text}", "step")
    whole = np.ceil(duration / step * (1.0 - 4.0 * EPS))  # the quotient of two decimal numbers is rounded
    times = np.append(np.arange(whole) * step, duration)
    options: dict[str, Any] = {key: s.number(key) for key in ("rtol", "atol", "max_step") if s.given(key)}
    if s.given("method"):
        options["method"] = s.text("method")
    return times, options


def _block(s: Section) -> Block:
    kind = s.values.get("block")
    if kind not in BY_NAME:
        known = ", ".join(b.name for b in BLOCKS)
        raise s.error(f"block = {kind}; the blocks are {known}", "block")
    s.expect(BY_NAME[kind].keys)
    try:
        return BY_NAME[kind].make(s)
    except UsageError as cause:
        if str(cause).startswith(f"{s.file.name}:"):
            raise
        raise s.error(str(cause).removeprefix(f"{s.name}: ")) from cause


def _wire(path: Path, diagram: Diagram, line: int, text: str) -> None:
    """`source -> target` or `source -> target * gain`."""
    source, arrow, rest = text.partition("->")
    target, star, gain = rest.partition("*")
    try:
        factor = float(gain) if star else 1.0
        if not arrow:
            raise ValueError
    except ValueError:
        why = f"'{text}' is no wire; write SOURCE -> TARGET, or SOURCE -> TARGET * NUMBER"
        raise UsageError(f"{path.name}:{line}: [wires]: {why}", "simulation.model-file") from None
    try:
        diagram.connect(source.strip(), target.strip(), factor)
    except SpacarError as cause:
        raise UsageError(f"{path.name}:{line}: [wires]: {cause}", cause.code) from None
