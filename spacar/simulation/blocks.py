"""Blocks of a diagram: what has inputs, outputs and perhaps states.

A block gives its outputs in two calls. `state_outputs` needs no inputs; `outputs` does. Only rows for which `direct` is
True may differ between the two, so an output without direct feedthrough (the position of a mechanism) is known before
the inputs are, even when another one (its acceleration) is not.
"""

from collections.abc import Callable, Sequence
from copy import deepcopy
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.errors import BY_USERS, AnalysisError, UsageError, type_and_text

Names = Sequence[str] | int  # of signals, or how many these are
NONE: Array = np.zeros(0)


class Affine(NamedTuple):
    """x' = A x + B u + a, y = C x + D u + c."""

    A: Array
    B: Array
    C: Array
    D: Array
    a: Array
    c: Array


class Block:
    """Base: a block without states whose outputs all depend directly on all inputs.

    inputs, outputs   names of the signals
    direct            (n_out,) bool: does the output depend on the present inputs?
    x0                initial continuous states
    breaks            times where the block's right-hand side jumps
    period, offset    a sampled block: its outputs change at offset + k period only [s]
    lag               time that the block looks back; it is told its inputs in every step (transport_delay.py) [s]
    n_events          number of functions of `events`; zero for a block that is smooth
    event_word        what the log calls its events: "limit of NAME"
    doubt             after `start`: what the log says of the start state, None: nothing

    A block that is smooth only piecewise (a saturation, a relay) has a mode: the piece it is in. The mode stays as it
    is while a step is tried, so that every step sees a smooth right-hand side, also beyond the end of the piece; the
    engine finds the time where `events` says that the piece ends, and there `switch` chooses the mode anew.
    """

    period: float | None = None
    offset: float = 0.0
    delay: bool = False
    lag: float = 0.0
    doubt: str | None = None
    n_events: int = 0
    event_word: str = "limit"

    def __init__(self, name: str, inputs: Names, outputs: Names) -> None:
        self.name = name
        self.inputs = _names("u", inputs)
        self.outputs_ = _names("y", outputs)
        self.x0: Array = NONE
        self.direct: NDArray[np.bool_] = np.full(self.n_out, bool(self.n_in))
        self.breaks: tuple[float, ...] = ()

    @property
    def n_in(self) -> int:
        return len(self.inputs)

    @property
    def n_out(self) -> int:
        return len(self.outputs_)

    @property
    def n_states(self) -> int:
        return len(self.x0)

    def start(self) -> Array:
        """Initial continuous states; forgets everything about an earlier simulation."""
        return self.x0.copy()

    def stops_within(self, span: float) -> float:
        """About how many samples and edges there are in this time [s]; `breaks` are not counted."""
        return 0.0 if self.period is None else span / self.period

    def breaks_until(self, first: float, last: float) -> list[float]:
        """Breaks between two times that depend on them (of a periodic signal), besides `breaks`."""
        return []

    def state_outputs(self, t: float, x: Array) -> Array:
        """Outputs, right in the rows that do not depend directly on the inputs, (n_out,)."""
        return self.outputs(t, x, np.zeros(self.n_in))

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        """All outputs, (n_out,). Every block has a function of its own in the place of this or of `state_outputs`."""
        return self.state_outputs(t, x)

    def derivative(self, t: float, x: Array, u: Array) -> Array:
        """Rates of the continuous states, (n_states,)."""
        return NONE

    def affine(self) -> Affine | None:
        """The block in its present mode, where that is affine with constants; else None."""
        return None

    def events(self, t: float, x: Array, u: Array) -> Array:
        """(n_events,) functions that are not negative as long as the present mode holds."""
        return NONE

    def switch(self, t: float, x: Array, u: Array) -> bool:
        """Choose the mode that fits these values. True when it was another one before."""
        return False

    def step(self, t: float, u: Array) -> Array:
        """A sampled block at a sampling time: its new outputs, (n_out,)."""
        raise NotImplementedError


def _names(letter: str, given: Names) -> tuple[str, ...]:
    return tuple(f"{letter}{k + 1}" for k in range(given)) if isinstance(given, int) else tuple(given)


