"""Location of events: the first zero of the event functions inside an accepted step.

Event functions are those of the blocks, which are not negative as long as a mode holds (blocks.Block.events), followed
by those of the caller (response.Event). They are looked at in given times of the step, so that two zeros between
neighbouring times are not seen; between the first two times with an event in between, secants and bisection close in
on the zero until the interval is a rounding of the time.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.simulation.response import Event

MOST_LOOKS = 160  # for one event; every third halves the interval


def passed(before: Array, after: Array, events: Sequence[Event]) -> NDArray[np.bool_]:
    """(n,) of the values of all event functions at two times, (n,) each: which modes ended in between, and which
    functions of the caller, the last ones, changed their sign in a direction that counts.
    """
    ended = (before >= 0.0) & (after < 0.0)
    if not events:
        return ended
    n = len(before) - len(events)
    direction = np.array([e.direction for e in events])
    before, after = before[n:], after[n:]
    rising, falling = (before < 0.0) & (after >= 0.0), (before > 0.0) & (after <= 0.0)
    return np.concatenate((ended[:n], (rising & (direction >= 0)) | (falling & (direction <= 0))))


def first_event(
    signs: Callable[[float, Array], Array], state: Callable[[float], Array], t: float, before: Array,
    looks: Sequence[float], events: Sequence[Event], shift: float,
) -> tuple[float, Array, Array, NDArray[np.bool_]]:  # fmt: skip
    """Time [s] just behind the first event, its state (n_states,), the values there and which event functions of blocks
    ended; without an event those of the end of the step.

    signs    values of the event functions at a time and its state
    state    the dense output of the step
    before   the values at its start t
    looks    ascending times at which the functions are looked at, the end of the step last
    shift    the rounding of a time [s]
    """
    low, f_low = t, before
    for high in looks:
        if not low < high:
            continue
        at = state(high)
        f_high = signs(high, at)
        if passed(f_low, f_high, events).any():
            break
        low, f_low = high, f_high
    else:
        return low, state(low), f_low, np.zeros(len(f_low) - len(events), bool)
    for k in range(MOST_LOOKS):
        if high - low <= 3.0 * shift:
            break
        guess = 0.5 * (low + high)
        if k % 3 < 2:  # a secant, a little before and a little behind its zero: the interval closes from both sides
            crossing = passed(f_low, f_high, events)
            start, end = f_low[crossing], f_high[crossing]
            part = np.min(start / (start - end))  # one of them is not zero, and they differ in sign
            guess = low + float(part) * (high - low) + (shift if k % 3 else -shift)
            guess = min(max(guess, low + shift), high - shift)
        if not low < guess < high:
            break
        at_guess = state(guess)
        f = signs(guess, at_guess)
        if passed(f_low, f, events).any():
            high, f_high, at = guess, f, at_guess
        else:
            low, f_low = guess, f
    return high, np.array(at), f_high, passed(f_low, f_high, events)[: len(f_high) - len(events)]
