"""`spacar symbolic simulate`: run a model, write its log, its .sbd and, when asked, its figures.

What `spacar symbolic check` and `derive` print.
"""

import json
from typing import Any

import numpy as np
from spacar_formats.result_files import write_steps
from spacar_formats.safety import Claim, write_text

import spacar
from spacar.errors import AnalysisError, SpacarError, UsageError
from spacar.symbolic.compiled_program import CompiledFunction, compiler
from spacar.symbolic.printing import latex, text
from spacar.symbolic.program import EquationProgram
from spacar.symbolic.script import SymbolicModel
from spacar.symbolic.simulated_motion import SimulatedMotion
from spacar.symbolic.skeleton import Picture, picture
from spacar.symbolic.symbolic_equations import SymbolicEquations

DEFAULTS: dict[str, Any] = {"time": 1.0, "steps": 1000, "integrator": "lsoda", "rtol": 1e-8, "atol": None}


def simulate_model(
    model: SymbolicModel, strategy: str, changes: dict[str, float], wishes: dict[str, Any], compiled: bool,
    plot: tuple[str, ...], show: bool, wait: bool,
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
    lines = [f"spacar {spacar.__version__}, symbolic", "", *description(model), "", "parameters (SI units):"]
    lines += [f"  {name} = {value:.17g}" for name, value in values.items()]
    lines += ["", "start (states that are not listed: 0):"]
    lines += [f"  {name} = {value:.17g}" for name, value in start.items()]
    lines += ["", *summary, "", "model file:"]
    lines += [f"  {line}" for line in model.path.read_text(encoding="utf-8-sig").splitlines()]
    if show:
        held = eq if eq.strategy == "held" else model.system.derive("held")
        lines += ["", "equations in vector notation:", "", equations_text(model, held, "held", "text")]
    write_text(log, "\n".join(lines) + "\n")
    written = [log, sbd]
    if plot:
        from spacar_cli.symbolic_plot import save_plots

        written += save_plots(run, model.path.with_suffix(""), None if "all" in plot else plot)
    return [*summary, "written: " + ", ".join(path.name for path in written)]


def _changed(model: SymbolicModel, changes: dict[str, float]) -> tuple[dict[str, float], dict[str, float]]:
    values, start = dict(model.values), dict(model.start)
    states = {str(s.func) for s in [*model.system.coordinates, *model.system.speeds]}
    for name, number in changes.items():
        if name in states:
            start[name] = number
        elif name in {*model.values, *model.declared}:
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


def description(model: SymbolicModel) -> list[str]:
    """What a model contains, one line a kind of part."""
    system = model.system
    names = [str(q.func) for q in system.coordinates]
    speeds = [str(s.func) for s in system.speeds]
    lines = [
        f"model        {system.title or model.path.stem} ({model.path.name})",
        f"coordinates  {len(names)}: {', '.join(names)}", f"speeds       {len(speeds)}: {', '.join(speeds)}",
        f"freedom      {len(speeds) - len(system.constraints)} degrees, {len(system.constraints)} constraints",
    ]  # fmt: skip
    for beam in system.beams:
        fields = ", ".join(f"{f.name} ({f.kind}, {len(f.shapes)} shapes)" for f in beam.fields) or "no field"
        shortening = ", foreshortening" if beam.shortening else ""
        lines.append(f"beam         {beam.name}: {fields}{shortening}")
    lines += [f"body         {body.name}{'' if body.frame else ' (particle)'}" for body in system.bodies]
    lines.append(f"loads        {len(system.loads)} forces and torques, {len(system.springs)} springs")
    lines += [f"input        {s.name} = {_plain(e)}" for s, e in system.inputs.items()]
    lines.append(f"parameters   {len(model.values)} with values: {', '.join(model.values) or 'none'}")
    lines.append(f"outputs      {', '.join(model.outputs) or 'none'}")
    return lines


def _plain(expression: Any) -> str:
    return "given at the simulation" if expression is None else text(expression)


def equations_text(model: SymbolicModel, eq: SymbolicEquations, show: str, form: str) -> str:
    if show == "program":
        return _program_text(model, eq, form)
    held = eq.held if show == "held" else eq.transform()
    speeds = [str(s.func) for s in eq.system.speeds]
    definitions = eq.table.definitions
    write = latex if form == "latex" else text
    if form == "json":
        record = {
            "strategy": eq.strategy, "operations": eq.count_ops(),
            "equations": {s: text(e) for s, e in zip(speeds, held, strict=True)},
            "definitions": {str(z): text(e) for z, e in definitions.items()},
        }  # fmt: skip
        return json.dumps(record, ensure_ascii=False, indent=2)
    pairs = [*((write(z), write(e)) for z, e in definitions.items())]
    if form == "latex":
        rows = [f"0 &= {write(e)}" for e in held] + [f"{z} &= {e}" for z, e in pairs]
        return "\\begin{align*}\n" + " \\\\\n".join(rows) + "\n\\end{align*}"
    lines = []
    for name, equation in zip(speeds, held, strict=True):
        lines += [f"equation of {name}:", f"  0 = {write(equation)}", ""]
    return "\n".join([*lines, "with", *(f"  {z} = {e}" for z, e in pairs)])


def _program_text(model: SymbolicModel, eq: SymbolicEquations, form: str) -> str:
    program = eq.program(model.outputs)
    if form == "latex":
        return program.text("latex")
    n = program.n
    places = [(i, j) for i in range(1, n + 1) for j in range(i, n + 1)]
    results = {f"I[{i},{j}]": text(e) for (i, j), e in zip(places, program.mass, strict=True)}
    results |= {f"f[{i}]": text(e) for i, e in enumerate(program.rhs, 1)}
    results |= {f"{q.name}_dot": text(e) for q, e in zip(program.coordinates, program.rates, strict=True)}
    results |= {name: text(e) for name, e in program.outputs.items()}
    once, step = ({s.name: text(e) for s, e in part} for part in (program.once, program.step))
    if form == "json":
        record = {
            "strategy": eq.strategy, "operations": program.counts(), "parameters": [s.name for s in program.parameters],
            "state": [s.name for s in program.state], "inputs": {s.name: _plain(e) for s, e in program.inputs.items()},
            "once": once, "step": step, "results": results,
        }  # fmt: skip
        return json.dumps(record, ensure_ascii=False, indent=2)
    counts = program.counts()
    lines = [f"operations: {counts['step']} per step, {counts['once']} once"]
    for title, part in (("once:", once), ("each step:", step), ("results:", results)):
        lines += ["", title, *(f"  {name} = {value}" for name, value in part.items())]
    return "\n".join(lines)
