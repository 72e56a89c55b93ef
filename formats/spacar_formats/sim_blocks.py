"""The blocks that a model file of a simulation knows: names, keys, what they mean, and how they are made.

`python -m spacar_formats.sim_blocks` prints docs/reference/blocks.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from spacar.errors import UsageError
from spacar.mechanism.user_functions import import_file
from spacar.simulation import blocks, control_blocks, sampled_blocks, sources, switching_blocks, transport_delay
from spacar.simulation.blocks import Block
from spacar_formats.sim_sections import Section, SimKey


@dataclass(frozen=True)
class BlockType:
    """A row of the table: `block = name`."""

    name: str
    text: str
    formula: str
    keys: tuple[SimKey, ...]
    make: Callable[[Section], Block]


SIZE = SimKey("size", "integer", "number of signals", "1")
PERIOD = SimKey("period", "number", "sampling period; without it the block is continuous", "", "s")
SAMPLED = (
    SimKey("period", "number", "sampling period", None, "s"),
    SimKey("offset", "number", "time of the first sample", "0", "s"),
)
OFFSET = SimKey("offset", "number", "time of the first sample, with period", "0", "s")
FILE = SimKey("file", "file", "result (.ltv)", None)
STORED = (
    SimKey("interpolation", "text", "between stored times: step, linear, spline (vectors only)", "linear"),
    SimKey("hold", "flag", "keep the first and the last value outside the stored times", "no"),
)
LIMITS = (
    SimKey("lower", "numbers", "lower limit, one or one for each signal", None),
    SimKey("upper", "numbers", "upper limit", None),
)
OPEN_LIMITS = (SimKey("lower", "numbers", "lower limit", "-inf"), SimKey("upper", "numbers", "upper limit", "inf"))


def _spasim(s: Section) -> Block:
    from spacar.simulation.plant import Spasim

    model = s.path("model")
    return Spasim(model if model.is_file() else model.with_name(f"{model.name}.dat"), s.name)


def _stored_vector(kind: str) -> Callable[[Section], Block]:
    def make(s: Section) -> Block:
        from spacar.simulation import setpoint_blocks

        data, interpolation, hold = s.stored()
        block: Block = getattr(setpoint_blocks, kind)(data, s.name, interpolation, hold)
        return block

    return make


def _times_m0(s: Section) -> Block:
    from spacar.simulation.setpoint_blocks import TimesM0

    data, interpolation, hold = s.stored()
    return TimesM0(data, s.name, s.integer("size") if s.has("size") else None, interpolation, hold)


def _ltv(s: Section) -> Block:
    from spacar.simulation.setpoint_blocks import Ltv

    data, interpolation, hold = s.stored()
    return Ltv(data, s.name, interpolation, hold, s.integer("modes") if s.has("modes") else None)


def _gain(s: Section) -> Block:
    K = s.matrix("gain")
    return blocks.Gain(s.name, K, s.integer("size") if not K.ndim else None)


def _pd(s: Section) -> Block:
    return blocks.proportional_derivative(s.name, s.integer("size"), s.number("omega"), s.number("damping"))


def _spread(s: Section, key: str) -> Any:
    """One number, or a list."""
    found = s.numbers(key)
    return found[0] if len(found) == 1 else found


def _period(s: Section) -> tuple[float, float] | None:
    """Period and offset, or None for a continuous block."""
    if not s.has("period"):
        return None
    period = s.number("period")
    if not 0.0 < period < np.inf:
        raise s.wrong("period", "must be positive")
    return period, s.number("offset")


def _limited(kind: Callable[..., Block]) -> Callable[[Section], Block]:
    return lambda s: kind(s.name, s.numbers("lower"), s.numbers("upper"), s.integer("size"))


def _relay(s: Section) -> Block:
    return switching_blocks.Relay(
        s.name, s.numbers("lower"), s.numbers("upper"), s.number("off"), s.number("on"), s.integer("size"),
        s.flag("initially_on"),
    )  # fmt: skip


def _lookup(s: Section) -> Block:
    kind, beyond = switching_blocks.LookupTable.KINDS, switching_blocks.LookupTable.ENDS
    return switching_blocks.LookupTable(
        s.name, s.numbers("x"), s.numbers("y"), s.choice("interpolation", kind), s.choice("beyond", beyond),
        s.integer("size"),
    )  # fmt: skip


def _integrator(s: Section) -> Block:
    return control_blocks.Integrator(
        s.name, s.numbers("initial"), s.numbers("gain"), s.numbers("lower"), s.numbers("upper"), s.integer("size")
    )


def _transfer_function(s: Section) -> Block:
    sampling, b, a = _period(s), s.numbers("numerator"), s.numbers("denominator")
    if sampling is None:
        return control_blocks.transfer_function(s.name, b, a)
    return sampled_blocks.sampled_transfer_function(s.name, sampling[0], b, a, sampling[1])


def _state_space(s: Section) -> Block:
    A, B, C = (np.atleast_2d(s.matrix(key)) for key in "ABC")
    D = np.atleast_2d(s.matrix("D")) if s.has("D") else None
    x0 = s.numbers("initial") if s.has("initial") else None
    sampling = _period(s)
    if sampling is None:
        return blocks.Linear(s.name, A, B, C, D, x0)
    return sampled_blocks.sampled_linear(s.name, sampling[0], A, B, C, D, x0, sampling[1])


def _rate_limiter(s: Section) -> Block:
    up, down = s.numbers("rising"), s.numbers("falling") if s.has("falling") else None
    sampling, size, initial = _period(s), s.integer("size"), s.numbers("initial")
    if sampling is not None:
        return sampled_blocks.sampled_rate_limiter(s.name, sampling[0], up, down, initial, size, sampling[1])
    if not s.has("bandwidth"):
        raise s.error("a continuous rate limiter needs 'bandwidth' [rad/s], a sampled one 'period' [s]")
    return control_blocks.RateLimiter(s.name, up, down, s.number("bandwidth"), initial, size)


def _pid(s: Section) -> Block:
    gains = [s.numbers(key) for key in ("kp", "ki", "kd")]
    options: dict[str, Any] = {
        "filter": s.number("filter") if s.has("filter") else None,
        "lower": s.numbers("lower"), "upper": s.numbers("upper"), "size": s.integer("size"),
        "anti_windup": s.choice("anti_windup", control_blocks.ANTI_WINDUP),
        "tracking_time": s.number("tracking_time") if s.has("tracking_time") else None,
    }  # fmt: skip
    sampling = _period(s)
    if sampling is None:
        return control_blocks.PID(s.name, *gains, **options)
    return sampled_blocks.sampled_pid(s.name, sampling[0], *gains, **options, offset=sampling[1])


def _hold(s: Section) -> Block:
    period, offset = _period(s) or (0.0, 0.0)
    return sampled_blocks.zero_order_hold(s.name, period, s.integer("size"), offset)


def _delay(s: Section) -> Block:
    period, offset = _period(s) or (0.0, 0.0)
    return sampled_blocks.unit_delay(s.name, period, s.integer("size"), s.numbers("initial"), offset)


def _transport_delay(s: Section) -> Block:
    return transport_delay.TransportDelay(s.name, s.number("delay"), s.numbers("initial"), s.integer("size"))


def _pulses(s: Section) -> Block:
    return sources.Pulses(
        s.name, s.number("every"), s.number("duty"), _spread(s, "high"), _spread(s, "low"), s.number("time")
    )


def _table(s: Section) -> Block:
    """Times and values from a csv file with a heading line: the first column is the time."""
    path = s.path("file")
    try:
        rows = np.genfromtxt(path, delimiter=",", skip_header=1, ndmin=2)
    except (OSError, ValueError) as cause:
        raise s.error(f"file = {s.text('file')} cannot be read: {str(cause).splitlines()[0]}", "file") from None
    if rows.shape[1] < 2 or not np.isfinite(rows).all():
        raise s.wrong("file", "is no table: expected a heading line, then lines of a time and numbers, with commas")
    return sources.TimeSeries(s.name, rows[:, 0], rows[:, 1:], s.text("interpolation"), s.flag("hold"))


def _python(s: Section) -> Block:
    function = load_function(s.path("function"), s.error)
    inputs, outputs = s.integer("inputs", 0), s.integer("outputs")
    sampling = _period(s)
    if sampling is None:
        return blocks.Function(s.name, function, inputs, outputs)
    return blocks.Sampled(
        s.name, function, sampling[0], inputs, outputs, offset=sampling[1], delay=s.flag("delay")
    )  # fmt: skip


def _scope(s: Section) -> Block:
    labels = [word.strip() for word in s.text("labels").split(",")] if s.has("labels") else []
    return blocks.Scope(s.name, s.integer("size"), s.text("title"), labels, s.text("unit"))


def _values(key: str, text: str, default: str | None = None, unit: str = "") -> SimKey:
    return SimKey(key, "numbers", f"{text}, one number for each signal", default, unit)


BLOCKS: tuple[BlockType, ...] = (
    BlockType(
        "spasim", "the non-linear mechanism", "inputs INPUTS, INPUTF; outputs OUT... of its file",
        (SimKey("model", "file", "input file (.dat)", None),), _spasim,
    ),
    BlockType(
        "ltv", "time-varying linear system of mode 3, 4 or 9", "z' = A(t) z + B(t) u, y = C(t) z + D(t) u",
        (FILE, *STORED, SimKey("modes", "integer", "reduce to that many modes", "")), _ltv,
    ),
    BlockType("setpoint-u0", "nominal inputs", "y = u0(t)", (FILE, *STORED), _stored_vector("SetpointU0")),
    BlockType(
        "setpoint-sigma0", "stresses of the rigidified deformations", "y = sigma0(t)", (FILE, *STORED),
        _stored_vector("SetpointSigma0"),
    ),
    BlockType("reference-y0", "reference outputs", "y = y0(t)", (FILE, *STORED), _stored_vector("ReferenceY0")),
    BlockType(
        "times-m0", "the reduced mass matrix", "y = M0(t) u",
        (FILE, *STORED, SimKey("size", "integer", "its leading block only", "")), _times_m0,
    ),
    BlockType("constant", "a constant", "y = value", (_values("value", "value"),),
              lambda s: sources.Constant(s.name, s.numbers("value"))),
    BlockType(
        "step", "a step", "y = before for t < time, then after",
        (SimKey("time", "number", "of the step, met exactly", "0", "s"), _values("after", "value", "1"),
         _values("before", "value", "0")),
        lambda s: sources.StepSignal(s.name, s.number("time"), _spread(s, "after"), _spread(s, "before")),
    ),
    BlockType(
        "ramp", "a ramp", "y = start for t < time, then start + slope (t - time)",
        (_values("slope", "slope", None, "1/s"), SimKey("time", "number", "where it begins", "0", "s"),
         _values("start", "value", "0")),
        lambda s: sources.Ramp(s.name, _spread(s, "slope"), s.number("time"), _spread(s, "start")),
    ),
    BlockType(
        "sine", "a sine", "y = bias + amplitude sin(2 pi frequency t + phase)",
        (_values("amplitude", "amplitude"), _values("frequency", "frequency", None, "Hz"),
         _values("phase", "phase", "0", "rad"), _values("bias", "mean value", "0")),
        lambda s: sources.Sine(s.name, *(_spread(s, key) for key in ("amplitude", "frequency", "phase", "bias"))),
    ),
    BlockType(
        "pulses", "pulses", "y = high for a part duty of every period, else low; edges are met exactly",
        (SimKey("every", "number", "time from one to the next", None, "s"),
         SimKey("duty", "number", "part of it that is high, 0 to 1", "0.5"), _values("high", "value", "1"),
         _values("low", "value", "0"), SimKey("time", "number", "of the first pulse", "0", "s")),
        _pulses,
    ),
    BlockType(
        "table", "signals over time from a csv file", "first column time, the others signals; one heading line",
        (SimKey("file", "file", "csv file", None), *STORED), _table,
    ),
    BlockType(
        "gain", "a constant factor", "y = K u",
        (SimKey("gain", "matrix", "number, or rows separated by ';'", None), SIZE), _gain,
    ),
    BlockType("product", "a product", "y_i = u_i u_(size+i)", (SIZE,),
              lambda s: blocks.Product(s.name, s.integer("size"))),
    BlockType(
        "pd", "PD control of errors followed by their rates", "y = omega^2 e + 2 damping omega e'",
        (SimKey("size", "integer", "number of errors", None), SimKey("omega", "number", "bandwidth", None, "rad/s"),
         SimKey("damping", "number", "relative damping", None)), _pd,
    ),
    BlockType(
        "pid", "PID control with anti-windup, continuous or sampled",
        "v = kp e + I + D, I' = ki e, D = kd s/(1 + s/filter) e, y = v limited",
        (_values("kp", "gain"), _values("ki", "gain of the integral", "0", "1/s"),
         _values("kd", "gain of the derivative", "0", "s"),
         SimKey("filter", "number", "bandwidth of the derivative, needed with kd", "", "rad/s"), *OPEN_LIMITS,
         SimKey("anti_windup", "text", "back-calculation (I' = ki e + (y - v)/tracking_time), clamping, none",
             "back-calculation"),
         SimKey("tracking_time", "number", "of back-calculation; default sqrt(kd/ki), without kd kp/ki", "", "s"),
         PERIOD, OFFSET, SIZE),
        _pid,
    ),
    BlockType(
        "transfer-function", "transfer function in s, with period in z", "y = numerator/denominator u, from rest",
        (SimKey("numerator", "numbers", "coefficients by falling powers", None),
         SimKey("denominator", "numbers", "coefficients by falling powers", None), PERIOD, OFFSET),
        _transfer_function,
    ),
    BlockType(
        "state-space", "linear system, with period a difference equation", "x' = A x + B u, y = C x + D u",
        (*(SimKey(k, "matrix", "rows separated by ';'", None) for k in "ABC"),
         SimKey("D", "matrix", "rows separated by ';'", ""), SimKey("initial", "numbers", "state at the start", ""),
         PERIOD, OFFSET),
        _state_space,
    ),
    BlockType(
        "integrator", "integrator, perhaps with limits", "y' = gain u, y stays at a limit while u drives it beyond",
        (SimKey("initial", "numbers", "value at the start", "0"), SimKey("gain", "numbers", "factor", "1", "1/s"),
         *OPEN_LIMITS, SIZE), _integrator,
    ),
    BlockType("saturation", "limits of a signal", "y = u between lower and upper", (*LIMITS, SIZE),
              _limited(switching_blocks.Saturation)),
    BlockType("dead-zone", "dead zone", "y = 0 between lower and upper, beyond them the distance to the nearer one",
              (*LIMITS, SIZE), _limited(switching_blocks.DeadZone)),
    BlockType(
        "relay", "switch with hysteresis", "on above upper, off below lower, unchanged in between",
        (*LIMITS, SimKey("off", "number", "output when off", "0"), SimKey("on", "number", "output when on", "1"),
         SimKey("initially_on", "flag", "state at the start, between the limits", "no"), SIZE), _relay,
    ),
    BlockType(
        "quantizer", "quantizer", "y = interval floor(u/interval + 1/2)",
        (SimKey("interval", "numbers", "between two levels", None), SIZE),
        lambda s: switching_blocks.Quantizer(s.name, s.numbers("interval"), s.integer("size")),
    ),
    BlockType(
        "lookup", "look-up table", "y interpolated in the points (x, y)",
        (SimKey("x", "numbers", "increasing", None), SimKey("y", "numbers", "as many values", None),
         SimKey("interpolation", "text", "linear, cubic (monotone), step", "linear"),
         SimKey("beyond", "text", "outside the table: hold, extrapolate, error", "hold"), SIZE),
        _lookup,
    ),
    BlockType(
        "rate-limiter", "limits of the rate of a signal",
        "y' = bandwidth (u - y) within [-falling, rising]; sampled: y_k - y_(k-1) within the rates times period",
        (_values("rising", "largest rate upwards", None, "1/s"),
         _values("falling", "largest rate downwards; default as rising", "", "1/s"),
         SimKey("bandwidth", "number", "of a continuous limiter", "", "rad/s"),
         SimKey("initial", "numbers", "output at the start", "0"), PERIOD, OFFSET, SIZE),
        _rate_limiter,
    ),
    BlockType(
        "transport-delay", "delay of a continuous signal", "y(t) = u(t - delay), initial before",
        (SimKey("delay", "number", "by how much; steps are not longer", None, "s"),
         SimKey("initial", "numbers", "output until the first input comes out", "0"), SIZE), _transport_delay,
    ),
    BlockType("zero-order-hold", "sample and hold", "y_k = u_k", (*SAMPLED, SIZE), _hold),
    BlockType("unit-delay", "delay by one period", "y_k = u_(k-1)",
              (*SAMPLED, SimKey("initial", "numbers", "first output", "0"), SIZE), _delay),
    BlockType(
        "python", "a function in a Python file", "f(t, u) or, without inputs, f(t); sampled (x, y) = f(t, x, u)",
        (SimKey("function", "file", "FILE.py:NAME", None),
         SimKey("inputs", "integer", "number of inputs, from 0", None),
         SimKey("outputs", "integer", "number of outputs", None), PERIOD, OFFSET,
         SimKey("delay", "flag", "show a sampled output one period later", "no")), _python,
    ),
    BlockType(
        "scope", "looks at signals: drawn with --plot, stored with the result", "no outputs",
        (SIZE, SimKey("title", "text", "above its panel", ""),
         SimKey("labels", "text", "names of the curves, with commas; default the names of the signals", ""),
         SimKey("unit", "text", "of the vertical axis", "")), _scope,
    ),
)  # fmt: skip
BY_NAME = {row.name: row for row in BLOCKS}


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


def explanation(name: str) -> Iterator[str]:
    """Lines about a block, for `spacar keywords NAME`."""
    row = BY_NAME[name]
    yield f"block = {row.name}: {row.text}"
    yield "  section of a model file of a simulation (.sim)"
    yield f"  {row.formula}"
    yield ""
    width = max(len(key.name) for key in row.keys)
    for key in row.keys:
        what = "needed" if key.default is None else f"default {key.default}" if key.default else "may be left out"
        unit = f" [{key.unit}]" if key.unit else ""
        yield f"  {key.name:<{width}}  {key.text}{unit}; {key.kind}, {what}"


def page() -> str:
    """docs/reference/blocks.md."""
    lines = [
        "# Blocks of a simulation",
        "",
        "Made from the table of blocks by `python -m spacar_formats.sim_blocks > docs/reference/blocks.md`. A section",
        "`[NAME]` of a `.sim` file has `block =` one of these and its keys; see [simulation](../simulation.md).",
        "Numbers are separated by blanks or commas, rows of a matrix by `;`. Formulas and sources stand in",
        "`spacar/simulation/switching_blocks.py`, `control_blocks.py`, `transport_delay.py` and `sampled_blocks.py`.",
    ]
    for row in BLOCKS:
        text = f"{row.text[0].upper()}{row.text[1:]}: {row.formula.replace('*', '·')}."
        lines += ["", f"## {row.name}", "", text, ""]
        lines += ["| key | | kind | default | unit |", "|---|---|---|---|---|"]
        for key in row.keys:
            default = "needed" if key.default is None else key.default
            cells = (f"`{key.name}`", key.text, key.kind, default, key.unit)
            lines.append("|" + "|".join(f" {c} " if c else " " for c in cells) + "|")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(page(), end="")
