"""Modes 2 and 3 as streams of frames: inverse dynamics, and linearization along its result.

Theory: theory-system.md section 7.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.limits import Limits
from spacar.errors import UsageError
from spacar.forward.accepted_steps import at_time
from spacar.frame import Frame
from spacar.inverse.along import NO_STATE, Along
from spacar.inverse.nominal import Nominal, check_same_mechanism
from spacar.inverse.ports import NominalInputs, Ports, rigidified
from spacar.inverse.trajectory import TrajectoryProgram, loaded, program
from spacar.kinematics.constraint_condition import condition_number
from spacar.kinematics.transfer import TransferOutput
from spacar.mechanism.mechanism import Mechanism
from spacar.stream import Run


def inverse(run: Run) -> Iterator[Sequence[Frame]]:
    """Mode 2. Raises InputError (path, velocity profile) and UsageError (degrees of freedom that are not prescribed)
    before the first frame, AnalysisError while iterating.
    """
    from spacar.compiled import mechanism_of

    mechanism = mechanism_of(run)
    n = mechanism.numbering
    if n.nddof:
        names = ", ".join(n.q_names[i] for i in n.dynamic[:5])
        text = (
            f"mode 2 needs a prescribed motion for every degree of freedom, but {names}"
            f" {'is' if n.nddof == 1 else 'are'} dynamic; use INPUTX or INPUTE instead of DYNX or DYNE"
        )
        raise UsageError(text, "inverse.dynamic")
    work = program(mechanism, run.report)
    ports = Ports.of(mechanism)
    output = TransferOutput(run)
    run.n_frames = len(work)
    run.header.update(NNOM=len(ports.inputs), NU=len(ports.inputs), NY=len(ports.outputs))
    run.header.update(inputs=[s.name for s in ports.inputs], outputs=[s.name for s in ports.outputs])
    nominal = NominalInputs(ports, mechanism, run.report, rigidified(mechanism, ports, work.rests))
    limits: Limits | None = None
    for dynamics, t in _placed(work, mechanism):
        if limits is None:
            run.header["condition"] = condition_number(dynamics.kinematics)
            limits = Limits(dynamics, run.report)
        frame = at_time(dynamics, t, NO_STATE)
        frame.statistics = {"iterations": dynamics.iterations}
        limits.check(dynamics, frame)
        u0, _ = nominal(dynamics, frame)
        nominal.apply(dynamics, frame, u0)
        frame.state_space["u0"] = u0
        frame.state_space["y0"] = ports.reference(frame)
        yield (output.add(frame, dynamics.kinematics),)
    nominal.finish()


def along(run: Run) -> Iterator[Sequence[Frame]]:
    """Mode 3. Raises UsageError when the nominal motion is missing or of another mechanism, AnalysisError while
    iterating.
    """
    from spacar.compiled import mechanism_of

    mechanism = mechanism_of(run)
    if run.nominal is None:
        raise UsageError(
            "mode 3 needs the result of mode 2, or of mode 7 to 10 (nominal=...)", "files.setpoints-not-found"
        )
    given = run.nominal if isinstance(run.nominal, Nominal) else Nominal.of(run.nominal)
    check_same_mechanism(given, mechanism.numbering)
    for text in given.warnings:
        run.report.add(f"warning: {text}")
    what = f"stationary solutions of mode {given.mode}" if given.stationary else "nominal motion"
    run.report.add(f"{what}: {given.name}, {len(given.t)} steps")
    work = Along(mechanism, given, run.report)
    run.header.update(work.header())
    run.n_frames = len(given.t)
    output = TransferOutput(run)
    limits = Limits(work.dynamics, run.report)
    for k in range(len(given.t)):
        frame = work.frame(k)
        limits.check(work.dynamics, frame)
        yield (output.add(frame, work.dynamics.kinematics),)
        if k == 0:
            run.header["condition"] = condition_number(work.dynamics.kinematics)
    work.finish()


def _placed(work: TrajectoryProgram, mechanism: Mechanism) -> Iterator[tuple[Dynamics, float]]:
    """(evaluator near the configuration of the output time, output time [s]), one after the other.

    A trajectory with extra loads has an evaluator of its own.
    """
    plain = dynamics = Dynamics(replace(mechanism, drive=work.drive))
    here = -1
    for t, leg in work.times():
        if leg != here:
            model, before, here = loaded(mechanism, work.legs[leg].statements), dynamics, leg
            dynamics = plain if model is mechanism else Dynamics(replace(model, drive=work.drive))
            if t > 0.0 and before is not dynamics:
                dynamics.kinematics.start_from(before.kinematics)
                dynamics.kinematics.position(before.kinematics.x, before.kinematics.e_given)
        if t == 0.0:
            dynamics.kinematics.move(*dynamics.given(work.drive.at(t), NO_STATE))
        yield dynamics, t
