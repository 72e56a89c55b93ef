"""The model file of a controlled simulation: an INI file with a section per block (docs/simulation.md).

    [simulation]             time, step, method, atol, rtol, max_step
    [NAME]                   block = one of BLOCKS, and the keys of that block
    [wires]                  lines such as  robot:1-6 -> pd * -1

Every key is checked against the table; an unknown one is an error that names the known ones.
"""

from __future__ import annotations

import configparser
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from spacar.errors import SpacarError, UsageError
from spacar.mechanism.user_functions import import_file
from spacar.simulation.blocks import Block, Function, Gain, Sampled, proportional_derivative
from spacar.simulation.diagram import Diagram
from spacar.simulation.switching_blocks import Saturation
from spacar_formats.ltvfile import read_ltv

MOST_TIMES = 100_000_000
SETTINGS = ("time", "step", "method", "atol", "rtol", "max_step")
STORED = {"file": "", "interpolation": "linear", "hold": "no"}
REQUIRED = object()


@dataclass(frozen=True)
class SimulationModel:
    """A diagram with the times and options of its simulation; warnings about the results it reads."""

    diagram: Diagram
    times: np.ndarray
    options: dict[str, Any]
    warnings: tuple[str, ...]


class _Section:
    """One section with typed access; complains with the names of file, section and key."""

    def __init__(self, file: Path, name: str, values: Mapping[str, str | None], known: Mapping[str, Any]) -> None:
        self.file, self.name, self.warnings = file, name, []  # type: ignore[var-annotated]
        self.values = {key: value for key, value in values.items() if key != "block"}
        unknown = [key for key in self.values if key not in known]
        if unknown:
            raise self.error(f"unknown key '{unknown[0]}'; the keys are {', '.join(known)}")
        for key, default in known.items():
            if self.values.get(key) is None:
                if default is REQUIRED:
                    raise self.error(f"'{key}' is missing")
                self.values[key] = default

    def error(self, text: str) -> UsageError:
        return UsageError(f"{self.file.name}: [{self.name}]: {text}", "simulation.model-file")

    def text(self, key: str) -> str:
        return str(self.values[key])

    def number(self, key: str) -> float:
        try:
            return float(self.text(key))
        except ValueError:
            raise self.error(f"{key} = {self.text(key)} is no number") from None

    def integer(self, key: str) -> int:
        value = self.number(key)
        if value != int(value) or value < 1:
            raise self.error(f"{key} = {self.text(key)} must be a positive whole number")
        return int(value)

    def flag(self, key: str) -> bool:
        word = self.text(key).lower()
        if word not in ("yes", "no", "true", "false", "1", "0"):
            raise self.error(f"{key} = {word} must be yes or no")
        return word in ("yes", "true", "1")

    def matrix(self, key: str) -> np.ndarray:
        """Rows separated by ';', numbers by blanks or commas; one number gives a number."""
        try:
            rows = [[float(v) for v in row.replace(",", " ").split()] for row in self.text(key).split(";")]
            found = np.array(rows)
        except ValueError:
            raise self.error(f"{key} = {self.text(key)} is no number and no matrix") from None
        return found.reshape(()) if found.size == 1 else found

    def path(self, key: str) -> Path:
        return self.file.parent / self.text(key)

    def stored(self) -> tuple[Any, str, bool]:
        """The result file of a set-point block, the interpolation and whether the ends are held."""
        data, notes = read_ltv(self.path("file"))
        self.warnings += notes
        return data, self.text("interpolation"), self.flag("hold")


def _spasim(s: _Section) -> Block:
    from spacar.simulation.plant import Spasim

    model = s.path("model")
    return Spasim(model if model.is_file() else model.with_name(f"{model.name}.dat"), s.name)


def _stored_vector(kind: str) -> Callable[[_Section], Block]:
    def make(s: _Section) -> Block:
        from spacar.simulation import setpoint_blocks

        data, interpolation, hold = s.stored()
        block: Block = getattr(setpoint_blocks, kind)(data, s.name, interpolation, hold)
        return block

    return make


def _times_m0(s: _Section) -> Block:
    from spacar.simulation.setpoint_blocks import TimesM0

    data, interpolation, hold = s.stored()
    return TimesM0(data, s.name, s.integer("size") if s.values["size"] else None, interpolation, hold)


def _ltv(s: _Section) -> Block:
    from spacar.simulation.setpoint_blocks import Ltv

    data, interpolation, hold = s.stored()
    return Ltv(data, s.name, interpolation, hold, s.integer("modes") if s.values["modes"] else None)


def _gain(s: _Section) -> Block:
    K = s.matrix("gain")
    return Gain(s.name, K, s.integer("size") if not K.ndim else None)


def _pd(s: _Section) -> Block:
    return proportional_derivative(s.name, s.integer("size"), s.number("omega"), s.number("damping"))


def _saturation(s: _Section) -> Block:
    return Saturation(s.name, s.matrix("lower").ravel().tolist(), s.matrix("upper").ravel().tolist(), s.integer("size"))


def _python(s: _Section) -> Block:
    function = load_function(s.path("function"), s.error)
    inputs, outputs = int(s.number("inputs")), s.integer("outputs")
    if not s.values["period"]:
        return Function(s.name, function, inputs, outputs)
    return Sampled(
        s.name, function, s.number("period"), inputs, outputs, offset=s.number("offset"), delay=s.flag("delay")
    )


