"""Spasim: the non-linear mechanism as a block with inputs u and outputs y (input-language.md section 9).

States are the degrees of freedom and their rates. Inputs are driving stresses (INPUTS, positive when they do positive
work on the rate of their deformation) and forces (INPUTF). Outputs that are accelerations depend directly on the
inputs, the others do not.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import component_name
from spacar.errors import UsageError
from spacar.frame import Frame
from spacar.linear.linearization_signals import signals
from spacar.linear.state_space import DRIVING_SIGN
from spacar.mechanism import build
from spacar.mechanism.mechanism import Mechanism
from spacar.simulation.blocks import Block
from spacar.simulation.evaluated_plant import ArrayPlant, CompiledPlant
from spacar.sources import Source, deck_of

INPUT_KINDS = ("INPUTS", "INPUTF")
OUTPUT_KINDS = ("OUTE", "OUTEP", "OUTEDP", "OUTX", "OUTXP", "OUTXDP")
POSITION, RATE, ACCELERATION = range(3)
QUANTITY = {
    "OUTE": POSITION,
    "OUTX": POSITION,
    "OUTEP": RATE,
    "OUTXP": RATE,
    "OUTEDP": ACCELERATION,
    "OUTXDP": ACCELERATION,
}


class Spasim(Block):
    """A mechanism from a file name, a Deck, a Model or a Mechanism.

    Raises InputError for a wrong file, UsageError without dynamic degrees of freedom; its methods raise ValueError for
    vectors of wrong size.
    """

    def __init__(self, model: Source | Mechanism, name: str = "plant") -> None:
        mechanism = model if isinstance(model, Mechanism) else build(deck_of(model, "simulation"), 1)
        n = mechanism.numbering
        if not n.nddof:
            text = f"{mechanism.deck.source}: a simulation needs dynamic degrees of freedom (DYNX, DYNE)"
            raise UsageError(text, "simulation.no-states")
        self.mechanism, self.numbering = mechanism, n
        self.u_signals, self.y_signals = signals(mechanism, INPUT_KINDS), signals(mechanism, OUTPUT_KINDS)
        super().__init__(name, [s.name for s in self.u_signals], [s.name for s in self.y_signals])
        self.direct = np.array([QUANTITY[s.kind] == ACCELERATION for s in self.y_signals], bool)
        self._places()
        self.choose(mechanism.settings.compiled)
        self.breaks = tuple(mechanism.drive.breaks)
        names = [component_name(n, i) for i in range(2 * n.nddof + n.nk)]
        self.states = tuple(names)
        self.x0 = self.start()

    def choose(self, compiled: bool) -> None:
        """Take the compiled engine where it is available and wanted, else NumPy.

        `engine` becomes ("compiled", its level) or ("general", the reason).
        """
        from spacar.compiled import level, why_general

        settings = replace(self.mechanism.settings, compiled=compiled)
        reason = why_general(replace(self.mechanism, settings=settings))
        self.engine = ("compiled", level()) if reason is None else ("general", reason)
        self.motion = CompiledPlant(self.mechanism) if reason is None else ArrayPlant(self.mechanism)
        self._at: tuple[float, bytes] | None = None
        self._solved: bytes | None = None

    def _places(self) -> None:
        """Index arrays of inputs and outputs, by kind."""
        kinds = np.array([s.kind for s in self.u_signals])
        index = np.array([s.index for s in self.u_signals], np.int64)
        self._by_stress, self._by_force = np.flatnonzero(kinds == "INPUTS"), np.flatnonzero(kinds == "INPUTF")
        self._e_of, self._x_of = index[self._by_stress], index[self._by_force]
        self._read = []
        for quantity in (POSITION, RATE, ACCELERATION):
            for of_elements in (True, False):
                chosen = [k for k, s in enumerate(self.y_signals)
                          if QUANTITY[s.kind] == quantity and s.kind.startswith("OUTE") == of_elements]  # fmt: skip
                rows = np.array([self.y_signals[k].index for k in chosen], np.int64)
                self._read.append((np.array(chosen, np.int64), rows))

    def start(self) -> Array:
        self._at = self._solved = None
        self._push(np.zeros(self.n_in))
        x0 = self.motion.start()
        self.doubt = self.motion.doubt
        return x0

    # -- the mechanism --------------------------------------------------------------------------------------------
    def _push(self, u: Array) -> None:
        """The inputs as stresses and forces."""
        sigma, force = np.zeros(self.numbering.ne), np.zeros(self.numbering.nx)
        np.add.at(sigma, self._e_of, -DRIVING_SIGN * u[self._by_stress])
        np.add.at(force, self._x_of, u[self._by_force])
        self.motion.push(sigma, force)

    def _place(self, t: float, x: Array) -> None:
        key = (t, x.tobytes())
        if key != self._at:
            self._at = self._solved = None
            self.motion.place(t, x)
            self._at = key

    def _solve(self, t: float, x: Array, u: Array) -> None:
        """Accelerations for these inputs; what is already known is not computed again."""
        self._place(t, x)
        key = u.tobytes()
        if key != self._solved:
            self._push(u)
            self.motion.accelerate()
            self._solved = key

    def _check(self, x: Array, u: Array | None) -> None:
        if x.shape != self.x0.shape:
            raise ValueError(f"{self.name}: the state has the shape {x.shape}, expected {self.x0.shape}")
        if u is not None and u.shape != (self.n_in,):
            raise ValueError(f"{self.name}: the input has the shape {u.shape}, expected ({self.n_in},)")

    # -- the block ------------------------------------------------------------------------------------------------
    def state_outputs(self, t: float, x: Array) -> Array:
        """Outputs that are positions and rates; accelerations are left zero."""
        self._check(x, None)
        self._place(t, x)
        y = np.zeros(self.n_out)
        (ke, re), (kx, rx), (kep, rep), (kxp, rxp), *_ = self._read
        e, x_now = self.motion.positions()
        y[ke], y[kx] = e[re], x_now[rx]
        if len(kep) or len(kxp):
            ed, xd = self.motion.rates()
            y[kep], y[kxp] = ed[rep], xd[rxp]
        return y

    def outputs(self, t: float, x: Array, u: Array) -> Array:
        self._check(x, u)
        y = self.state_outputs(t, x)
        if self.direct.any():
            self._solve(t, x, u)
            (ke, re), (kx, rx) = self._read[4:]
            edd, xdd = self.motion.accelerations()
            y[ke], y[kx] = edd[re], xdd[rx]
        return y

    def derivative(self, t: float, x: Array, u: Array) -> Array:
        """Time derivative of the states, (n_states,)."""
        self._check(x, u)
        self._solve(t, x, u)
        n = self.numbering
        xs, es, m = n.x_class, n.e_class, n.nddof + n.nk
        out = np.empty(len(x))
        out[: n.nddof] = x[m:]
        if n.nk:
            ed, xd = self.motion.rates()
            out[n.nddof : m] = np.concatenate((xd[xs["kinematic"]], ed[es["kinematic"]]))
        edd, xdd = self.motion.accelerations()
        out[m:] = np.concatenate((xdd[xs["dynamic"]], edd[es["dynamic"]]))
        return out

    def frame(self, t: float, x: Array, u: Array) -> Frame:
        """The whole state of the mechanism for these inputs, as mode 1 gives it."""
        self._check(x, u)
        self._at = self._solved = None
        self._push(u)
        return self.motion.frame(t, x)
