"""Memory and calls of the solver in C: a model of the numbers of some cases, and the states that it evaluates."""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Sequence
from itertools import accumulate
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.compiled.element_parameters import GUARD
from spacar.compiled.library import CBatch, CSpec, CState, engine, why_off
from spacar.compiled.numbers import FOREIGN, Numbers, without_form
from spacar.compiled.slots import Slots
from spacar.dynamics.saddle_point import free_coordinates
from spacar.kinematics.kinematics import LARGEST_JUMP
from spacar.mechanism.mechanism import Drive, Mechanism, Polynomial, UserSignal
from spacar.mechanism.numbering import Numbering


def why_general(mechanism: Mechanism) -> str | None:
    """Why a run of this mechanism takes the general path, or None: then it is compiled."""
    if not mechanism.settings.compiled:
        return "--general or compiled=False asks for it"
    return why_off()


def why_not_in_lanes(mechanism: Mechanism) -> str | None:
    """Why several cases of this mechanism cannot be evaluated at a time, or None."""
    missing = without_form(mechanism)
    return f"{', '.join(missing)}: without functions in C" if missing else None


# Largest scaled correction that ends the iteration of a stored position: one more follows the first that is below
# CONVERGED, so that velocities and accelerations are those of the position to rounding.
EXACT = 1e-15
WIDTH = ctypes.sizeof(ctypes.c_double)
PLACED = 2  # `known` of a state that was placed with its accelerations: transfer functions are not its own
NOT_ANSWERED = -6  # of sparse.c: Python could not answer, and keeps the error


class State:
    """The last evaluated state, shared with C: x, xd, xdd (nx, cases), e, ed, edd, sigma, given_e (ne, cases).

    Behind xdd there is room for applied, gravity and total forces (nx, cases), as `evaluate` gives them.
    """

    def __init__(self, nx: int, ne: int, cases: int) -> None:
        split, together = 6 * nx, np.zeros((6 * nx + 5 * ne, cases))
        self._together = together
        self.of_x, self.of_e = together[:split].reshape(6, nx, cases), together[split:].reshape(5, ne, cases)
        self.x, self.xd, self.xdd, *_ = self.of_x
        self.e, self.ed, self.edd, self.sigma, self.given_e = self.of_e
        self.x_address, width = together.ctypes.data, WIDTH * cases
        x, xd, xdd, *self.forces_at = (self.x_address + width * nx * k for k in range(6))
        of_e = (self.x_address + width * (split + ne * k) for k in range(5))
        self.c = CState(0, 0.0, x, xd, xdd, *of_e)
        self.address = ctypes.c_void_p(ctypes.addressof(self.c))

    def of_one(self) -> tuple[Array, Array]:
        """Copies of x, xd, xdd and the forces (6, nx), of e, ed, edd and sigma (4, ne) of the only case."""
        kept, (nx, ne) = self._together[:, 0].copy(), (len(self.x), len(self.e))
        return kept[: 6 * nx].reshape(6, nx), kept[6 * nx : 6 * nx + 4 * ne].reshape(4, ne)

    def begin(self, x: Array, e: Array) -> None:
        """Positions and deformations that the next guess starts from."""
        self.x[:], self.e[:] = x, e
        self.c.known = 0

    def resume(self, t: float, x: Array, xd: Array, xdd: Array, e: Array) -> None:
        """The state at t with x, xd, xdd (nx, cases) and e (ne, cases) is the last evaluated one again."""
        self.x[:], self.xd[:], self.xdd[:], self.e[:] = x, xd, xdd, e
        self.c.t, self.c.known = t, PLACED


