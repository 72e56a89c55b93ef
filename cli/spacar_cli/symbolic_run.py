"""`spacar symbolic simulate`: run a model, write its log, its .sbd and, when asked, its figures."""

from pathlib import Path
from typing import Any

import numpy as np
from spacar_formats.safety import Claim, write_text
from spacar_formats.sinks import write_steps

import spacar
from spacar.errors import AnalysisError, SpacarError, UsageError
from spacar.symbolic.compiled_program import CompiledFunction, compiler
from spacar.symbolic.program import EquationProgram
from spacar.symbolic.script import SymbolicModel
from spacar.symbolic.simulated_motion import SimulatedMotion
from spacar.symbolic.skeleton import Picture, picture
from spacar.symbolic.symbolic_equations import SymbolicEquations
from spacar_cli.symbolic_text import description, equations_text

DEFAULTS: dict[str, Any] = {"time": 1.0, "steps": 1000, "integrator": "lsoda", "rtol": 1e-8, "atol": None}


def simulate_model(
    model: SymbolicModel, strategy: str, changes: dict[str, float], wishes: dict[str, Any], compiled: bool,
    plot: tuple[str, ...], show: bool, wait: bool = False,
) -> list[str]:  # fmt: skip
    """Derive, integrate, write; the lines of the summary.

    `plot` names quantities of figures, or "all"; `show` puts equations into the log. `changes` replace parameter or
    start values, `wishes` settings of the model (None: not wished). Raises UsageError for names that the model does not
    have, AnalysisError when the integration stops.
    """
    if compiled:
        compiler()  # a CC that cannot be used is told before anything is written
    values, start = _changed(model, changes)
    states = [str(s.func) for s in (*model.system.coordinates, *model.system.speeds)]
    for name in plot:
        if name not in (*states, *model.outputs, "all"):
            known = ", ".join((*states, *model.outputs))
            raise UsageError(f"{model.path.name}: --plot {name}: there are {known}, or all", "usage.plot")
    log, sbd = (model.path.with_suffix(ending) for ending in (".log", ".sbd"))
    settings = DEFAULTS | model.settings | {key: value for key, value in wishes.items() if value is not None}
    with Claim(sbd, wait) as claim:
        try:
            eq = model.system.derive(strategy)
            checked = eq.check()
            checked.demand()
            program = eq.program(model.outputs)
            function, note = _compiled(program, values) if compiled else (None, "generated Python")
            run = program.simulate(
                values, start, t_end=float(settings["time"]), steps=int(settings["steps"]),
                integrator=settings["integrator"], rtol=float(settings["rtol"]), atol=settings["atol"],
                function=function, guess=settings.get("guess"),
            )  # fmt: skip
        except SpacarError as error:
            kind = AnalysisError if isinstance(error, AnalysisError) else UsageError
            raise kind(f"{model.path.name}: {error}", error.code) from None
        summary = _summary(eq, program, run, note, str(checked))
        write_sbd(claim, model, run, picture(model.system, run, values))
    _write_log(log, model, eq, values, start, summary, show)
    written = [log, sbd]
    if plot:
        from spacar_cli.symbolic_plot import save_plots

        written += save_plots(run, model.path.with_suffix(""), None if "all" in plot else plot)
    return [*summary, "written: " + ", ".join(path.name for path in written)]


def _changed(model: SymbolicModel, changes: dict[str, float]) -> tuple[dict[str, float], dict[str, float]]:
    values, start = dict(model.values), dict(model.start)
    states = {str(s.func) for s in [*model.system.coordinates, *model.system.speeds]}
    symbols = model.parameter_names()
    for name, number in changes.items():
        if name in states:
            start[name] = number
        elif name in symbols:
            values[name] = number
        else:
            raise UsageError(f"{model.path.name}: --set {name}: the model has no parameter or state of this name")
    return values, start


def _compiled(program: EquationProgram, values: dict[str, float]) -> tuple[Any, str]:
    """The compiled function, or None with the reason when there is no compiler."""
    words = compiler()
    if words is None:
        return None, "generated Python (no C compiler was found)"
    return CompiledFunction(program, values), f"C, compiled by {' '.join(words)}"


def _summary(
    eq: SymbolicEquations, program: EquationProgram, run: SimulatedMotion, note: str, checked: str
) -> list[str]:
    counts, s, e = program.counts(), run.statistics, run.eigenvalue
    last = ", ".join(f"{name} = {run[name][-1]:.12g}" for name in [*run.names, *run.outputs])
    return [
        f"derivation   {eq.strategy}, {eq.seconds:.2f} s, {counts['step']} operations per step, {counts['once']} once",
        f"check        {checked}",
        *run.notes,
        f"integration  {s['integrator']} ({s['method']}), rtol {s['rtol']:g}, {s['evaluations']} evaluations, "
        f"{s['jacobians']} Jacobians, {s['seconds']:.2f} s, {note}"
        + (f", {s['projections']} restarts from the constraints" if "projections" in s else ""),
        f"end          t = {run.time[-1]:g} s: {last}",
        f"eigenvalue   with the largest real part at the end: {e.real:.6g} {'+' if e.imag >= 0 else '-'} "
        f"{abs(e.imag):.6g} i 1/s" + (" (unstable)" if e.real > 1e-6 * abs(e) and e.real > 1e-9 else ""),
    ]


def write_sbd(claim: Claim, model: SymbolicModel, run: SimulatedMotion, seen: Picture | None) -> None:
    """The result container: time, q, s, u (inputs), y (outputs); names in the texts QNAME, SNAME, UNAME, YNAME.

    `seen` adds the nodes and elements of a picture, with X.
    """
    nq = len(model.system.coordinates)
    header: dict[str, Any] = {"TITLE": model.system.title or model.path.stem, "KIND": "symbolic"}
    header |= {"VERSION": f"spacar {spacar.__version__}", "SOURCE": model.path.name, "SHA256": model.sha256}
    columns = {"T": run.time}
    if seen is not None:
        header |= seen.header
        columns["X"] = seen.x
    outputs = np.column_stack([run.outputs[name] for name in run.outputs]) if run.outputs else np.zeros(0)
    groups = (
        ("Q", run.names[:nq], run.state[:, :nq]), ("S", run.names[nq:], run.state[:, nq:]),
        ("U", run.input_names, run.inputs), ("Y", list(run.outputs), outputs),
    )  # fmt: skip
    for letter, names, rows in groups:
        if names:
            header[f"{letter}NAME"] = list(names)
            columns[letter] = rows
    steps = ({name: rows[k] for name, rows in columns.items()} for k in range(len(run.time)))
    write_steps(claim, header, steps)


def _write_log(
    path: Path, model: SymbolicModel, eq: SymbolicEquations, values: dict[str, float], start: dict[str, float],
    summary: list[str], show: bool,
) -> None:  # fmt: skip
    lines = [f"spacar {spacar.__version__}, symbolic", "", *description(model), "", "parameters (SI units):"]
    lines += [f"  {name} = {value:.17g}" for name, value in values.items()]
    lines += ["", "start (states that are not listed: 0):"]
    lines += [f"  {name} = {value:.17g}" for name, value in start.items()]
    lines += ["", *summary, "", "model file:"]
    lines += [f"  {line}" for line in model.path.read_text(encoding="utf-8").splitlines()]
    if show:
        held = eq if eq.strategy == "held" else model.system.derive("held")
        lines += ["", "equations in vector notation:", "", equations_text(model, held, "held", "text")]
    write_text(path, "\n".join(lines) + "\n")
