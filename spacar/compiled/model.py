"""A mechanism, or several that differ in numbers only, as the solver in C sees it.

Arrays of numbers have one more axis at the end, of the length `lanes`: one column per case.
"""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np

from spacar.compiled.library import DOUBLES, INTEGERS, CBatch, CSpec, library
from spacar.compiled.parameters import KINDS, SUPPORTED
from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.saddle_point import free_coordinates
from spacar.mechanism.mechanism import Array, Drive, Mechanism, Polynomial


def why_not(mechanism: Mechanism) -> str | None:
    """Why this mechanism cannot be compiled, or None."""
    missing = sorted({b.family.keyword for b in mechanism.batches if b.family.keyword not in (*SUPPORTED, "XM")})
    if missing:
        return f"there is no compiled form of {', '.join(missing)}"
    if mechanism.user_signal is not None:
        return "USERSIG needs the general path"
    if len(mechanism.deformation_inertia[0]):
        return "MEE needs the general path"
    if mechanism.loads.moment_rows.size:
        return "constant global moments (XF with three numbers) need the general path"
    return None


class Model:
    """Memory and calls of one `Model` in C.

    `evaluators` (one per lane) give the numbers; their structure is the same. The arrays x, xd, xdd (nx, lanes), e, ed,
    edd, sigma, given_e (ne, lanes), x_motion and e_motion (n, 3, lanes) are shared with C.
    """

    def __init__(self, evaluators: Sequence[Dynamics]) -> None:
        self.lanes = len(evaluators)
        self.library = library(self.lanes)
        self._alive: list[Any] = []  # arrays that C points into
        first = evaluators[0]
        self.numbering = n = first.numbering
        self.polynomial = all(isinstance(d.drive, Polynomial) for d in evaluators)
        self.x, self.xd, self.xdd, self.gravity, self.total = (np.zeros((n.nx, self.lanes)) for _ in range(5))
        self.e, self.ed, self.edd, self.sigma, self.given_e = (np.zeros((n.ne, self.lanes)) for _ in range(5))
        self.x_motion = self._together([_motion(d.drive, "x") for d in evaluators])
        self.e_motion = self._together([_motion(d.drive, "e") for d in evaluators])
        self.n_state = 2 * n.nddof
        self.x[:] = self._together([d.mechanism.x0 for d in evaluators])
        spec = self._spec(evaluators)
        self.handle = ctypes.c_void_p(self.library.spacar_begin(ctypes.addressof(spec)))
        if not self.handle:
            raise MemoryError("no memory for the compiled model")
        self._complete = (
            self.handle, ctypes.c_void_p(self.gravity.ctypes.data), ctypes.c_void_p(self.total.ctypes.data)
        )  # fmt: skip
        weakref.finalize(self, self.library.spacar_end, self.handle)

    def _together(self, arrays: list[Array]) -> Array:
        """The same array of every case, with the cases on a last axis."""
        return np.ascontiguousarray(np.stack(arrays, axis=-1), np.float64)

    def _doubles(self, array: Array) -> Any:
        kept = np.ascontiguousarray(array, np.float64)
        self._alive.append(kept)
        return kept.ctypes.data_as(DOUBLES)

    def _integers(self, array: Array) -> Any:
        kept = np.ascontiguousarray(array, np.int32)
        self._alive.append(kept)
        return kept.ctypes.data_as(INTEGERS)

    def _spec(self, evaluators: Sequence[Dynamics]) -> CSpec:
        first, n = evaluators[0], self.numbering
        xs, es = n.x_class, n.e_class
        batches = [
            self._batch([d.mechanism.batches[i] for d in evaluators])
            for i, b in enumerate(first.mechanism.batches) if b.family.keyword in SUPPORTED
        ]  # fmt: skip
        table = (CBatch * len(batches))(*batches)
        self._alive.append(table)
        mass = [_constant_mass(d) for d in evaluators]
        F = free_coordinates(n)
        S, D = first.law.stiffness, first.law.damping

        def numbers(values: list[Array]) -> Any:
            return self._doubles(self._together(values))

        equations = len(first.kinematics.E)
        counts = [
            n.nx, n.ne, xs["calculable"].start, es["input"].stop, equations, len(batches), len(S[0]), len(D[0]),
            int(n.nddof == 0), len(mass[0][0]), len(F),
        ]  # fmt: skip
        for table_of in (xs, es):
            for name in ("input", "dynamic"):
                counts += [table_of[name].start, table_of[name].stop - table_of[name].start]
        return CSpec(
            *counts, int(self.polynomial), table,
            self._integers(mass[0][0]), self._integers(mass[0][1]), numbers([m[2] for m in mass]),
            self._doubles(first.kinematics.scale), numbers([d.loads.force for d in evaluators]),
            numbers([d.forces.field for d in evaluators]), numbers([d.law.preload for d in evaluators]),
            self._integers(S[0]), self._integers(S[1]), self._integers(D[0]), self._integers(D[1]),
            numbers([d.law.stiffness[2] for d in evaluators]), numbers([d.law.damping[2] for d in evaluators]),
            self._integers(F), numbers([d.mechanism.x0 for d in evaluators]),
            *map(self._doubles, (
                self.x_motion, self.e_motion, self.x, self.xd, self.xdd, self.e, self.ed, self.edd, self.sigma,
                self.given_e,
            )),
        )  # fmt: skip

    def _batch(self, cases: list[Any]) -> CBatch:
        b = cases[0]
        kind, parameters = SUPPORTED[b.family.keyword]
        p = self._together([parameters(case.family).T for case in cases])
        moving = b.family.has_mass and not b.family.constant_mass
        return CBatch(
            KINDS.index(kind), b.family.n, len(b.x), len(b.e), p.shape[1], int(moving),
            self._integers(b.x.T), self._integers(b.e.T), self._doubles(p),
        )  # fmt: skip

    def begin(self, x: Array, e: Array) -> None:
        """Positions (nx, lanes) and deformations (ne, lanes) that the next guess starts from."""
        self.x[:], self.e[:] = x, e
        self.library.spacar_forget(self.handle)

    def complete(self) -> None:
        """Rates of deformations, gravity forces and total forces at the last evaluated state."""
        self.library.spacar_complete(*self._complete)

    def places(self) -> tuple[Array, Array]:
        """Rows and columns of the entries of V."""
        count = self.library.spacar_gradient(self.handle, None, None, None)
        rows, columns = np.zeros(count, np.int32), np.zeros(count, np.int32)
        self.library.spacar_gradient(self.handle, rows.ctypes.data, columns.ctypes.data, None)
        return rows, columns

    def gradient(self, out: Array) -> None:
        """Values of the entries of V at the last evaluated state, (n, lanes)."""
        self.library.spacar_gradient(self.handle, None, None, out.ctypes.data)


def _motion(drive: Drive, what: str) -> Array:
    """Start, rate and acceleration of polynomial motions; room for the present values of others, (n, 3)."""
    if isinstance(drive, Polynomial):
        return np.asarray(getattr(drive, what)).copy()
    return np.zeros((len(getattr(drive.at(0.0), what)), 3))


def _constant_mass(dynamics: Dynamics) -> tuple[Array, Array, Array]:
    """Rows, columns and values of the mass matrices that do not depend on the position."""
    rows, columns, values = [np.zeros(0, int)], [np.zeros(0, int)], [np.zeros(0)]
    for b in dynamics.sweep.massive:
        if b.family.constant_mass:
            shape = (len(b.x), *b.x.shape)
            M = np.broadcast_to(dynamics.sweep.M[id(b)], shape)
            used = np.nonzero(M)
            rows.append(np.broadcast_to(b.x[:, None, :], shape)[used])
            columns.append(np.broadcast_to(b.x[None, :, :], shape)[used])
            values.append(M[used])
    return np.concatenate(rows), np.concatenate(columns), np.concatenate(values)
