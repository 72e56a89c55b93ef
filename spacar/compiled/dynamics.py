"""Dynamics whose right-hand side and frames are evaluated by the compiled solver."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from spacar.compiled.library import DOUBLES, INTEGERS, CBatch, CModel, CState, library
from spacar.compiled.parameters import KINDS, SUPPORTED
from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.saddle_point import free_coordinates
from spacar.frame import Frame
from spacar.kinematics.kinematics import CONVERGED, LARGEST_JUMP
from spacar.mechanism.mechanism import Array, Drive, Loads, Mechanism, Polynomial

Result = TypeVar("Result")
LARGEST = 150  # unknowns of the dense solver in C; above, the banded and sparse paths win


def why_not(mechanism: Mechanism) -> str | None:
    """Why this mechanism cannot be compiled, or None."""
    n = mechanism.numbering
    missing = sorted({b.family.keyword for b in mechanism.batches if b.family.keyword not in (*SUPPORTED, "XM")})
    if missing:
        return f"there is no compiled form of {', '.join(missing)}"
    if mechanism.user_signal is not None:
        return "USERSIG needs the general path"
    if len(mechanism.deformation_inertia[0]):
        return "MEE needs the general path"
    if mechanism.loads.moment_rows.size:
        return "constant global moments (XF with three numbers) need the general path"
    if n.nx + n.ne > 2 * LARGEST:
        return f"it has {n.nx} coordinates and {n.ne} deformations; the compiled solver is for small mechanisms"
    return None


class CompiledDynamics(Dynamics):
    """As Dynamics, with `rhs` and `frame` in C. What fails there is done again by the general path, which explains."""

    def __init__(self, mechanism: Mechanism, *, loads: Loads | None = None, drive: Drive | None = None) -> None:
        super().__init__(mechanism, loads=loads, drive=drive)
        self.library = library()
        self._alive: list[Any] = []  # arrays that C points into
        self.model = self._model()
        self.state = self._state()
        n = self.numbering
        self._y, self._out = np.zeros(2 * n.nddof), np.zeros(2 * n.nddof)
        self._addresses = (
            ctypes.c_void_p(ctypes.addressof(self.model)),
            ctypes.c_void_p(ctypes.addressof(self.state)),
        )
        self._y_address, self._out_address = (ctypes.c_void_p(a.ctypes.data) for a in (self._y, self._out))

    # -- setting up -----------------------------------------------------------------------------------------------
    def _doubles(self, array: Array) -> Any:
        kept = np.ascontiguousarray(array, np.float64)
        self._alive.append(kept)
        return kept.ctypes.data_as(DOUBLES)

    def _integers(self, array: Array) -> Any:
        kept = np.ascontiguousarray(array, np.int32)
        self._alive.append(kept)
        return kept.ctypes.data_as(INTEGERS)

    def _model(self) -> CModel:
        n, sweep = self.numbering, self.sweep
        xs, es = n.x_class, n.e_class
        batches = []
        for b in self.mechanism.batches:
            if b.family.keyword not in SUPPORTED:
                continue
            kind, parameters = SUPPORTED[b.family.keyword]
            p = parameters(b.family)
            moving = b.family.has_mass and not b.family.constant_mass
            batches.append(
                CBatch(
                    KINDS.index(kind), b.family.n, len(b.x), len(b.e), len(p), int(moving),
                    self._integers(b.x.T), self._integers(b.e.T), self._doubles(p.T),
                )
            )  # fmt: skip
        table = (CBatch * len(batches))(*batches)
        self._alive.append(table)
        constant = np.zeros((n.nx, n.nx))
        for b in sweep.massive:
            if b.family.constant_mass:
                np.add.at(constant, (b.x[:, None, :], b.x[None, :, :]), sweep.M[id(b)])
        F = free_coordinates(n)
        self._V = np.zeros((n.ne, n.nx))
        N = max(len(self.kinematics.E), len(F) + es["input"].stop)
        S, D = self.law.stiffness, self.law.damping
        return CModel(
            n.nx, n.ne, xs["calculable"].start, es["input"].stop,
            len(self.kinematics.E), len(batches), len(S[0]), len(D[0]), int(n.nddof == 0),
            table,
            self._doubles(constant), self._doubles(self.kinematics.scale), self._doubles(self.loads.force),
            self._doubles(self.forces.field), self._doubles(self.law.preload),
            self._integers(S[0]), self._integers(S[1]), self._integers(D[0]), self._integers(D[1]),
            self._doubles(S[2]), self._doubles(D[2]),
            self._integers(F), len(F), self._mass_scale(),
            self._doubles(self._V), self._doubles(np.zeros((n.nx, n.nx))),
            self._doubles(np.zeros((N, N))),
            self._doubles(np.zeros(n.ne)), self._doubles(np.zeros(n.nx)), self._doubles(np.zeros(3 * N + n.nx)),
            self._integers(np.zeros(N)),
        )  # fmt: skip

    def _state(self) -> CState:
        """The state in C; its arrays are attributes here, so that both sides see them."""
        n = self.numbering
        xs, es = n.x_class, n.e_class
        drive = self.drive
        self._polynomial = isinstance(drive, Polynomial)
        start = drive.at(0.0)
        self._x_motion = drive.x.copy() if isinstance(drive, Polynomial) else np.zeros((len(start.x), 3))
        self._e_motion = drive.e.copy() if isinstance(drive, Polynomial) else np.zeros((len(start.e), 3))
        self._x, self._xd, self._xdd = (np.zeros(n.nx) for _ in range(3))
        self._given_e, self._e, self._ed, self._edd, self._sigma = (np.zeros(n.ne) for _ in range(5))
        self._x[:] = self.mechanism.x0
        counts = []
        for table in (xs, es):
            for name in ("input", "dynamic"):
                counts += [table[name].start, table[name].stop - table[name].start]
        return CState(
            *counts, int(self._polynomial), 0, 0.0,
            self._doubles(self.mechanism.x0), self._doubles(self._x_motion), self._doubles(self._e_motion),
            self._doubles(self._x), self._doubles(self._xd), self._doubles(self._xdd),
            self._doubles(self._given_e), self._doubles(np.zeros(n.ne)), self._doubles(np.zeros(n.ne)),
            self._doubles(np.zeros(n.ne)), self._doubles(self._e), self._doubles(self._ed), self._doubles(self._edd),
            self._doubles(self._sigma),
            self._doubles(np.zeros(n.nx)), self._doubles(np.zeros(n.nx)), self._doubles(np.zeros(n.nx)),
        )  # fmt: skip

    def _mass_scale(self) -> float:
        """Typical mass at the start, the factor of the constraint rows: geometric mean of the diagonal of M."""
        sweep = self.sweep
        sweep.strain(self.mechanism.x0)
        sweep.mass()
        mass = sweep.m_entries[(sweep.m_rows == sweep.m_columns) & (sweep.m_entries > 0.0)]
        return float(np.exp(np.mean(np.log(mass)))) if len(mass) else 1.0

    # -- evaluation -----------------------------------------------------------------------------------------------
    def start(self) -> Array:
        y = super().start()
        self._take_over()
        return y

    def _take_over(self) -> None:
        """The state in C becomes that of the general path."""
        self._x[:] = self.kinematics.x
        self._e[:] = self.sweep.near
        self.state.known = 0

    def _hand_over(self) -> None:
        """The general path becomes the state in C."""
        k = self.kinematics
        k.start_at(self._x, self._e)
        k.e_given = self._given_e.copy()

    def _prescribe(self, t: float) -> None:
        """Prescribed motion that is not a polynomial: its values at t."""
        if not self._polynomial:
            drive = self.drive.at(t)
            self._x_motion[:] = np.column_stack((drive.x, drive.xd, drive.xdd))
            self._e_motion[:] = np.column_stack((drive.e, drive.ed, drive.edd))

    def rhs(self, t: float, y: Array) -> Array:
        self._prescribe(t)
        self._y[:] = y
        status = self.library.spacar_rhs(
            *self._addresses, t, self._y_address, self._out_address, self.kinematics.converged, LARGEST_JUMP
        )
        if status < 0:
            return self._in_general(lambda: super(CompiledDynamics, self).rhs(t, y))
        self.evaluations += 1
        return self._out.copy()

    def jacobian(self, t: float, y: Array) -> tuple[Array, Array]:
        self._hand_over()
        return super().jacobian(t, y)

    def settle(self) -> None:
        self._hand_over()
        self.sweep.v_entries[:] = self._V[self.sweep.v_rows, self.sweep.v_columns]
        self.kinematics.refactor()

    def _in_general(self, evaluate: Callable[[], Result]) -> Result:
        """Let the general path look at a state that C could not do; it explains failures."""
        self._hand_over()
        self._last = None
        result = evaluate()
        self._take_over()
        return result

    def frame(self, t: float, y: Array) -> Frame:
        self._prescribe(t)
        self._y[:] = y
        status = self.library.spacar_evaluate(*self._addresses, t, self._y_address, CONVERGED, LARGEST_JUMP)
        if status < 0:
            return self._in_general(lambda: super(CompiledDynamics, self).frame(t, y))
        gravity, total = np.zeros(self.numbering.nx), np.zeros(self.numbering.nx)
        pointers = (ctypes.c_void_p(a.ctypes.data) for a in (self._xdd, self._sigma, gravity, total))
        self.library.spacar_forces(self._addresses[0], *pointers)
        self._hand_over()
        self.kinematics.refresh()  # the checks of stored steps use the families
        self.xd = self._xd.copy()
        return Frame(
            t=t, x=self._x.copy(), xd=self.xd.copy(), xdd=self._xdd.copy(), e=self._e.copy(), ed=self._ed.copy(),
            edd=self._edd.copy(), sig=self._sigma.copy(), fx=self.loads.force.copy(), fxgrav=gravity, fxtot=total,
        )  # fmt: skip
