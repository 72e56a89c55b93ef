"""The blocks that a model file of a simulation knows: names, keys, and what they mean.

`python -m spacar_formats.sim_blocks` prints docs/reference/blocks.md. How the section of a block is read stands in
`spacar_formats.block_makers`.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from spacar.simulation import blocks, control_blocks, signal_sources, switching_blocks
from spacar.simulation.blocks import Block
from spacar.simulation.setpoint_blocks import Ltv, ReferenceY0, SetpointSigma0, SetpointU0, TimesM0
from spacar.simulation.transport_delay import TransportDelay
from spacar_formats import block_makers as make
from spacar_formats.block_makers import built
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

WAVE = ("amplitude", "frequency", "phase", "bias")
EACH = ", one number for each signal"


def _values(key: str, text: str, default: str | None = None, unit: str = "") -> SimKey:
    return SimKey(key, "numbers", text + EACH, default, unit)


BLOCKS = (
    BlockType(
        "spasim", "the non-linear mechanism", "inputs INPUTS, INPUTF; outputs OUT... of its file",
        (SimKey("model", "file", "input file (.dat)", None),), make.spasim,
    ),
    BlockType(
        "ltv", "time-varying linear system of mode 3, 4 or 9", "z' = A(t) z + B(t) u, y = C(t) z + D(t) u",
        (FILE, *STORED, SimKey("modes", "integer", "reduce to that many modes", "")), make.stored(Ltv, "modes"),
    ),
    BlockType("setpoint-u0", "nominal inputs", "y = u0(t)", (FILE, *STORED), make.stored(SetpointU0)),
    BlockType(
        "setpoint-sigma0", "stresses of the rigidified deformations", "y = sigma0(t)", (FILE, *STORED),
        make.stored(SetpointSigma0),
    ),
    BlockType("reference-y0", "reference outputs", "y = y0(t)", (FILE, *STORED), make.stored(ReferenceY0)),
    BlockType(
        "times-m0", "the reduced mass matrix", "y = M0(t) u",
        (FILE, *STORED, SimKey("size", "integer", "its leading block only", "")), make.stored(TimesM0, "size"),
    ),
    BlockType("constant", "a constant", "y = value", (_values("value", "value"),),
              built(signal_sources.Constant, "value")),
    BlockType(
        "step", "a step", "y = before for t < time, then after",
        (SimKey("time", "number", "of the step, met exactly", "0", "s"), _values("after", "value", "1"),
         _values("before", "value", "0")),
        built(signal_sources.StepSignal, "time", "after", "before", each=("after", "before")),
    ),
    BlockType(
        "ramp", "a ramp", "y = start for t < time, then start + slope (t - time)",
        (_values("slope", "slope", None, "1/s"), SimKey("time", "number", "where it begins", "0", "s"),
         _values("start", "value", "0")),
        built(signal_sources.Ramp, "slope", "time", "start", each=("slope", "start")),
    ),
    BlockType(
        "sine", "a sine", "y = bias + amplitude sin(2 pi frequency t + phase)",
        (_values("amplitude", "amplitude"), _values("frequency", "frequency", None, "Hz"),
         _values("phase", "phase", "0", "rad"), _values("bias", "mean value", "0")),
        built(signal_sources.Sine, *WAVE, each=WAVE),
    ),
    BlockType(
        "pulses", "pulses", "y = high for a part duty of every period, else low; edges are met exactly",
        (SimKey("every", "number", "time from one to the next", None, "s"),
         SimKey("duty", "number", "part of it that is high, 0 to 1", "0.5"), _values("high", "value", "1"),
         _values("low", "value", "0"), SimKey("time", "number", "of the first pulse", "0", "s")),
        built(signal_sources.Pulses, "every", "duty", "high", "low", "time", each=("high", "low")),
    ),
    BlockType(
        "table", "signals over time from a csv file", "first column time, the others signals; with or without heading",
        (SimKey("file", "file", "csv file", None), *STORED), make.table,
    ),
    BlockType(
        "gain", "a constant factor", "y = K u",
        (SimKey("gain", "matrix", "number, or rows separated by ';'", None), SIZE), make.gain,
    ),
    BlockType("product", "a product", "y_i = u_i u_(size+i)", (SIZE,),
              built(blocks.Product, "size")),
    BlockType(
        "pd", "PD control of errors followed by their rates", "y = omega^2 e + 2 damping omega e'",
        (SimKey("size", "integer", "number of errors", None), SimKey("omega", "number", "bandwidth", None, "rad/s"),
         SimKey("damping", "number", "relative damping", None)),
        built(blocks.proportional_derivative, "size", "omega", "damping"),
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
        make.pid,
    ),
    BlockType(
        "transfer-function", "transfer function in s, with period in z", "y = numerator/denominator u, from rest",
        (SimKey("numerator", "numbers", "coefficients by falling powers", None),
         SimKey("denominator", "numbers", "coefficients by falling powers", None), PERIOD, OFFSET),
        make.transfer_function,
    ),
    BlockType(
        "state-space", "linear system, with period a difference equation", "x' = A x + B u, y = C x + D u",
        (*(SimKey(k, "matrix", "rows separated by ';'", None) for k in "ABC"),
         SimKey("D", "matrix", "rows separated by ';'", ""), SimKey("initial", "numbers", "state at the start", ""),
         PERIOD, OFFSET),
        make.state_space,
    ),
    BlockType(
        "integrator", "integrator, perhaps with limits", "y' = gain u, y stays at a limit while u drives it beyond",
        (SimKey("initial", "numbers", "value at the start", "0"), SimKey("gain", "numbers", "factor", "1", "1/s"),
         *OPEN_LIMITS, SIZE), built(control_blocks.Integrator, "initial", "gain", "lower", "upper", "size"),
    ),
    BlockType("saturation", "limits of a signal", "y = u between lower and upper", (*LIMITS, SIZE),
              built(switching_blocks.Saturation, "lower", "upper", "size")),
    BlockType("dead-zone", "dead zone", "y = 0 between lower and upper, beyond them the distance to the nearer one",
              (*LIMITS, SIZE), built(switching_blocks.DeadZone, "lower", "upper", "size")),
    BlockType(
        "relay", "switch with hysteresis", "on above upper, off below lower, unchanged in between",
        (*LIMITS, SimKey("off", "number", "output when off", "0"), SimKey("on", "number", "output when on", "1"),
         SimKey("initially_on", "flag", "state at the start, between the limits", "no"), SIZE),
        built(switching_blocks.Relay, "lower", "upper", "off", "on", "size", "initially_on"),
    ),
    BlockType(
        "quantizer", "quantizer", "y = interval floor(u/interval + 1/2)",
        (SimKey("interval", "numbers", "between two levels", None), SIZE),
        built(switching_blocks.Quantizer, "interval", "size"),
    ),
    BlockType(
        "lookup", "look-up table", "y interpolated in the points (x, y)",
        (SimKey("x", "numbers", "increasing", None), SimKey("y", "numbers", "as many values", None),
         SimKey("interpolation", "text", "linear, cubic (monotone), step", "linear"),
         SimKey("beyond", "text", "outside the table: hold, extrapolate, error", "hold"), SIZE),
        make.lookup,
    ),
    BlockType(
        "rate-limiter", "limits of the rate of a signal",
        "y' = bandwidth (u - y) within [-falling, rising]; sampled: y_k - y_(k-1) within the rates times period",
        (_values("rising", "largest rate upwards", None, "1/s"),
         _values("falling", "largest rate downwards; default as rising", "", "1/s"),
         SimKey("bandwidth", "number", "of a continuous limiter", "", "rad/s"),
         SimKey("initial", "numbers", "output at the start", "0"), PERIOD, OFFSET, SIZE),
        make.rate_limiter,
    ),
    BlockType(
        "transport-delay", "delay of a continuous signal", "y(t) = u(t - delay), initial before",
        (SimKey("delay", "number", "by how much; steps are not longer", None, "s"),
         SimKey("initial", "numbers", "output until the first input comes out", "0"), SIZE),
        built(TransportDelay, "delay", "initial", "size"),
    ),
    BlockType("zero-order-hold", "sample and hold", "y_k = u_k", (*SAMPLED, SIZE), make.hold),
    BlockType("unit-delay", "delay by one period", "y_k = u_(k-1)",
              (*SAMPLED, SimKey("initial", "numbers", "first output", "0"), SIZE), make.delay),
    BlockType(
        "python", "a function in a Python file", "f(t, u) or, without inputs, f(t); sampled (x, y) = f(t, x, u)",
        (SimKey("function", "file", "FILE.py:NAME", None),
         SimKey("inputs", "integer", "number of inputs, from 0", None),
         SimKey("outputs", "integer", "number of outputs", None), PERIOD, OFFSET,
         SimKey("delay", "flag", "show a sampled output one period later", "no")), make.python,
    ),
    BlockType(
        "scope", "looks at signals: drawn with --show, stored with the result", "no outputs",
        (SIZE, SimKey("title", "text", "above its panel", ""),
         SimKey("labels", "text", "names of the curves, with commas; default the names of the signals", ""),
         SimKey("unit", "text", "of the vertical axis", "")), make.scope,
    ),
)  # fmt: skip
BY_NAME = {row.name: row for row in BLOCKS}


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


def _line(key: SimKey) -> str:
    default = "needed" if key.default is None else key.default and f"default {key.default}"
    unit = f" [{key.unit}]" * bool(key.unit)
    kind = ", ".join(filter(None, (key.kind, default)))
    return f"- `{key.name}`{unit}: {key.text.removesuffix(EACH)} ({kind})"


def page() -> str:
    """The page blocks.md: keys that three blocks or more have stand once, at its beginning."""
    keys = [key for row in BLOCKS for key in row.keys]
    shared = [key for key in dict.fromkeys(keys) if keys.count(key) > 2 and key not in OPEN_LIMITS]
    lines = [
        "# Blocks of a simulation",
        "",
        "For writers of `.sim` files ([simulation](../simulation.md)). A section `[NAME]` has `block =` one of these",
        "and its keys. Numbers are separated by blanks or commas, rows of a matrix by `;`; values of signals are one",
        "number for each signal. Made by `python -m spacar_formats.sim_blocks > docs/reference/blocks.md`; formulas",
        "and sources stand in `spacar/simulation/switching_blocks.py`, `control_blocks.py`, `transport_delay.py` and",
        "`sampled_blocks.py`.",
        "",
        "Keys of several blocks, named there without explanation:",
        "",
        *map(_line, shared),
    ]
    for row in BLOCKS:
        text = f"{row.text[0].upper()}{row.text[1:]}: {row.formula.replace('*', '·')}."
        own = [_line(key) for key in row.keys if key not in shared]
        named = ", ".join(f"`{key.name}`" for key in row.keys if key in shared)
        lines += ["", f"## `{row.name}`", "", text, "", *own, *([f"- {named}"] * bool(named))]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(page(), end="")