def checked(value: Any, size: int, what: str, t: float) -> Array:
    """A user's return value as (size,) finite numbers; AnalysisError with shape, time and component otherwise."""
    try:
        found = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise AnalysisError(f"{what} at t = {t:.9g} is no vector of numbers: {error}", "simulation.shape") from error
    if found.shape != (size,) and not (size == 1 and found.size == 1):
        text = f"{what} at t = {t:.9g} has the shape {found.shape}; expected ({size},)"
        raise AnalysisError(text, "simulation.shape")
    found = found.reshape(size)
    if not np.isfinite(found).all():
        k = int(np.flatnonzero(~np.isfinite(found))[0])
        raise AnalysisError(f"{what} at t = {t:.9g}: component {k + 1} is {found[k]}", "simulation.not-finite")
    return found


def guarded(function: Callable[..., Any], what: str, t: float, *arguments: Any) -> Any:
    """Call a user's function; whatever it raises becomes an AnalysisError with its name and the time."""
    try:
        return function(t, *arguments)
    except AnalysisError:
        raise
    except BY_USERS as error:  # a user's function may fail in any way
        text = f"{what} failed at t = {t:.9g}: {type_and_text(error)}"
        raise AnalysisError(text, "simulation.controller-failed") from error


class Function(Block):
    """y = f(t, u): a controller without memory, or a source when there are no inputs (then f(t))."""

    def __init__(
        self, name: str, f: Callable[..., Any], inputs: Names, outputs: Names,
        breaks: Sequence[float] = (),
    ) -> None:  # fmt: skip
        super().__init__(name, inputs, outputs)
        self.f, self.breaks = f, tuple(breaks)

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        arguments = (u.copy(),) if self.n_in else ()
        return checked(guarded(self.f, self.name, t, *arguments), self.n_out, f"the output of {self.name}", t)


class Continuous(Block):
    """dx/dt = f(t, x, u), y = g(t, x, u); `direct=False` promises that g does not use u."""

    def __init__(
        self, name: str, f: Callable[..., Any], g: Callable[..., Any], x0: Sequence[float], inputs: Names,
        outputs: Names, direct: bool = True, breaks: Sequence[float] = (),
    ) -> None:  # fmt: skip
        super().__init__(name, inputs, outputs)
        self.f, self.g, self.breaks = f, g, tuple(breaks)
        self.x0 = np.array(x0, float)
        self.direct = np.full(self.n_out, direct and bool(self.n_in))

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        value = guarded(self.g, self.name, t, x.copy(), u.copy())
        return checked(value, self.n_out, f"the output of {self.name}", t)

    def derivative(self, t: float, x: Array, u: Array) -> Array:
        value = guarded(self.f, self.name, t, x.copy(), u.copy())
        return checked(value, self.n_states, f"the derivative of the states of {self.name}", t)


class Sampled(Block):
    """A discrete-time controller: (x, y) = f(t, x, u) at t = offset + k period, y held in between.

    `delay=True`: the y of one sampling time appears at the next one (the time that a computer needs).
    Before its first output the block gives `y0` (default zero). The state x may be any Python object.
    """

    def __init__(
        self, name: str, f: Callable[..., Any], period: float, inputs: Names,
        outputs: Names, *, x0: Any = None, y0: Sequence[float] | None = None,
        offset: float = 0.0, delay: bool = False,
    ) -> None:  # fmt: skip
        super().__init__(name, inputs, outputs)
        if not period > 0.0:
            raise UsageError(f"{name}: the sampling period must be positive, not {period}", "simulation.period")
        self.f, self.period, self.offset, self.delay = f, float(period), float(offset), delay
        self.memory0 = x0
        self.y0 = np.zeros(self.n_out) if y0 is None else checked(y0, self.n_out, f"the start output of {name}", 0.0)
        self.direct = np.full(self.n_out, not delay)
        self.start()

    def start(self) -> Array:
        self.memory = deepcopy(self.memory0)
        self.held, self.waiting = self.y0.copy(), self.y0.copy()
        return NONE

    def state_outputs(self, t: float, x: Array) -> Array:
        return self.held

    def step(self, t: float, u: Array) -> Array:
        value = guarded(self.f, self.name, t, self.memory, u.copy())
        try:
            self.memory, y = value
        except (TypeError, ValueError):
            text = f"{self.name} must return its new state and its output, (x, y)"
            raise AnalysisError(text, "simulation.shape") from None
        self.waiting = checked(y, self.n_out, f"the output of {self.name}", t).copy()
        if not self.delay:
            self.held = self.waiting
        return self.held

    def release(self) -> None:
        """A delayed block at a sampling time: show the output of the last one."""
        self.held = self.waiting


