"""Memory and calls of the solver in C: a model of the numbers of some cases, and the states that it evaluates."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.compiled.interface import constants, structure
from spacar.compiled.library import WIDTH, address_of, engine, level, why_off
from spacar.compiled.numbers import Numbers, without_form
from spacar.compiled.user_callbacks import UserCallbacks
from spacar.dynamics.loaded_mechanism import Moving
from spacar.elements.family import GUARD
from spacar.kinematics.constraint_matrices import ROUNDING, Entries
from spacar.kinematics.kinematics import CONVERGED, FARTHEST_GUESS, GROWN, LARGEST_JUMP, MAX_ITERATIONS
from spacar.mechanism.mechanism import Drive, Mechanism, UserSignal
from spacar.mechanism.numbering import Numbering
from spacar.stream import Run


def why_general(mechanism: Mechanism) -> str | None:
    """Why a run of this mechanism takes the general path, or None: then it is compiled."""
    if not mechanism.settings.compiled:
        return "--general or compiled=False asks for it"
    return why_off()


def is_compiled(run: Run) -> bool:
    """Whether a run takes the engine; the header says which, and why."""
    reason = why_general(run.mechanism)
    run.header["engine"] = ("compiled", level()) if reason is None else ("general", reason)
    return reason is None


def why_not_in_lanes(mechanism: Mechanism) -> str | None:
    """Why several cases of this mechanism cannot be evaluated at a time, or None."""
    missing = without_form(mechanism)
    return f"{', '.join(missing)}: without functions in C" if missing else None


# Largest scaled correction that ends the iteration of a stored position: one more follows the first that is below
# CONVERGED, so that velocities and accelerations are those of the position to rounding.
EXACT = 1e-15
CRITERIA = np.array([CONVERGED, ROUNDING, GROWN])
PLACED = 2  # `known` of a state that was placed with its accelerations: transfer functions are not its own
FAR_AWAY, DOUBTFUL_MASS, NOT_ANSWERED = constants("FAR_AWAY", "DOUBTFUL_MASS", "NOT_ANSWERED")


class State:
    """The last evaluated state, shared with C: x, xd, xdd (nx, cases), e, ed, edd, sigma, given_e (ne, cases).

    Behind xdd there are applied, gravity and total forces (nx, cases), behind given_e is the y that all belongs to, as
    `evaluate` gives them. It begins at the reference configuration of the model.
    """

    def __init__(self, model: CompiledModel) -> None:
        n, cases = model.numbering, model.cases
        self._sizes = nx, ne = n.nx, n.ne
        self._together = np.empty((6 * nx + 5 * ne + 2 * n.nddof + n.nk, cases))
        self.of_x = self._together[: 6 * nx].reshape(6, nx, cases)
        self.of_e = self._together[6 * nx : 6 * nx + 5 * ne].reshape(5, ne, cases)
        self.x, self.xd, self.xdd = self.of_x[:3]
        self.e, self.ed, self.edd, self.sigma, self.given_e = self.of_e
        self.x_address = address_of(self._together)
        self.c = structure("State")()
        self.address = ctypes.addressof(self.c)
        model.engine.state(model.handle, self.address, self.x_address)

    @property
    def together(self) -> Array:
        """Everything of the only case, (n,): x, xd, xdd, three forces (nx), e, ed, edd, sigma, given_e (ne), y."""
        return self._together[:, 0]

    def of_one(self) -> tuple[Array, Array]:
        """Copies of x, xd, xdd and the forces (6, nx), of e, ed, edd and sigma (4, ne) of the only case."""
        kept, (nx, ne) = self._together[:, 0].copy(), self._sizes
        return kept[: 6 * nx].reshape(6, nx), kept[6 * nx : 6 * nx + 4 * ne].reshape(4, ne)

    def begin(self, x: Array, e: Array) -> None:
        """Positions and deformations that the next guess starts from."""
        self.x[:], self.e[:] = x, e
        self.c.known = self.c.whole = 0

    def moving(self) -> Moving:
        """The last evaluated state: x, xd, xdd (nx, cases), e (ne, cases)."""
        x, xd, xdd = self.of_x[:3].copy()
        return Moving(float(self.c.t), x, xd, xdd, self.e.copy())

    def resume(self, at: Moving) -> None:
        """That state, or that of the only case without the last axis, is the last evaluated one again."""
        for own, values in zip((self.x, self.xd, self.xdd, self.e), (at.x, at.xd, at.xdd, at.e), strict=True):
            own.T[:] = values.T
        self.c.t, self.c.known, self.c.whole = at.t, PLACED, 0

    def follow(self, other: State) -> None:
        """Stand where another state of the same model stands, with everything that has been evaluated there."""
        self._together[:] = other._together
        c, of = self.c, other.c
        c.t, c.known, c.whole = of.t, of.known and PLACED, of.whole


class CompiledModel:
    """One `Model` of model.c. `scales` (nx,), (ne,): sizes of what is in x and e. `slots`: what Python answers,
    with the `drives` and `users` of all cases.

    All that C reads lies in two arrays, in the order of `read_spec` of model.c: whole numbers, and numbers of the
    cases with the sizes behind them. Of these force (nx, cases), preload (ne, cases) and the motions that are no
    polynomials may change later, and all of them, with the reference configurations x0 (nx, cases), at once (`renew`).
    """

    def __init__(
        self, numbering: Numbering, numbers: Numbers, scales: tuple[Array, Array], drives: Sequence[Drive],
        users: Sequence[UserSignal] = (),
    ) -> None:  # fmt: skip
        self.numbering = n = numbering
        self.numbers = numbers
        self.cases = cases = numbers.x0.shape[-1]
        self.engine = engine(cases)
        self._values = np.concatenate([a.ravel() for a in (*numbers.arrays(), *scales, CRITERIA)])
        x_end = 3 * cases * len(numbers.x_motion)
        e_end = x_end + 3 * cases * len(numbers.e_motion)
        motions = self._values[:x_end].reshape(-1, 3, cases), self._values[x_end:e_end].reshape(-1, 3, cases)
        rows = self._values[e_end : e_end + (2 * n.nx + n.ne) * cases].reshape(-1, cases)
        self.force, self.preload, self.x0 = np.split(rows, (n.nx, n.nx + n.ne))
        self.slots = slots = UserCallbacks(numbers.elements, drives, motions, users, (n.nx, n.ne, cases))
        self._called = slots.asking.calls(slots.answer) if slots.asking else ()  # C calls it
        self._whole = self._whole_numbers()
        handle: int | None = self.engine.begin(
            address_of(self._whole), address_of(self._values), _at(slots.foreign_c), _at(slots.user_c),
            _at(slots.asking.c if slots.asking else None),
        )  # fmt: skip
        if not handle:
            raise MemoryError("no memory for the compiled model")
        self.handle, self._owner = handle, self.engine.owner(handle)

    def _whole_numbers(self) -> NDArray[np.int32]:
        """Counts and lists, as `read_spec` of model.c reads them."""
        n, numbers = self.numbering, self.numbers
        position, xs, es = n.position_equations, n.x_class, n.e_class
        given = [of[name] for of in (xs, es) for name in ("input", "dynamic", "kinematic")]
        counts = [
            n.nx, n.ne, xs["calculable"].start, es["input"].stop, es["dynamic"].stop, len(numbers.elements),
            len(numbers.stiffness[0]), len(numbers.damping[0]), n.nddof == 0, len(numbers.mass[0]),
            *(number for part in given for number in (part.start, part.stop - part.start)),
            self.slots.polynomial, len(position), len(numbers.moments[0]), len(numbers.coupling[0]), MAX_ITERATIONS,
        ]  # fmt: skip
        lists = [position, n.translations]
        for rows, columns, _ in numbers.entries:
            if len(rows):
                lists += rows, columns
        for b in numbers.elements:
            size, n_x = b.x.shape
            counts += b.kind, size, n_x, b.e.shape[1], b.parameters.shape[1], b.moving
            lists += b.x.T.ravel(), b.e.T.ravel()
        return np.concatenate([np.array(counts), *lists], dtype=np.int32)

    def renew(self, values: Array, *states: State) -> None:
        """Other cases: their numbers in the order of `Numbers.arrays`, (n, cases). `states` begin at their reference
        configurations. Orders of pivots are those of the first call. Not where Python answers what a case asks."""
        np.copyto(self._values[: values.size].reshape(values.shape), values)
        self.engine.renew(self.handle)
        for state in states:
            self.engine.state(self.handle, state.address, state.x_address)

    def push(self, sigma: Array, force: Array) -> None:
        """Stresses (ne,) on active rows and forces (nx,) besides those of the model; no NumPy evaluator is told."""
        first = self.numbering.e_class["input"].stop
        np.add(self.numbers.force, force[:, None], self.force)
        np.add(self.numbers.preload[first:], sigma[first:, None], self.preload[first:])
        self.engine.forget(self.handle)

    # -- calls; y, out, K are C-contiguous with the cases last. Raise what a user function raised ------------------
    def rhs(self, state: State, t: float, y: int, out: int, converged: float) -> int:
        """Time derivative of the state at the address y into out; a negative number where that is not possible."""
        return self._answered(self.engine.rhs(self.handle, state.address, t, y, out, converged, LARGEST_JUMP))

    def start(self, state: State, y: int, out: int, checked: bool) -> int:
        """Evaluate the start state at the address y from the configuration of `state`, its time derivative into out.

        Negative when that is not possible, FAR_AWAY where the path there has to be followed, DOUBTFUL_MASS when the
        mass matrix is `checked` and has to be looked at closely.
        """
        return self._answered(
            self.engine.start(self.handle, state.address, y, out, EXACT, LARGEST_JUMP, FARTHEST_GUESS, checked)
        )

    def evaluate(self, state: State, t: float, y: int, converged: float) -> int:
        """Everything that a frame has of the state at the address y, forces too; negative where it is not possible."""
        return self._answered(self.engine.evaluate(self.handle, state.address, t, y, converged, LARGEST_JUMP))

    def _answered(self, status: int) -> int:
        """The status of a call. Raises what a user function raised in it."""
        if status == NOT_ANSWERED:
            self.slots.raise_error()
        return status

    def gradient(self) -> Entries:
        """The n entries of V at the last evaluated state: rows (n,), columns (n,), values (n, cases)."""
        most = sum([b.e.size * b.x.shape[1] for b in self.numbers.elements])
        memory = np.empty(most * (self.cases + 1))
        first = address_of(memory)
        places = first + WIDTH * most * self.cases
        n = self.engine.gradient(self.handle, places, places + WIDTH * most // 2, first)
        rows = memory[most * self.cases :].view(np.int32)
        return rows[:n], rows[most : most + n], memory[: n * self.cases].reshape(n, self.cases)

    def determinant(self) -> tuple[Array, Array]:
        """Signs and logarithms of det V[E, U] at the last evaluated state, (cases,) each."""
        mantissa, exponent = of_inverse = np.zeros((2, self.cases))
        first = address_of(of_inverse)
        self.engine.determinant(self.handle, first, first + WIDTH * self.cases)
        return np.sign(mantissa), -(np.log(np.abs(mantissa)) + np.log(2.0) * exponent)

    def rcond(self, enough: float = np.inf, most: int = 2**31 - 1) -> float:
        """Smallest reciprocal condition of the cases' scaled V[E, U] at the last evaluated state, 1-norm.

        A bound from below, for the price of a solution, where that is more than `enough`; else itself, for as many
        solutions as there are unknowns, or 0 when these are more than `most`.
        """
        return float(self.engine.rcond(self.handle, enough, most))

    def too_large(self) -> bool:
        """Do factors at the reference configuration take longer than those of SuperLU?"""
        return bool(self.engine.too_large(self.handle))

    def rcond_everywhere(self) -> float:
        """A bound from below for `rcond` at all states, where the engine knows one (rigid trees); else 0."""
        return float(self.engine.rcond_everywhere(self.handle))

    def in_range(self, state: State) -> bool:
        """Whether all elements are surely in the range of their theory at a state."""
        return not self.slots.has_limits and bool(self.engine.guard(self.handle, state.x_address) > GUARD)

    def reduced_mass(self) -> Array | None:
        """Of the degrees of freedom at the last evaluated state, (nddof, nddof, cases)."""
        n = self.numbering.nddof
        out = np.zeros((n, n, self.cases))
        return out if self.engine.reduced_mass(self.handle, address_of(out)) else None


def _at(shared: ctypes.Structure | ctypes.Array[Any] | None) -> int | None:
    return None if shared is None else ctypes.addressof(shared)
