"""The perturbation method for flexible beams on a prescribed motion (theory-system.md 7.4).

The nominal motion is that of the rigid mechanism: all dynamic deformations zero, the prescribed motion as given. With
y = (q, dq/dt) of the dynamic deformations, F the right-hand side and J = dF/dy at the nominal state,

    dy/dt = F(t, 0) + J(t) y,

sampled on an even grid and solved with the exponential integrator of spacar.simulation, so that fast vibrations do not
limit the step. Positions and velocities follow from the nonlinear kinematics at q; stored stresses, accelerations and
reactions are those of the equations of motion at that state. The error is of the order of the squared deformations, and
of the squared grid step.
"""

from typing import Any

import numpy as np

from spacar.deck import Deck
from spacar.deck.rewrite.divide import BEAMS
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.limits import Limits
from spacar.errors import Report, UsageError
from spacar.forward.driver import checked
from spacar.linearization.matrices import chosen_rows, linearize, state_matrix
from spacar.mechanism import Mechanism, build
from spacar.result import Result


def require_perturbation(deck: Deck, **options: Any) -> Mechanism:
    """The mechanism. Raises UsageError where the method does not apply."""
    mechanism = build(deck, 1, **options)
    n = mechanism.numbering
    dynamic = range(n.e_class["dynamic"].start, n.e_class["dynamic"].stop)
    elsewhere = sorted({n.e_owner(i)[0] for i in dynamic if n.keyword[n.e_owner(i)[0]] not in BEAMS})
    reason = ""
    if not n.holonomic or n.nk:
        reason = "the model has wheels"
    elif int(n.nxp[3]) or elsewhere or not len(dynamic):
        what = f"element {elsewhere[0]}" if elsewhere else "coordinates (DYNX)" if n.nxp[3] else "nothing"
        reason = f"only deformations of beams may be dynamic, here {what}"
    elif not len(n.rheonomic):
        reason = "there is no prescribed motion"
    elif mechanism.settings.duration is None or mechanism.settings.n_steps < 1:
        reason = "there is no TIMESTEP"
    if reason:
        raise UsageError(f"the perturbation method does not apply to {deck.source}: {reason}", "study.perturbation")
    return mechanism


def perturbation(deck: Deck, substeps: int = 1, **options: Any) -> Result:
    """Mode 1 by the perturbation method, with `substeps` grid steps in an output step; options as `spacar.run`.

    Raises UsageError where the method does not apply, AnalysisError when the nominal motion cannot be computed, or when
    a beam is bent beyond the range of its theory.
    """
    from spacar.simulation.propagation import simulate_ltv
    from spacar.simulation.time_varying import TimeVarying

    mechanism = require_perturbation(deck, **options)
    settings = mechanism.settings
    dynamics = Dynamics(mechanism)
    z0 = dynamics.start()
    assert settings.duration is not None
    t = np.linspace(0.0, settings.duration, settings.n_steps * substeps + 1)
    rest = np.zeros(len(z0))
    A, F = np.empty((len(t), len(z0), len(z0))), np.empty((len(t), len(z0), 1))
    dynamics.kinematics.move(*dynamics.given(dynamics.drive.at(0.0), rest))
    for k, time in enumerate(t):
        F[k, :, 0] = dynamics.rhs(time, rest)
        found = dynamics.accelerate(time, dynamics.place(time, rest))
        L = linearize(dynamics, found.xdd, found.sigma, t=time)
        A[k] = state_matrix(L, *chosen_rows(dynamics.numbering))
    data = TimeVarying(deck.source, t, A=A, B=F, C=np.zeros((len(t), 0, len(z0))))
    z = simulate_ltv(data, np.ones((len(t), 1)), z0=z0).z
    shown = Dynamics(mechanism)
    shown.start()
    report = Report()
    if shown.doubt:
        report.add(f"warning: {shown.doubt}")
    limits = Limits(shown, report)
    frames = tuple(checked(shown, float(t[k]), z[k], limits) for k in range(0, len(t), substeps))
    return Result(mechanism, 1, frames, tuple(report.lines), {})
