"""Nominal inputs (NOMS, NOMF) and reference outputs (REFE..., REFX...).

Statements: input-language.md section 7; theory: theory-system.md 7.3.

The driving forces that the degrees of freedom need, with all passive stresses (the springs and dampers of the actuated
joints themselves included), are

    Q = W^T (M xdd + h - f) + We^T sigma_passive                                                          (22)

and the nominal inputs follow from  [s_u We[NOMS]^T, W[NOMF]^T] u0 = Q (23).

A deformation that is prescribed, rests and is no actuator is *rigidified*: INPUTE in mode 2 or 3 for what is flexible
in truth. It is a degree of freedom here, but takes no part in u0: (23) holds for the others, as in the rigid
mechanism where it is fixed. Its own equation gives sigma0, the stress resultant that holds it minus its constitutive
stress (a preload ESIG, or S e when it rests away from zero). It is this difference that excites the deformation once
it is free (24).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import StressLaw
from spacar.errors import AnalysisError, Report
from spacar.frame import Frame
from spacar.kinematics.transfer import moved_along
from spacar.linearization.signals import DRIVING_SIGN, Signal, signals
from spacar.mechanism.mechanism import Mechanism

NOMINAL_KINDS = ("NOMS", "NOMF")
VARIABLE = {
    "REFE": "e", "REFEP": "ed", "REFEDP": "edd", "REFES": "e",
    "REFX": "x", "REFXP": "xd", "REFXDP": "xdd", "REFXS": "x",
}  # fmt: skip
SECOND_ORDER = ("REFES", "REFXS")
ACCELERATIONS = ("REFEDP", "REFXDP")
RANK = 1e-9  # singular values of the scaled distribution of the inputs below this part of the largest are zero


class Ports(NamedTuple):
    """Nominal inputs and reference outputs in the order of their numbers."""

    inputs: tuple[Signal, ...]
    outputs: tuple[Signal, ...]

    @classmethod
    def of(cls, mechanism: Mechanism) -> "Ports":
        """Signals of the third block of a deck of mode 2 or 3."""
        return cls(tuple(signals(mechanism, NOMINAL_KINDS)), tuple(signals(mechanism, tuple(VARIABLE))))

    def reference(self, frame: Frame) -> Array:
        return np.array([getattr(frame, VARIABLE[s.kind])[s.index] for s in self.outputs])

    @property
    def second_order(self) -> Index:
        """Places (from 0) of the outputs with a second order expression."""
        return np.array([k for k, s in enumerate(self.outputs) if s.kind in SECOND_ORDER], np.int64)


def rigidified(mechanism: Mechanism, ports: Ports, rests: Callable[[Mechanism], NDArray[np.bool_]]) -> Index:
    """Rows of e that are prescribed and at rest, have no path (TRE) in this file and are no actuators.

    `rests` says of all deformations (ne,) whether they rest; it is asked only when there is one to be decided on.
    """
    n = mechanism.numbering
    rows = np.arange(n.e_class["input"].start, n.e_class["input"].stop)
    driven = [s.index for s in ports.inputs if s.kind == "NOMS"]
    driven += [n.e_index(s.integer(0), 1) for s in mechanism.deck.of("TRE", block=3)]
    rows = rows[~np.isin(rows, driven)]
    return rows[rests(mechanism)[rows]] if len(rows) else rows


class NominalInputs:
    """Solves (23) at every step: `u0` and, for the rigidified rows `rigid` of e, sigma0.

    Raises AnalysisError 'inverse.inputs' when two inputs do the same or one does nothing. Fewer inputs than
    degrees of freedom that are not rigidified give a least squares solution, more of them one of minimum norm, both
    with a warning in the report. `elastic`: prescribed deformations carry their elastic stress (stationary solutions).
    """

    def __init__(self, ports: Ports, mechanism: Mechanism, report: Report, rigid: Index, elastic: bool = False) -> None:
        n, given = mechanism.numbering, mechanism.numbering.e_class["input"]
        self.ports, self.report = ports, report
        self.residual = (0.0, 0.0)  # largest one, and when
        self.rigid = rigid
        self.S, self.F = (
            np.array([s.index for s in ports.inputs if s.kind == kind], np.int64) for kind in NOMINAL_KINDS
        )
        self.law = StressLaw.of(mechanism, mechanism.loads, first=given.start)
        self.elastic = np.arange(n.ne) >= given.stop
        self.elastic[self.S] = True
        self.elastic[self.rigid] = True
        self.elastic[given] |= elastic
        self.mechanism = mechanism
        self.by_level = elastic  # the preload grows with the load steps
        held = int(n.nxp[2] + n.nxp[3]) + self.rigid - given.start  # among all degrees of freedom
        self.held, self.free = held, np.setdiff1d(np.arange(n.ndof), held)
        if len(ports.inputs) > (free := len(self.free)):
            report.add(
                f"warning: {len(ports.inputs)} nominal inputs for {free} degrees of freedom: the smallest inputs"
                " (minimum norm) are stored"
            )

    def __call__(self, dynamics: Dynamics, frame: Frame) -> tuple[Array, Array]:
        """u0 (number of inputs,) and sigma0 (len(rigid),) at the placed state of `frame`."""
        if not (self.ports.inputs or len(self.rigid)):
            return np.zeros(0), np.zeros(0)
        sweep = dynamics.sweep
        given, e = dynamics.numbering.e_class["input"], frame.e.copy()
        e[given] = dynamics.kinematics.e_given[given]  # exact; e of the frame has the error of the position
        law = self.law
        if self.by_level:
            law = StressLaw.of(self.mechanism, dynamics.loads, first=law.first)
        stress = np.where(self.elastic, law(e, frame.ed), 0.0)
        user = None
        if dynamics.forces.user is not None:
            user = dynamics.forces.user(frame.t, frame.e, frame.ed, frame.x, frame.xd)
            stress += np.where(self.elastic, user.sigma, 0.0)
        stress += dynamics.coupling.stress(frame.edd)
        force = sweep.mass_times(frame.xdd) + dynamics.forces.inertia(sweep, frame.xd) - dynamics.forces(frame.x, user)
        force += sweep.rate_transposed(stress)
        k = dynamics.kinematics
        Q = moved_along(k, force)
        works = []
        for s in self.ports.inputs:
            unit = np.zeros(sweep.ne if s.kind == "NOMS" else sweep.nx)
            unit[s.index] = 1.0
            works.append(moved_along(k, DRIVING_SIGN * sweep.rate_transposed(unit) if s.kind == "NOMS" else unit))
        table = np.array(works).reshape(-1, len(Q)).T
        u0 = self._solve(table[self.free], Q[self.free], frame.t) if self.ports.inputs else np.zeros(0)
        return u0, table[self.held] @ u0 - Q[self.held]

    def apply(self, dynamics: Dynamics, frame: Frame, u0: Array) -> None:
        """Let the actuators carry the motion: u0 replaces the multipliers in stresses and total forces of the frame.

        A released actuated deformation gets its constitutive stress minus s_u u0; what the prescribed coordinates
        still need (nothing, if the inputs suffice) remains as their reaction.
        """
        n, sweep = dynamics.numbering, dynamics.sweep
        released = n.e_class["input"].stop <= self.S
        if not released.any() and not len(self.F):
            return
        by_stress = np.array([s.kind == "NOMS" for s in self.ports.inputs])
        frame.sig[self.S[released]] -= DRIVING_SIGN * u0[by_stress][released]
        force = sweep.mass_times(frame.xdd) + sweep.inertia_force(frame.xd, None)
        inertia = force.copy()
        if dynamics.coupling.present:
            force += sweep.rate_transposed(dynamics.coupling.stress(frame.edd))
        force -= frame.fx + frame.fxgrav
        force[self.F] -= u0[~by_stress]
        dynamics.kinematics.reactions(force, frame.sig)
        frame.fxtot = inertia + sweep.rate_transposed(frame.sig + dynamics.coupling.stress(frame.edd))

    def _solve(self, table: Array, Q: Array, t: float) -> Array:
        size = np.linalg.norm(table, axis=0)
        if np.any(size == 0.0):
            dead = int(np.flatnonzero(size == 0.0)[0])
            raise AnalysisError(
                f"nominal input {dead + 1} ({self.ports.inputs[dead].name}) moves no degree of freedom at t = {t:.9g}",
                "inverse.inputs",
            )
        scaled = table / size
        rows, columns = scaled.shape
        solution, _, rank, _ = np.linalg.lstsq(scaled, Q, rcond=RANK)
        if rank < min(rows, columns):
            raise AnalysisError(
                f"the {columns} nominal inputs control only {rank} of {rows} degrees of freedom at t = {t:.9g}; two"
                " inputs do the same, or the position is singular; choose other actuators (NOMS, NOMF)",
                "inverse.inputs",
            )
        if columns < rows:
            rest = float(np.max(np.abs(scaled @ solution - Q)))
            if rest > max(self.residual[0], 1e-9 * float(np.max(np.abs(Q), initial=0.0))):
                self.residual = rest, t
        return np.asarray(solution / size)

    def finish(self) -> None:
        """After the last step: say by how much too few inputs miss the motion."""
        rest, t = self.residual
        if rest > 0.0:
            self.report.add(
                f"warning: {len(self.ports.inputs)} nominal inputs are fewer than the degrees of freedom and cannot"
                f" produce the motion; least squares, with the largest residual {rest:.4g} at t = {t:.9g}"
            )
