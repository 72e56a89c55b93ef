"""Which of two methods goes on: an explicit one, or Radau IIA of order 9 (595) where a vibration or a decay that is
faster than the motion limits the steps. Mechanisms (`automatic`) and simulations (`spacar.simulation.stepping`) ask
here; what a step costs is theirs to count.

An undamped vibration need not be excited to do so: what rounding and errors leave of it stays at the size of the
tolerance of a step, and the error control keeps h omega below the stability of the method. Radau IIA passes over it.
After 100, 200, 400 ... accepted steps of the explicit method the largest omega is asked for. Where h omega is above
`fast` and enough steps are ahead, 595 is tried. It stays when more time passes for its work than with the explicit
method; when the vibration is the motion itself it does not. It is left when over WATCHED steps less than LEFT of that
time passes. Old vibrations that have to be damped first let its steps grow slowly: a trial of TRIAL steps goes on up to
LONGEST_TRIAL while each LAST of them are GROWING times the ones before, or PROMISING part of what has to be reached.
Where no step of the explicit method is small enough, 595 is tried at once.

So what is not stiff is computed as by the explicit method, step by step, and a model that is asked in vain loses less
than the part LOST: what trials have cost and TRIAL more steps of 595, over LOST, have to be ahead. Looks cost less than
SEEN.
"""

from collections import deque
from collections.abc import Callable

import numpy as np

from spacar.errors import AnalysisError

FIRST_LOOK = 100  # accepted steps
TRIAL, LAST = 20, 10  # steps of 595 that are tried, of these the last count
LONGEST_TRIAL, GROWING, PROMISING = 160, 1.2, 0.4
LOST = 0.2  # part of the steps ahead that trials in vain may cost
WATCHED, LEFT = 100, 0.5  # steps of 595 over which their mean is watched, and the part below which it is left
SEEN = 0.03  # the part of the steps ahead that looks may cost


class MethodChoice:
    """The choice in one integration, which is told of the accepted steps. `largest(t, y)` gives omega [1/s], 0 where
    nothing is faster than the motion.

    gain, cost      of a step of 595, and of a look at omega, in steps of the explicit method
    fast            h omega above which a vibration may limit its steps
    trying, stays   whether 595 goes on, and whether it was kept;  tried_at [s]
    omega           found in the last look [1/s];  size   mean of the explicit steps before it [s]
    """

    def __init__(self, gain: float, cost: float, fast: float, largest: Callable[[float, np.ndarray], float]) -> None:
        self.gain, self.cost, self.fast, self.largest = gain, cost, fast, largest
        self.look = FIRST_LOOK
        self.looks, self.lost = 0, 0.0  # lost by trials in vain, in steps of the explicit method
        self.omega = self.size = self.tried_at = 0.0
        self.trying = self.stays = False
        self.last, self.counted = 0.0, 0  # time and steps from which the mean is taken

    def begin(self, t: float, steps: int) -> None:
        """The explicit method goes on at t, after so many of its steps."""
        self.last, self.counted = t, steps

    def limited(self, t: float, y: np.ndarray, steps: int, end: float) -> bool:
        """After so many `steps` of the explicit method: may a vibration limit them, and is there enough ahead?"""
        self.look = 2 * steps
        if not t > self.last:
            return False  # events at one time
        self.size = (t - self.last) / (steps - self.counted)
        self.last, self.counted = t, steps
        ahead = (end - t) / self.size
        if LOST * ahead < self.lost + TRIAL * self.gain or SEEN * ahead < (self.looks + 1) * self.cost:
            return False
        self.looks += 1
        try:
            self.omega = self.largest(t, y)
        except AnalysisError:
            return False  # next to a place that cannot be evaluated: no time to change
        return self.size * self.omega > self.fast

    def attempt(self, t: float, work: float = 0.0) -> None:
        """Go on with 595, at this count of work."""
        self.trying, self.stays, self.tried_at = True, False, t
        self.way: deque[tuple[float, float]] = deque([(t, work)], WATCHED + 1)  # times, and the work so far
        self.made, self.begun = 0, work

    def worth(self, k: int) -> float:
        """The last k steps over those of the explicit method that cost as much."""
        (a, before), (b, now) = self.way[-1 - k], self.way[-1]
        return (b - a) / (self.size * (now - before))

    def goes_on(self, t: float, work: float) -> bool:
        """After a step of 595 to t, with so much work so far, in steps of the explicit method: is it not left?"""
        self.made += 1
        self.way.append((t, work))
        if self.stays:
            if self.made < WATCHED or self.worth(WATCHED) >= LEFT:
                return True
        elif self.made < TRIAL or self.made % LAST:
            return True
        else:
            good = self.worth(LAST)
            self.stays = good > 1.0
            (a, _), (b, _) = self.way[-1 - 2 * LAST], self.way[-1 - LAST]
            if self.stays or (self.made < LONGEST_TRIAL and (t - b >= GROWING * (b - a) or good >= PROMISING)):
                return True
        self.lost += max(0.0, work - self.begun - (t - self.tried_at) / self.size)
        self.trying = self.stays = False
        return False
