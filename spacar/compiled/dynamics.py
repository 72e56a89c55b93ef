"""Dynamics whose right-hand side and frames are evaluated by the compiled solver."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from spacar.compiled.library import DOUBLES, INTEGERS, CBatch, CModel, library
from spacar.compiled.parameters import KINDS, SUPPORTED
from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.saddle_point import SaddlePoint
from spacar.frame import Frame
from spacar.kinematics.kinematics import CONVERGED, LARGEST_JUMP
from spacar.mechanism.mechanism import Array, Drive, Loads, Mechanism

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
        n = self.numbering
        self._x, self._xd, self._xdd = (np.zeros(n.nx) for _ in range(3))
        self._given_e, self._given_ed, self._given_edd = (np.zeros(n.ne) for _ in range(3))
        self._e, self._ed, self._edd, self._sigma, self._near = (np.zeros(n.ne) for _ in range(5))
        self._pointers = [
            ctypes.c_void_p(a.ctypes.data)
            for a in (
                self._x, self._xd, self._xdd, self._given_e, self._given_ed, self._given_edd, self._near,
                self._e, self._ed, self._edd, self._sigma,
            )
        ]  # fmt: skip
        self._address = ctypes.c_void_p(ctypes.addressof(self.model))

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
        saddle = SaddlePoint(self.mechanism, sweep, "dense")
        N = max(len(self.kinematics.E), saddle.system.n)
        S, D = self.law.stiffness, self.law.damping
        return CModel(
            n.nx, n.ne, xs["calculable"].start, xs["calculable"].stop - xs["calculable"].start, es["input"].stop,
            len(self.kinematics.E), len(batches), len(S[0]), len(D[0]), int(n.nddof == 0),
            table,
            self._doubles(constant), self._doubles(self.kinematics.scale), self._doubles(self.loads.force),
            self._doubles(self.forces.field), self._doubles(self.law.preload),
            self._integers(S[0]), self._integers(S[1]), self._integers(D[0]), self._integers(D[1]),
            self._doubles(S[2]), self._doubles(D[2]),
            self._integers(saddle.F), len(saddle.F), self._mass_scale(),
            self._doubles(np.zeros((n.ne, n.nx))), self._doubles(np.zeros((n.nx, n.nx))),
            self._doubles(np.zeros((N, N))),
            self._doubles(np.zeros(n.ne)), self._doubles(np.zeros(n.nx)), self._doubles(np.zeros(3 * N + n.nx)),
            self._integers(np.zeros(N)),
        )  # fmt: skip

    def _mass_scale(self) -> float:
        """Typical mass: the scale of the constraint rows, as in the general path."""
        self.sweep.strain(self.mechanism.x0)
        self.sweep.mass()
        return SaddlePoint(self.mechanism, self.sweep, "dense").mass_scale

    # -- evaluation -----------------------------------------------------------------------------------------------
    def _evaluate(self, t: float, y: Array) -> bool:
        """Evaluate in C; False when the general path has to look at this state."""
        xs, es, k = self.xs, self.es, self.kinematics
        drive = self.drive.at(t)
        x_old = k.x
        a, m = self.n_xm, self.n_positions
        x, xd, xdd = self._x, self._xd, self._xdd
        x[:] = self.mechanism.x0
        guess = x_old
        if self._last is not None and t != self._last[0]:
            last, x_last, v_last, a_last = self._last
            guess = x_last + (t - last) * (v_last + (0.5 * (t - last)) * a_last)
        x[xs["calculable"]] = guess[xs["calculable"]]
        x[xs["dynamic"]] = y[:a]
        xd[xs["dynamic"]] = y[m : m + a]
        xdd[:] = 0.0
        given_e, given_ed = self._given_e, self._given_ed
        given_e[es["dynamic"]], given_ed[es["dynamic"]] = y[a:m], y[m + a :]
        if len(self.numbering.rheonomic):
            x[xs["input"]], xd[xs["input"]], xdd[xs["input"]] = drive.x, drive.xd, drive.xdd
            given_e[es["input"]], given_ed[es["input"]], self._given_edd[es["input"]] = drive.e, drive.ed, drive.edd
        near = self._near
        near[:] = self.sweep.near
        near[: es["dynamic"].stop] = given_e[: es["dynamic"].stop]
        iterations = self.library.spacar_evaluate(self._address, *self._pointers, k.converged)
        if iterations < 0 or float(np.abs((x - x_old) / k.scale).max()) > LARGEST_JUMP:
            self._last = None
            return False
        k.x = x.copy()
        k.iterations = iterations
        k.e_given = given_e.copy()
        k.forget_factors()
        self.sweep.near[:] = self._e
        self._last = (t, k.x, xd.copy(), xdd.copy())
        return True

    def rhs(self, t: float, y: Array) -> Array:
        if not self._evaluate(t, y):
            return super().rhs(t, y)
        self.evaluations += 1
        a, m = self.n_xm, self.n_positions
        out = np.empty(2 * m)
        out[:m] = y[m:]
        out[m : m + a] = self._xdd[self.xs["dynamic"]]
        out[m + a :] = self._edd[self.es["dynamic"]]
        return out

    def frame(self, t: float, y: Array) -> Frame:
        k = self.kinematics
        converged, k.converged = k.converged, CONVERGED
        evaluated = self._evaluate(t, y)
        k.converged = converged
        if not evaluated:
            return super().frame(t, y)
        gravity, total = np.zeros(self.numbering.nx), np.zeros(self.numbering.nx)
        pointers = (ctypes.c_void_p(a.ctypes.data) for a in (self._xdd, self._sigma, gravity, total))
        self.library.spacar_forces(self._address, *pointers)
        k.refresh()  # the checks of stored steps use the families
        self.xd = self._xd.copy()
        return Frame(
            t=t, x=k.x.copy(), xd=self.xd.copy(), xdd=self._xdd.copy(), e=self._e.copy(), ed=self._ed.copy(),
            edd=self._edd.copy(), sig=self._sigma.copy(), fx=self.loads.force.copy(), fxgrav=gravity, fxtot=total,
        )  # fmt: skip
