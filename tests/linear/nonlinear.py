"""The non-linear model as a function of everything that the linearization varies, and its differences.

The truth for theory-system.md (13) is the reduced residual, for (15) the saddle-point accelerations: neither uses the
linearized equations. Differences are central, of order 8, with a step of 4e-3: truncation and rounding are both near
1e-11.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from spacar.dynamics import Dynamics
from spacar.kinematics.transfer import velocity_transfer
from spacar.mechanism.mechanism import DriveState, Mechanism
from spacar.stationary.loading import SteadyDrive

WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])


def jacobian(f: Callable[[np.ndarray], np.ndarray], x: np.ndarray, h: float = 4e-3) -> np.ndarray:
    """df/dx at x, a column for every component of x."""
    columns = []
    for k in range(len(x)):
        total = 0.0
        for i, w in enumerate(WEIGHTS):
            if w:
                y = x.copy()
                y[k] += (i - 4) * h
                total = total + w * f(y)
        columns.append(np.asarray(total) / h)
    return np.array(columns).T


@dataclass(frozen=True)
class State:
    """s (nkdof): q and kinematic coordinates; qd, qdd (ndof)."""

    s: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray


class Nonlinear:
    """Evaluates a mechanism at any State; always from the same configuration, so that differences are smooth."""

    def __init__(self, mechanism: Mechanism, base: State) -> None:
        self.mechanism, self.base = mechanism, base
        self.n = mechanism.numbering
        self.d = Dynamics(mechanism)
        self.d.kinematics.position(mechanism.x0, np.zeros(self.n.ne))
        self._drive(base)
        for fraction in np.linspace(0, 1, 11)[1:]:
            start = self._start()
            self._place(replace(base, s=start + fraction * (base.s - start)))
        self._x, self._e = self.d.kinematics.x.copy(), self.d.kinematics.e_given.copy()

    def _start(self) -> np.ndarray:
        n, x0 = self.n, self.mechanism.x0
        return np.concatenate((x0[n.q_x], np.zeros(len(n.q_e)), x0[n.x_class["kinematic"]], np.zeros(int(n.nep[4]))))

    def _drive(self, state: State) -> DriveState:
        n = self.n
        r = n.rheonomic
        nxr = int(n.nxp[2])
        s, v, a = state.s[r], state.qd[r], state.qdd[r]
        drive = DriveState(s[:nxr], v[:nxr], a[:nxr], s[nxr:], v[nxr:], a[nxr:])
        # forces and law keep what a test has put on them
        self.d.drive = SteadyDrive(drive)
        return drive

    def _place(self, state: State) -> DriveState:
        n = self.n
        drive = self._drive(state)
        self.y = np.concatenate((state.s[n.dynamic], state.s[n.ndof :], state.qd[n.dynamic]))
        self.d.place(0.0, self.y)
        return drive

    def place(self, state: State) -> DriveState:
        """Position and velocity of the state."""
        self.d.kinematics.x, self.d.kinematics.e_given = self._x.copy(), self._e.copy()
        self.d.sweep.strain(self._x)
        return self._place(state)

    def accelerations(self, state: State) -> np.ndarray:
        """xdd of given qdd."""
        d, n = self.d, self.n
        xdd, edd = np.zeros(n.nx), np.zeros(n.ne)
        xdd[n.q_x], edd[n.q_e] = state.qdd[: len(n.q_x)], state.qdd[len(n.q_x) :]
        return d.kinematics.dependent(xdd, edd - d.sweep.convective(d.xd))

    def residual(self, state: State) -> np.ndarray:
        """W^T (M xdd + h - f) + We^T (sigma + M_e edd) on all rows of q, with constitutive stresses only."""
        d = self.d
        self.place(state)
        xdd = self.accelerations(state)
        sigma, user = d.constitutive(0.0)
        d.sweep.mass()
        edd = d.sweep.rate(xdd) + d.sweep.convective(d.xd)
        sigma = sigma + d.coupling.stress(edd)
        force = d.sweep.mass_times(xdd) + d.forces.inertia(d.sweep, d.xd) - d.forces(d.kinematics.x, user)
        W = velocity_transfer(d.kinematics)
        return W.T @ force + d.kinematics.sweep_rates(W).T @ sigma

    def kinematic_rates(self, state: State) -> np.ndarray:
        """ds/dt."""
        n = self.n
        self.place(state)
        ed = self.d.sweep.rate(self.d.xd)
        return np.concatenate((state.qd, self.d.xd[n.x_class["kinematic"]], ed[n.e_class["kinematic"]]))


def random_state(mechanism: Mechanism, size: float, seed: int) -> State:
    """A moving, deformed, accelerated state around the reference configuration."""
    n, rng = mechanism.numbering, np.random.default_rng(seed)
    x0 = mechanism.x0
    s = np.concatenate((x0[n.q_x], np.zeros(len(n.q_e)), x0[n.x_class["kinematic"]], np.zeros(int(n.nep[4]))))
    s = s + size * rng.uniform(-1, 1, n.nkdof)
    return State(s, rng.uniform(-1, 1, n.ndof), rng.uniform(-1, 1, n.ndof))