class Gain(Block):
    """y = K u with a number or a matrix K (n_out, n_in)."""

    def __init__(self, name: str, K: float | Sequence[Sequence[float]] | Array, size: int | None = None) -> None:
        table = np.asarray(K, float)
        if table.ndim == 0:
            table = float(table) * np.eye(1 if size is None else size)
        if table.ndim != 2 or not np.isfinite(table).all():
            raise UsageError(f"{name}: the gain must be a number or a matrix of finite numbers", "simulation.gain")
        super().__init__(name, table.shape[1], table.shape[0])
        self.K = table

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return self.K @ u

    def affine(self) -> Affine:
        return without_states(self.K, np.zeros(self.n_out))


def without_states(D: Array, c: Array) -> Affine:
    """y = D u + c."""
    return Affine(np.zeros((0, 0)), np.zeros((0, D.shape[1])), np.zeros((len(D), 0)), D, NONE, c)


def proportional_derivative(name: str, size: int, omega: float, damping: float) -> Gain:
    """y = omega^2 u[:size] + 2 damping omega u[size:]: PD control of `size` errors followed by their rates.

    omega [rad/s], damping [1]
    """
    eye = np.eye(size)
    return Gain(name, np.hstack((omega**2 * eye, 2.0 * damping * omega * eye)))


class Product(Block):
    """y = u[:size] * u[size:], signal by signal."""

    def __init__(self, name: str, size: int = 1) -> None:
        super().__init__(name, 2 * size, size)

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return u[: self.n_out] * u[self.n_out :]


def fitting(name: str, A: Any, B: Any, C: Any, D: Any = None) -> tuple[Array, Array, Array, Array]:
    """The matrices of a linear system, D zero where there is none. Raises UsageError for shapes that do not fit."""
    A, B, C = (np.atleast_2d(np.asarray(m, float)) for m in (A, B, C))
    n, m, p = len(A), B.shape[1], len(C)
    D = np.zeros((p, m)) if D is None else np.atleast_2d(np.asarray(D, float))
    if A.shape != (n, n) or len(B) != n or C.shape[1] != n or D.shape != (p, m):
        shapes = ", ".join(str(k.shape) for k in (A, B, C, D))
        raise UsageError(f"{name}: the shapes of A, B, C, D do not fit together: {shapes}", "simulation.size")
    return A, B, C, D


class Linear(Continuous):
    """A constant linear system dx/dt = A x + B u, y = C x + D u."""

    def __init__(
        self, name: str, A: Array, B: Array, C: Array, D: Array | None = None, x0: Sequence[float] | None = None
    ) -> None:
        A, B, C, D = fitting(name, A, B, C, D)
        n, m, p = len(A), B.shape[1], len(C)
        start = [0.0] * n if x0 is None else x0
        super().__init__(name, lambda t, x, u: A @ x + B @ u, lambda t, x, u: C @ x + D @ u, start, m, p, bool(D.any()))
        self._affine = Affine(A, B, C, D, np.zeros(n), np.zeros(p))

    def affine(self) -> Affine:
        return self._affine


class Scope(Block):
    """A block without outputs: its inputs are kept at every output time, drawn over time and stored with the result.

    title     above its panel (default the name of the block);  labels of the curves (default: of the signals)
    unit      of the vertical axis, as text
    """

    def __init__(self, name: str, size: int = 1, title: str = "", labels: Sequence[str] = (), unit: str = "") -> None:
        if labels and len(labels) != size:
            raise UsageError(f"{name}: {len(labels)} labels for {size} signals", "simulation.size")
        super().__init__(name, size, 0)
        self.title, self.labels, self.unit = title or name, tuple(labels), unit

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        return NONE
