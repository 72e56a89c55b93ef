"""Modes 4, 7, 8, 9, 10 as streams of frames."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from spacar.dynamics.analysis import at_time, states
from spacar.dynamics.dynamics import Dynamics
from spacar.dynamics.limits import Limits
from spacar.frame import Frame
from spacar.kinematics.output import TransferOutput
from spacar.linear.buckling import buckling_modes, directional_compliances
from spacar.linear.eigen import vibration_modes
from spacar.linear.matrices import Linearization, linearize
from spacar.linear.signals import linearization_signals
from spacar.linear.state_space import Signal, chosen_rows, state_space
from spacar.mechanism.mechanism import Array
from spacar.modes import Run
from spacar.stationary import StationarySolver, load_program


def forward(run: Run) -> Iterator[Frame]:
    """Mode 4: forward dynamics, linearized at every output step."""
    output = TransferOutput(run)
    inputs, outputs = _announce(run)
    limits: Limits | None = None
    for dynamics, t, y, statistics in states(run):
        limits = limits or Limits(dynamics, run.report)
        frame = at_time(dynamics, t, y)
        limits.check(dynamics, frame)
        frame.statistics = statistics
        L = linearize(dynamics, frame.xdd, frame.sig, t=t)
        _store_matrices(frame, L, dynamics)
        _store_state_space(frame, L, dynamics, inputs, outputs)
        yield output.add(frame, dynamics.kinematics)


def eigenvalues(run: Run) -> Iterator[Frame]:
    """Mode 7: stationary solution, eigenvalues and eigenvectors."""
    for frame, L, dynamics in stationary(run):
        _store_vibration(run, frame, L, dynamics)
        yield frame


def buckling(run: Run) -> Iterator[Frame]:
    """Mode 8: stationary solution, load multipliers, buckling modes, directional compliances."""
    for frame, L, dynamics in stationary(run):
        _store_buckling(run, frame, L, dynamics)
        yield frame


def vibration_and_buckling(run: Run) -> Iterator[Frame]:
    """Mode 10: modes 7 and 8 at every stored load step."""
    for frame, L, dynamics in stationary(run):
        _store_vibration(run, frame, L, dynamics)
        _store_buckling(run, frame, L, dynamics)
        yield frame


def state_space_matrices(run: Run) -> Iterator[Frame]:
    """Mode 9: stationary solution, state space matrices."""
    inputs, outputs = _announce(run)
    for frame, L, dynamics in stationary(run):
        _store_state_space(frame, L, dynamics, inputs, outputs)
        yield frame


def stationary(run: Run) -> Iterator[tuple[Frame, Linearization, Dynamics]]:
    """The stored stationary solutions with their linearization."""
    mechanism, settings = run.mechanism, run.mechanism.settings
    output = TransferOutput(run)
    program = load_program(settings)
    run.n_frames = sum(level.store for level in program)
    solver = StationarySolver(mechanism, run.report)
    limits: Limits | None = None
    stored = 0
    for level in program:
        solver.solve(level)
        if "condition" not in run.header:
            run.header["condition"] = solver.dynamics.kinematics.condition()
        if not level.store:
            continue
        dynamics = solver.dynamics
        limits = limits or Limits(dynamics, run.report)
        convected = dynamics.forces.inertia(dynamics.sweep, dynamics.xd)
        stress = _stored_stress(dynamics, solver)
        frame = dynamics.complete(float(stored), solver.xdd, stress, solver.convective, convected)
        limits.check(dynamics, frame)
        frame.statistics = {"iterations": solver.iterations, "residual": solver.history[-1]}
        L = linearize(dynamics, solver.xdd, solver.sigma)
        _store_matrices(frame, L, dynamics)
        stored += 1
        yield output.add(frame, dynamics.kinematics), L, dynamics


def _stored_stress(dynamics: Dynamics, solver: StationarySolver) -> Array:
    """Constitutive values for the free rows, multipliers for fixed and prescribed ones."""
    sigma = solver.sigma.copy()
    constrained = dynamics.numbering.e_class["input"].stop
    sigma[:constrained] = solver.full_sigma[:constrained]
    return sigma


def _store_matrices(frame: Frame, L: Linearization, dynamics: Dynamics) -> None:
    q, s = chosen_rows(L, dynamics)
    if not len(q):
        return
    for name in ("m0", "c0", "d0"):
        frame.matrices[name] = getattr(L, name)[np.ix_(q, q)]
    for name in ("k0", "n0", "g0"):
        frame.matrices[name] = getattr(L, name)[np.ix_(q, s)]
    frame.matrices["ak0"] = L.ak0[np.ix_(s, q)]
    frame.matrices["bk0"] = L.bk0[np.ix_(s, s)]


def _store_vibration(run: Run, frame: Frame, L: Linearization, dynamics: Dynamics) -> None:
    q, s = chosen_rows(L, dynamics)
    if not len(q):
        run.report.add("no dynamic degrees of freedom: there are no eigenvalues")
        return
    modes = vibration_modes(L, q, s)
    frame.matrices["eigval"] = np.column_stack((modes.values.real, modes.values.imag))
    frame.matrices["eigvre"], frame.matrices["eigvim"] = modes.vectors.real, modes.vectors.imag


def _store_buckling(run: Run, frame: Frame, L: Linearization, dynamics: Dynamics) -> None:
    q, _ = chosen_rows(L, dynamics)
    frame.xcompl = directional_compliances(L, q, run.report)
    if not len(q):
        run.report.add("no dynamic degrees of freedom: there are no load multipliers")
        return
    modes = buckling_modes(L.k0[np.ix_(q, q)], L.g0[np.ix_(q, q)], run.report)
    frame.matrices["lmult"], frame.matrices["bmode"] = modes.multipliers, modes.modes


def _announce(run: Run) -> tuple[list[Signal], list[Signal]]:
    """Signals of the third block, and the header of the ltv file."""
    inputs, outputs = linearization_signals(run.mechanism)
    n = run.mechanism.numbering
    run.header.update(NNOM=len(inputs), NX=n.nkddof + n.nddof, NU=len(inputs), NY=len(outputs), NRBM=n.nddof)
    run.header.update(X0=np.zeros(n.nkddof + n.nddof))
    run.header.update(inputs=[s.name for s in inputs], outputs=[s.name for s in outputs])
    return inputs, outputs


def _store_state_space(
    frame: Frame, L: Linearization, dynamics: Dynamics, inputs: list[Signal], outputs: list[Signal]
) -> None:
    ss = state_space(dynamics, L, inputs, outputs)
    q, s = chosen_rows(L, dynamics)
    if inputs and len(q):
        n = dynamics.numbering
        frame.matrices["b0"] = (L.m0[np.ix_(q, q)] @ ss.B[len(s) :]).reshape(n.nddof, len(inputs))
    store = frame.state_space
    store["A"], store["B"], store["C"] = ss.A, ss.B, ss.C
    if ss.feedthrough:
        store["D"] = ss.D
    if len(q):
        store["m0"], store["c0b"], store["k0b"] = L.m0[np.ix_(q, q)], L.damping[np.ix_(q, q)], L.stiffness[np.ix_(q, s)]
