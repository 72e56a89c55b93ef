"""Modes 4, 7, 8, 9, 10 as streams of frames."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from spacar.arrays import EPS
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.limits import Limits
from spacar.dynamics.mass_check import linearized_doubt, require_regular_mass
from spacar.dynamics.saddle_point import SaddlePoint
from spacar.errors import AnalysisError
from spacar.forward.motion import motion
from spacar.frame import Frame
from spacar.kinematics.constraint_condition import condition_number
from spacar.kinematics.transfer import Transfer, TransferOutput
from spacar.linear import form
from spacar.linear.buckling import (
    NO_STRESS,
    BucklingModes,
    buckling_modes,
    directional_compliances,
    factored_in_motion,
    sparse_compliances,
)
from spacar.linear.eigen import Modes, vibration_modes
from spacar.linear.internal_unknowns import buckling_matrices
from spacar.linear.lowest import WANTED, lowest_modes, lowest_vibration
from spacar.linear.lowest_multipliers import lowest_buckling
from spacar.linear.steady_equations import require_steady
from spacar.linear.stored_system import StoredSystem, sparse_matrices
from spacar.linear_systems import SingularMatrixError
from spacar.linearization.coefficients import Coefficients, coefficients
from spacar.linearization.matrices import Linearization, chosen_rows, linearize, selected
from spacar.linearization.sparse_linearization import SparseLinearization
from spacar.stationary import LoadLevel, LoadProgram, StationarySolver
from spacar.stationary.tangent import STATIC, SparseTangent
from spacar.stream import Run

MASS_AND_DAMPING, STIFFNESS = ("m0", "c0", "d0"), ("k0", "n0", "g0")
LOST = 1e-6  # chosen: relative error of the matrices above which there is a warning


def forward(run: Run) -> Iterator[Sequence[Frame]]:
    """Mode 4: forward dynamics, linearized at every output step."""
    output = TransferOutput(run)
    store = StoredSystem(run, may_move=True)
    for evaluator, (frame,) in motion(run):
        dynamics = evaluator.numpy_evaluator()
        if store.sparse:
            store.add_sparse(frame, dynamics, frame.xdd, frame.sig, frame.t)
            yield (frame,)
            continue
        L = linearize(dynamics, frame.xdd, frame.sig, t=frame.t)
        _store_matrices(frame, L, dynamics)
        store.add(frame, L, dynamics)
        yield (output.add(frame, dynamics.kinematics, L.transfer),)
    run.report.lines.extend(store.idle.lines())


def vibration_and_buckling(run: Run) -> Iterator[Sequence[Frame]]:
    """Modes 7, 8, 10: stationary solutions with eigenvalues and eigenvectors; with load multipliers, buckling modes and
    directional compliances; with both."""
    vibration, buckling = run.mode.linearized, run.mode.buckling
    for solution in stationary(run):
        if vibration:
            _say_doubtful_inertia(run, solution)
        if buckling:
            _store_compliances(run, solution)  # first, by the factors of Newton's iteration
        if vibration:
            _store_vibration(run, solution)
        if buckling:
            _store_buckling(run, solution, required=not vibration)
        _store_tangent(solution)
        yield (solution.frame,)


def state_space_matrices(run: Run) -> Iterator[Sequence[Frame]]:
    """Mode 9: stationary solution, state space matrices."""
    n = run.mechanism.numbering
    store = StoredSystem(run, may_move=bool(n.nk or len(n.rheonomic)))
    for solution in stationary(run, store=store):
        if solution.L is not None:
            _say_doubtful_inertia(run, solution)
            store.add(solution.frame, solution.L, solution.dynamics)
        yield (solution.frame,)
    run.report.lines.extend(store.idle.lines())


class LinearizedSolution(NamedTuple):
    """A stored stationary solution with its linearization L, for large systems the sparse tangent instead, and their
    coefficients `sparse` where it does not hold all of the equations, the `solver` where not all of the stiffness.

    `wanted`: number of lowest modes; `reduced`: no dense matrices at any step of the run.
    """

    frame: Frame
    dynamics: Dynamics
    L: Linearization | None
    tangent: SparseTangent | None
    wanted: int
    reduced: bool
    sparse: Coefficients | None = None
    solver: StationarySolver | None = None


def stationary(
    run: Run, store: StoredSystem | None = None, sparse_in_motion: bool = True
) -> Iterator[LinearizedSolution]:
    """The stored stationary solutions, in the form that `spacar.linear.form` decides. A `store` in sparse form makes
    the linearizations itself. `sparse_in_motion`: large models that move or have user functions by coefficients."""
    from spacar.compiled.compiled_elements import mechanism_of

    mechanism, settings = mechanism_of(run), run.mechanism.settings
    n = mechanism.numbering
    run.n_frames = settings.stored_levels
    solver = StationarySolver(mechanism, run.report)
    descriptor = store is not None and store.sparse
    wanted = settings.modes or n.nddof
    large = store is None and form.stores_sparse(n.nddof, settings, settings.modes or 0)
    moving = sparse_in_motion and large and not solver.sparse and not len(n.twist_rates)
    moving = moving and (n.holonomic or run.mode.number == 7)
    reduced = large and (solver.sparse or moving)
    if reduced:
        wanted = settings.modes or WANTED
        what = " and their motions" if moving else ", their motions and sparse matrices"
        run.report.add(
            f"{n.nddof} dynamic degrees of freedom (more than {form.LARGE}): only the {wanted} lowest modes{what} are"
            " computed, no reduced matrices and no transfer functions; --modes N or MODES N changes the number, 0 asks"
            " for everything"
        )
    output = TransferOutput(run)
    limits: Limits | None = None
    for stored, (level, iterations) in enumerate(solver.stored(LoadProgram(settings))):
        dynamics, state = solver.dynamics, solver.solution
        if "condition" not in run.header:
            run.header["condition"] = condition_number(dynamics.kinematics)
            say_lost_digits(run, reduced or descriptor)
        limits = limits or Limits(dynamics, run.report)
        frame = solver.frame(stored)
        limits.check_elements(dynamics, frame)
        singular = _is_dead_point(run, solver, level, frame.t, store is None)
        frame.statistics = {"iterations": iterations, "residual": solver.residual}
        tangent = L = linear = None
        if reduced or singular or (descriptor and solver.sparse):
            tangent = solver.sparse_tangent()
            tangent.sigma = state.sigma
        if store is not None and descriptor:
            if tangent is not None:
                frame.matrices.update(sparse_matrices(tangent))
            modes = _sparse_vibration(run, tangent, wanted) if tangent is not None and store.wanted else None
            store.add_sparse(frame, dynamics, state.xdd, state.sigma, 0.0, modes)
        elif moving:
            linear = coefficients(dynamics, state.xdd, state.sigma)
        elif tangent is not None:
            tangent.last_step = stored + 1 == settings.stored_levels
            if not reduced:
                _store_matrices(frame, None, dynamics)
                sizes = [(rows, columns) for columns in (n.ndof, n.nkdof) for rows in (n.nx, n.ne)]
                frame = output.add(frame, dynamics.kinematics, Transfer(*(np.full(size, np.nan) for size in sizes)))
        else:
            L = linearize(dynamics, state.xdd, state.sigma)
            if solver.moving and n.holonomic:
                require_steady(L, dynamics, solver.y, level, run.report)
            _store_matrices(frame, L, dynamics)
            frame = output.add(frame, dynamics.kinematics, L.transfer)
        of_stiffness = solver if moving and not solver.resting else None
        yield LinearizedSolution(frame, dynamics, L, tangent, wanted, reduced, linear, of_stiffness)
    if reduced and not moving:
        run.report.add(f"storage of the sparse tangent: {solver.sparse_tangent().storage}")


def say_lost_digits(run: Run, reduced: bool) -> None:
    """Warn when the condition number costs digits of the reduced matrices.

    W^T M W and the other reduced matrices have entries up to cond^2 times their smallest eigenvalues, so that a part of
    eps cond^2 of these may be rounding. The sparse pencil, which keeps all coordinates, does not lose these digits.
    """
    condition = run.header["condition"]
    lost = EPS * condition**2
    if lost > LOST and np.isfinite(condition) and not reduced:
        run.report.add(
            f"warning: the degrees of freedom hardly determine the configuration (condition number {condition:.2g}): up"
            f" to {min(lost, 1.0):.1g} of the linearized equations may be rounding; choose other degrees of freedom"
            " (`spacar 0`)"
        )


def _say_doubtful_inertia(run: Run, solution: LinearizedSolution) -> None:
    """At the first step: warn of motions whose inertia is rounding of the reduced mass matrix that modes come from."""
    L, dynamic = solution.L, run.mechanism.numbering.dynamic
    if L is None or not len(dynamic) or solution.frame.t:
        return
    M = selected(L.m0, dynamic, dynamic)
    masses = L.c.M.diagonal()
    doubt = linearized_doubt(run.mechanism, lambda: solution.dynamics.sweep, masses, M, run.header["condition"])
    if doubt:
        run.report.add(f"warning: {doubt}")


def _is_dead_point(run: Run, solver: StationarySolver, level: LoadLevel, t: float, reducible: bool) -> bool:
    """Do the degrees of freedom fail to determine the configuration here? Eigenvalues, multipliers and compliances
    do not depend on them and are computed all the same. Raises AnalysisError where the sparse tangent does not apply.
    """
    matrix = solver.dynamics.position_matrix()
    if not len(matrix.columns) or (solver.determined and matrix.rcond() > matrix.zero):
        return False
    if not (reducible and solver.sparse):
        matrix.check(t)
        return False  # doubtful but not singular; the warning was given where the state was found
    run.report.add(
        f"warning: at {level} the degrees of freedom do not determine the motion of {matrix.undetermined()} (a dead"
        " point): matrices and transfer functions are nan in this step; choose other degrees of freedom to have them"
    )
    return True


def _store_matrices(frame: Frame, L: Linearization | None, dynamics: Dynamics) -> None:
    """Of no L: nan. And sentences about derivatives that a user function states, in `lost`, where rows of e are not
    negative."""
    if L is not None and L.c.user:
        frame.lost = frame.lost | {-1 - i: sentence for i, sentence in enumerate(L.c.user.doubts)}
    q, s = chosen_rows(dynamics.numbering)
    if not len(q):
        return
    for names, rows, columns in (MASS_AND_DAMPING, q, q), (STIFFNESS, q, s), (("ak0",), s, q), (("bk0",), s, s):
        for name in names:
            nothing = np.full((len(rows), len(columns)), np.nan)
            frame.matrices[name] = nothing if L is None else selected(getattr(L, name), rows, columns)


def _store_tangent(solution: LinearizedSolution) -> None:
    """What takes the place of the reduced matrices of a large model, last: it is as large as the factors."""
    if solution.reduced and solution.tangent is not None and solution.sparse is None:
        if solution.tangent.last_step:
            solution.tangent.forget_factors()
        solution.frame.matrices.update(sparse_matrices(solution.tangent))


def _store_vibration(run: Run, solution: LinearizedSolution) -> None:
    n = run.mechanism.numbering
    if not n.nddof:
        run.report.add("no dynamic degrees of freedom: there are no eigenvalues")
        return
    if solution.sparse is not None:
        system = SparseLinearization(solution.dynamics, (), ())(solution.sparse)
        modes = lowest_modes(system, n.nkddof, n.nx, run.report, min(solution.wanted, n.nddof))
    elif solution.tangent is not None:
        modes = _sparse_vibration(run, solution.tangent, solution.wanted)
    else:
        assert solution.L is not None
        try:
            modes = vibration_modes(solution.L, *chosen_rows(n), run.report, n.twist_rates, solution.wanted)
        except AnalysisError as error:
            if error.code == "dynamics.singular-mass":  # who carries no mass, by name
                saddle = SaddlePoint(run.mechanism, solution.dynamics.sweep)
                require_regular_mass(run.mechanism, saddle, run.header["condition"])
            raise
    if not solution.reduced and solution.wanted < n.nddof:
        modes = modes.lowest(solution.wanted)
    solution.frame.matrices.update(modes.stored(solution.reduced))


def _sparse_vibration(run: Run, tangent: SparseTangent, wanted: int) -> Modes:
    n = run.mechanism.numbering
    wanted = min(wanted, n.nddof)
    try:
        return lowest_vibration(tangent, run.report, wanted)
    except SingularMatrixError as error:
        text = "no frequencies, they are stored as nan: stiffness and mass together are singular in this configuration"
        run.report.add(f"warning: {text} ({error})")
        unknown = complex(np.nan, np.nan)
        vectors, motions = np.full((2 * n.nddof, 2 * wanted), unknown), np.full((n.nx, 2 * wanted), unknown)
        return Modes(np.full(2 * wanted, unknown), vectors, n.nddof, motions)


def _store_compliances(run: Run, solution: LinearizedSolution) -> None:
    frame, numbering, tangent = solution.frame, run.mechanism.numbering, solution.tangent
    if solution.solver is not None:
        frame.xcompl = sparse_compliances(solution.dynamics, partial(factored_in_motion, solution.solver))
    elif tangent is not None and numbering.nddof:
        frame.xcompl = sparse_compliances(solution.dynamics, partial(tangent.factor, STATIC))
    elif solution.L is not None:
        frame.xcompl = directional_compliances(solution.L, numbering.dynamic, run.report)
    else:
        frame.xcompl = np.zeros(numbering.nx)


def _store_buckling(run: Run, solution: LinearizedSolution, required: bool) -> None:
    """Load multipliers and modes. Where there are no multipliers: AnalysisError if they are `required`, else they are
    nan, with a warning.
    """
    frame, dynamic = solution.frame, run.mechanism.numbering.dynamic
    if not len(dynamic):
        run.report.add("no dynamic degrees of freedom: there are no load multipliers")
        return
    tangent, L, n = solution.tangent, solution.L, min(solution.wanted, len(dynamic))
    try:
        if tangent is not None:
            c = None if solution.solver is None else solution.sparse
            modes = lowest_buckling(tangent, run.report, solution.wanted, c)
            if not len(modes.multipliers):
                run.report.add(NO_STRESS)
        else:
            assert L is not None
            matrices = buckling_matrices(solution.dynamics, L, dynamic)
            modes = buckling_modes(*matrices, run.report).first(len(dynamic))
    except AnalysisError as error:
        if required:
            raise
        run.report.add(f"warning: no load multipliers, they are stored as nan: {error}")
        modes = BucklingModes(np.full(n, np.nan), np.full((len(dynamic), n), np.nan))
    modes = modes.filled(n)
    frame.matrices["lmult"], frame.matrices["bmode"] = modes.multipliers[:n], modes.modes[:, :n]
    if solution.reduced:  # nan where there are no modes
        nothing = np.full((run.mechanism.numbering.nx, n), np.nan)
        frame.matrices["bmodex"] = nothing if modes.motions is None else modes.motions