BLOCKS: dict[str, tuple[Callable[[_Section], Block], dict[str, Any]]] = {
    "spasim": (_spasim, {"model": REQUIRED}),
    "setpoint-u0": (_stored_vector("SetpointU0"), STORED | {"file": REQUIRED}),
    "setpoint-sigma0": (_stored_vector("SetpointSigma0"), STORED | {"file": REQUIRED}),
    "reference-y0": (_stored_vector("ReferenceY0"), STORED | {"file": REQUIRED}),
    "times-m0": (_times_m0, STORED | {"file": REQUIRED, "size": ""}),
    "ltv": (_ltv, STORED | {"file": REQUIRED, "modes": ""}),
    "gain": (_gain, {"gain": REQUIRED, "size": "1"}),
    "pd": (_pd, {"size": REQUIRED, "omega": REQUIRED, "damping": REQUIRED}),
    "saturation": (_saturation, {"lower": REQUIRED, "upper": REQUIRED, "size": "1"}),
    "python": (
        _python,
        {"function": REQUIRED, "inputs": REQUIRED, "outputs": REQUIRED, "period": "", "offset": "0", "delay": "no"},
    ),
}


def load_function(path: Path, error: Callable[[str], UsageError]) -> Callable[..., Any]:
    """The function of `file.py:name`. Raises the given kind of error when file or function cannot be had."""
    name, colon, function_name = path.name.partition(":")
    file = path.with_name(name)
    if not colon or not file.is_file():
        raise error(f"a function is given as FILE.py:NAME; {file} " + ("does not exist" if colon else "has no name"))
    function = getattr(import_file(file, error), function_name, None)
    if not callable(function):
        raise error(f"{file} does not define a function {function_name}")
    return function


def read_model(path: Path) -> SimulationModel:
    """Read, check and connect. Raises UsageError (file, keys, signals), InputError (the mechanism)."""
    parser = configparser.ConfigParser(allow_no_value=True, delimiters=("=",), inline_comment_prefixes=("#", "%"))
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    try:
        parser.read_string(path.read_text(encoding="utf-8"), path.name)
    except OSError as cause:
        raise UsageError(f"{path}: {cause.strerror}", "files.not-readable") from None
    except AttributeError:  # of configparser: an indented line continues the value of a name that has none
        text = f"{path.name} is no model of a simulation: an indented line follows a name without a value"
        raise UsageError(text, "simulation.model-file") from None
    except (configparser.Error, UnicodeDecodeError) as cause:
        reason = str(cause).replace("\n", " ")
        raise UsageError(f"{path.name} is no model of a simulation: {reason}", "simulation.model-file") from None
    for needed in ("simulation", "wires"):
        if needed not in parser:
            raise UsageError(f"{path.name}: the section [{needed}] is missing", "simulation.model-file")
    diagram, warnings = Diagram(), []
    for name in parser.sections():
        if name not in ("simulation", "wires"):
            block, notes = _block(path, name, parser[name])
            diagram.add(block)
            warnings += notes
    for line, value in parser["wires"].items():
        _wire(path, diagram, line if value is None else f"{line}={value}")
    known: dict[str, Any] = {"time": REQUIRED, "step": REQUIRED} | dict.fromkeys(SETTINGS[2:])
    s = _Section(path, "simulation", parser["simulation"], known)
    duration, step = s.number("time"), s.number("step")
    if not (duration > 0.0 and 0.0 < step <= duration):
        raise s.error(f"time = {duration:g} and step = {step:g} must be positive, the step not larger than the time")
    if duration / step > MOST_TIMES:
        text = f"at most {MOST_TIMES:.0e} times, as they stay in memory"
        raise s.error(f"time = {duration:g} with step = {step:g}: {text}")
    times = np.append(np.arange(round(duration / step)) * step, duration)
    options: dict[str, Any] = {key: s.number(key) for key in SETTINGS[3:] if s.values[key] is not None}
    if s.values["method"] is not None:
        options["method"] = s.text("method")
    return SimulationModel(diagram, times, options, tuple(dict.fromkeys(warnings)))


def _block(path: Path, name: str, values: Mapping[str, str | None]) -> tuple[Block, list[str]]:
    kind = values.get("block")
    if kind not in BLOCKS:
        raise UsageError(
            f"{path.name}: [{name}]: block = {kind}; the blocks are {', '.join(BLOCKS)}", "simulation.model-file"
        )
    make, known = BLOCKS[kind]
    section = _Section(path, name, values, known)
    try:
        return make(section), section.warnings
    except UsageError as cause:
        if str(cause).startswith(path.name):
            raise
        raise section.error(str(cause)) from cause


def _wire(path: Path, diagram: Diagram, line: str) -> None:
    """`source -> target` or `source -> target * gain`."""
    source, arrow, rest = line.partition("->")
    target, star, gain = rest.partition("*")
    try:
        factor = float(gain) if star else 1.0
        if not arrow:
            raise ValueError
    except ValueError:
        text = f"'{line}' is no wire; write SOURCE -> TARGET, or SOURCE -> TARGET * NUMBER"
        raise UsageError(f"{path.name}: [wires]: {text}", "simulation.model-file") from None
    try:
        diagram.connect(source.strip(), target.strip(), factor)
    except SpacarError as cause:
        raise UsageError(f"{path.name}: [wires]: {cause}", cause.code) from None
