"""What `spacar symbolic check` and `derive` print."""

import json
from typing import Any

from spacar.symbolic.printing import latex, text
from spacar.symbolic.script import SymbolicModel
from spacar.symbolic.symbolic_equations import SymbolicEquations


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
    """The equations in the asked notation and format."""
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
