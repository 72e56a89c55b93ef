"""How a section `[NAME]` of a model file of a simulation becomes its block.

The table `spacar_formats.sim_blocks.BLOCKS` names the maker of every block, with the keys that its section may have. A
maker raises UsageError, with file and line, for a value that its key cannot have.
"""

from codecs import BOM_UTF8
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from spacar.errors import UsageError
from spacar.mechanism.user_files import import_file
from spacar.simulation import blocks, control_blocks, sampled_blocks, signal_sources, switching_blocks
from spacar.simulation.blocks import Block
from spacar.simulation.plant import Spasim
from spacar_formats.ltvfile import read_ltv
from spacar_formats.sim_sections import Section


def built(kind: Callable[..., Block], *keys: str, each: Sequence[str] = ()) -> Callable[[Section], Block]:
    """A block of the values of these keys in this order; those of `each` are one number, or one for each signal."""
    return lambda s: kind(s.name, *(spread(s, key) if key in each else s.value(key) for key in keys))


def spasim(s: Section) -> Block:
    model = s.path("model")
    return Spasim(model if model.is_file() else model.with_name(f"{model.name}.dat"), s.name)


def stored(kind: Callable[..., Block], *counts: str) -> Callable[[Section], Block]:
    """A block of a stored result, with whole numbers that may be left out."""

    def make(s: Section) -> Block:
        data, notes = read_ltv(s.path("file"))
        s.warnings += notes
        options: dict[str, Any] = {"interpolation": s.text("interpolation"), "hold": s.flag("hold")}
        return kind(data, s.name, **options, **{key: s.integer(key) for key in counts if s.has(key)})

    return make


def gain(s: Section) -> Block:
    K = s.matrix("gain")
    return blocks.Gain(s.name, K, s.integer("size") if not K.ndim else None)


def spread(s: Section, key: str) -> Any:
    """One number for all signals, or a list with one for each."""
    found = s.numbers(key)
    return found[0] if len(found) == 1 else found


def optional(s: Section, key: str) -> Any:
    return s.value(key) if s.has(key) else None


def sampling_of(s: Section) -> tuple[float, float] | None:
    """Period and offset, or None for a continuous block. Raises UsageError for what only a sampled block has."""
    if not s.has("period"):
        for key in ("offset", "delay"):
            if s.given(key):
                raise s.wrong(key, "needs 'period': only a sampled block has it")
        return None
    period = s.number("period")
    if not 0.0 < period < np.inf:
        raise s.wrong("period", "must be positive")
    return period, s.number("offset")


def lookup(s: Section) -> Block:
    kind, beyond = switching_blocks.LookupTable.KINDS, switching_blocks.LookupTable.ENDS
    return switching_blocks.LookupTable(
        s.name, s.numbers("x"), s.numbers("y"), s.choice("interpolation", kind), s.choice("beyond", beyond),
        s.integer("size"),
    )  # fmt: skip


def transfer_function(s: Section) -> Block:
    sampling, b, a = sampling_of(s), s.numbers("numerator"), s.numbers("denominator")
    if sampling is None:
        return control_blocks.transfer_function(s.name, b, a)
    return sampled_blocks.sampled_transfer_function(s.name, sampling[0], b, a, sampling[1])


def state_space(s: Section) -> Block:
    A, B, C = (np.atleast_2d(s.matrix(key)) for key in "ABC")
    D = np.atleast_2d(s.matrix("D")) if s.has("D") else None
    x0, sampling = optional(s, "initial"), sampling_of(s)
    if sampling is None:
        return blocks.Linear(s.name, A, B, C, D, x0)
    return sampled_blocks.sampled_linear(s.name, sampling[0], A, B, C, D, x0, sampling[1])


def rate_limiter(s: Section) -> Block:
    up, down = s.numbers("rising"), optional(s, "falling")
    sampling, size, initial = sampling_of(s), s.integer("size"), s.numbers("initial")
    if sampling is not None:
        return sampled_blocks.sampled_rate_limiter(s.name, sampling[0], up, down, initial, size, sampling[1])
    if not s.has("bandwidth"):
        raise s.error("a continuous rate limiter needs 'bandwidth' [rad/s], a sampled one 'period' [s]")
    return control_blocks.RateLimiter(s.name, up, down, s.number("bandwidth"), initial, size)


def pid(s: Section) -> Block:
    gains = [s.numbers(key) for key in ("kp", "ki", "kd")]
    options: dict[str, Any] = {
        "filter": optional(s, "filter"), "tracking_time": optional(s, "tracking_time"),
        "lower": s.numbers("lower"), "upper": s.numbers("upper"), "size": s.integer("size"),
        "anti_windup": s.choice("anti_windup", control_blocks.ANTI_WINDUP),
    }  # fmt: skip
    sampling = sampling_of(s)
    if sampling is None:
        return control_blocks.PID(s.name, *gains, **options)
    return sampled_blocks.sampled_pid(s.name, sampling[0], *gains, **options, offset=sampling[1])


def hold(s: Section) -> Block:
    period, offset = sampling_of(s) or (0.0, 0.0)
    return sampled_blocks.zero_order_hold(s.name, period, s.integer("size"), offset)


def delay(s: Section) -> Block:
    period, offset = sampling_of(s) or (0.0, 0.0)
    return sampled_blocks.unit_delay(s.name, period, s.integer("size"), s.numbers("initial"), offset)


def table(s: Section) -> Block:
    """Times and values from a csv file: the first column is the time. A first line with a time is no heading."""
    path = s.path("file")
    try:
        lines = path.read_bytes().removeprefix(BOM_UTF8).decode("latin-1").split("\n")  # a heading has any bytes
        heading = np.isnan(np.genfromtxt(lines[:1], delimiter=",", usecols=(0,))).all()
        rows = np.genfromtxt(lines, delimiter=",", skip_header=int(heading), ndmin=2)
    except (OSError, ValueError) as cause:
        raise s.error(f"file = {s.text('file')} cannot be read: {str(cause).splitlines()[0]}", "file") from None
    if rows.shape[1] < 2 or not np.isfinite(rows).all():
        raise s.wrong("file", "is no table: expected lines of a time and numbers, with commas, below a heading or none")
    return signal_sources.TimeSeries(s.name, rows[:, 0], rows[:, 1:], s.text("interpolation"), s.flag("hold"))


def python(s: Section) -> Block:
    function = load_function(s.path("function"), s.error)
    inputs, outputs = s.integer("inputs", 0), s.integer("outputs")
    sampling = sampling_of(s)
    if sampling is None:
        return blocks.Function(s.name, function, inputs, outputs)
    return blocks.Sampled(
        s.name, function, sampling[0], inputs, outputs, offset=sampling[1], delay=s.flag("delay")
    )  # fmt: skip


def scope(s: Section) -> Block:
    labels = [word.strip() for word in s.text("labels").split(",")] if s.has("labels") else []
    return blocks.Scope(s.name, s.integer("size"), s.text("title"), labels, s.text("unit"))


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