class CompiledModel:
    """One `Model` of model.c. `scales` (nx,), (ne,): sizes of what is in x and e. `slots`: what Python answers,
    with the `drives` and `users` of all cases.
    """

    def __init__(
        self, numbering: Numbering, numbers: Numbers, scales: tuple[Array, Array], drives: Sequence[Drive],
        users: Sequence[UserSignal] = (),
    ) -> None:  # fmt: skip
        self.numbering = numbering
        self.numbers = numbers
        self.polynomial = all(isinstance(drive, Polynomial) for drive in drives)
        self.cases = numbers.x0.shape[-1]
        self.engine = engine(self.cases)
        self._alive: list[Any] = []  # arrays that C points into
        # contiguous copies are made first, as a motion that is no polynomial is written into them
        self.x_motion, self.e_motion = np.ascontiguousarray(numbers.x_motion), np.ascontiguousarray(numbers.e_motion)
        motions = self.x_motion, self.e_motion
        self.force, self.preload = np.array(numbers.force, order="C"), np.array(numbers.preload, order="C")
        self.slots = Slots(numbers.elements, drives, motions, users, (numbering.nx, numbering.ne, self.cases))
        spec = self._spec(numbers, scales)
        self.handle = ctypes.c_void_p(self.engine.begin(ctypes.addressof(spec)))
        if not self.handle:
            raise MemoryError("no memory for the compiled model")
        weakref.finalize(self, self.engine.end, self.handle)
        self._determinant = np.zeros((2, self.cases))
        first = self._determinant.ctypes.data
        self._determinant_at = first, first + WIDTH * self.cases

    def state(self) -> State:
        """A new state, at the reference configuration."""
        state = State(self.numbering.nx, self.numbering.ne, self.cases)
        state.x[:] = self.numbers.x0
        return state

    # -- setting up -----------------------------------------------------------------------------------------------
    def _spec(self, numbers: Numbers, scales: tuple[Array, Array]) -> CSpec:
        n, batches, slots = self.numbering, numbers.elements, self.slots
        F, mass, S, D = free_coordinates(n), numbers.mass, numbers.stiffness, numbers.damping
        linear, coupling = numbers.moments, numbers.coupling
        position = np.flatnonzero(~n.slips[: n.e_class["kinematic"].stop])
        places = self._packed(
            [
                *mass[:2], *S[:2], *D[:2], *linear[:2], *coupling[:2], F, position,
                *(i for b in batches for i in (b.x, b.e)),
            ],
            np.int32,
        )  # fmt: skip
        (
            constant_row, constant_column, s_rows, s_columns, d_rows, d_columns, m_rows, m_columns, c_rows, c_columns,
            free, given, *indices,
        ) = places  # fmt: skip
        values = self._packed(
            [
                mass[2], *scales, numbers.field, S[2], D[2], linear[2], coupling[2], numbers.x0,
                *(b.parameters for b in batches),
            ],
            np.float64,
        )  # fmt: skip
        (
            constant_mass, scale_at, e_scale_at, field, s_values, d_values, moments, coupled, x0, *parameters,
        ) = values  # fmt: skip
        table = (CBatch * len(batches))(
            *(
                CBatch(
                    b.kind, len(b.x), b.x.shape[1], b.e.shape[1], b.parameters.shape[1], int(b.moving), x, e, p,
                    ctypes.addressof(slots.foreign[k].c) if b.kind == FOREIGN else None,
                )
                for k, (b, x, e, p) in enumerate(zip(batches, indices[::2], indices[1::2], parameters, strict=True))
            )
        )  # fmt: skip
        self._alive.append(table)
        xs, es = n.x_class, n.e_class
        counts = [
            n.nx, n.ne, xs["calculable"].start, es["input"].stop, es["dynamic"].stop, len(table), len(S[0]), len(D[0]),
            int(n.nddof == 0), len(mass[0]), len(F),
        ]  # fmt: skip
        for classes in (xs, es):
            for name in ("input", "dynamic", "kinematic"):
                counts += [classes[name].start, classes[name].stop - classes[name].start]
        counts += [int(self.polynomial), len(position), len(linear[0]), len(coupling[0])]
        user = None if slots.user_c is None else ctypes.addressof(slots.user_c)
        ask = None if slots.ask is None else ctypes.cast(slots.ask, ctypes.c_void_p)
        return CSpec(
            *counts, ctypes.addressof(table), constant_row, constant_column, constant_mass,
            scale_at, e_scale_at, self.force.ctypes.data, field, self.preload.ctypes.data,
            s_rows, s_columns, d_rows, d_columns, s_values, d_values,
            m_rows, m_columns, moments, c_rows, c_columns, coupled, free, given, x0,
            self.x_motion.ctypes.data, self.e_motion.ctypes.data, user, ask,
        )  # fmt: skip

    def _packed(self, arrays: Sequence[np.ndarray], kind: type) -> list[int]:
        """Addresses of the arrays in one array of this kind, which is kept for C."""
        together: Array = np.concatenate([a.ravel() for a in arrays], dtype=kind, casting="same_kind")
        self._alive.append(together)
        sizes = accumulate((a.size for a in arrays[:-1]), initial=0)
        first, width = together.ctypes.data, together.itemsize
        return [first + width * size for size in sizes]

    def push(self, sigma: Array, force: Array) -> None:
        """Stresses (ne,) on active rows and forces (nx,) besides those of the model."""
        first = self.numbering.e_class["input"].stop
        self.force[:] = self.numbers.force + force[:, None]
        self.preload[first:] = self.numbers.preload[first:] + sigma[first:, None]

    # -- calls; y, out, K are C-contiguous with the cases last ----------------------------------------------------
    def rhs(self, state: State, t: float, y: int, out: int, converged: float) -> int:
        """Time derivative of the state at the address y into out; a negative number when that is not possible.

        Raises what a user function raised.
        """
        status: int = self.engine.rhs(self.handle, state.address, t, y, out, converged, LARGEST_JUMP)
        if status == NOT_ANSWERED:
            self.slots.raise_error()
        return status

    def evaluate(self, state: State, t: float, y: int, converged: float) -> int:
        """Everything that a frame has of the state at the address y, forces too.

        Negative when that is not possible.
        """
        status: int = self.engine.evaluate(self.handle, state.address, t, y, converged, LARGEST_JUMP, 1)
        if status >= 0:
            self.engine.complete(self.handle, state.address, *state.forces_at)
        elif status == NOT_ANSWERED:
            self.slots.raise_error()
        return status

    def stages(
        self, state: State, done: int, n: int, c: int, a: int, t: float, h: float, window: tuple[float, float], y: int,
        K: int, stride: int, converged: float,
    ) -> int:  # fmt: skip
        """Stages of an explicit Runge-Kutta step from `done` to n, rows of K `stride` lanes apart; the first not done.

        c, a, y and K are addresses.
        """
        reached: int = self.engine.stages(
            self.handle, state.address, done, n, c, a, t, h, *window, y, K, stride, converged, LARGEST_JUMP
        )
        if reached < n:
            self.slots.interrupted()
        return reached

    def places(self) -> tuple[Array, Array]:
        """Rows and columns of the entries of V."""
        places = np.zeros((2, self.engine.gradient(self.handle, None, None, None)), np.int32)
        first = places.ctypes.data
        self.engine.gradient(self.handle, first, first + places.nbytes // 2, None)
        return places[0], places[1]

    def gradient(self, out: Array) -> None:
        """Values of the entries of V at the last evaluated state, (n, cases)."""
        self.engine.gradient(self.handle, None, None, out.ctypes.data)

    def determinant(self) -> tuple[Array, Array]:
        """Signs and logarithms of det V[E, U] at the last evaluated state, (cases,) each."""
        self.engine.determinant(self.handle, *self._determinant_at)
        mantissa, exponent = self._determinant  # of the inverse
        return np.sign(mantissa), -(np.log(np.abs(mantissa)) + np.log(2.0) * exponent)

    def rcond(self, rows: int, columns: int) -> float:
        """Smallest reciprocal condition of the cases' rows * V[E, U] * columns at the last evaluated state, 1-norm.

        rows, columns   addresses of the factors
        """
        return float(self.engine.rcond(self.handle, rows, columns))

    def condition(self, mechanism: Mechanism) -> float:
        """Largest condition of the cases' V[E, U] in the sizes of the mechanism at the last evaluated state, 1-norm."""
        n = self.numbering
        rows, columns = 1.0 / mechanism.deformation_scale[n.velocity_equations], mechanism.scale[n.velocity_unknowns]
        rcond = self.rcond(rows.ctypes.data, columns.ctypes.data) if len(rows) else 1.0
        return 1.0 / rcond if rcond > 0.0 else float("inf")

    def in_range(self, state: State) -> bool:
        """Whether all elements are surely in the range of their theory at a state."""
        return not self.slots.has_limits and bool(self.engine.guard(self.handle, state.x_address) > GUARD)

    def mass_diagonal(self) -> Array:
        """Diagonal of M at the last evaluated state, (nx, cases)."""
        out = np.zeros((self.numbering.nx, self.cases))
        self.engine.mass_diagonal(self.handle, out.ctypes.data)
        return out

    def reduced_mass(self) -> Array | None:
        """Of the degrees of freedom at the last evaluated state, (nddof, nddof, cases)."""
        n = self.numbering.nddof
        out = np.zeros((n, n, self.cases))
        return out if self.engine.reduced_mass(self.handle, out.ctypes.data) else None
