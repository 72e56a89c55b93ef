"""Python: scalar arithmetic with `math` only, the symmetric system solved by an unrolled LDLᵀ.

The generated module has `make_rhs(parameters, feeds)`, which does the once part and returns (rhs, jac) with
rhs(t, y) -> ẏ as a list and jac(t, y) -> ∂ẏ/∂y as an array; `rhs.accel(y, u)` gives I (upper triangle) and f,
`rhs.outputs(t, y)` the named outputs, `rhs.inputs(t, y)` the inputs. With constraints `rhs.manifold(t, y)` gives I, J,
the open velocities e and gaps g, and ∂q̇/∂s.
"""

import sympy as sp

from spacar.symbolic.emit import solvers
from spacar.symbolic.emit.scalars import PythonText, Writer
from spacar.symbolic.ordered import Assignments, OrderedProgram
from spacar.symbolic.program_jacobian import jacobian_of

UNROLLED = 12  # beyond this size NumPy solves faster than unrolled code


def source(program: OrderedProgram, jacobian: bool, head: list[str]) -> str:
    w = Writer(PythonText, [*program.parameters, *program.state, *program.inputs])
    once = jacobian_of(program).once if jacobian else program.once
    lines = ['"""', *head, '"""', ""] if head else []
    lines += ["from math import acos, asin, atan, atan2, cos, cosh, exp, log, sin, sinh, sqrt, tan, tanh", ""]
    if jacobian or program.m or program.n > UNROLLED:
        lines += ["import numpy as np", ""]
    lines += [f"{what.upper()} = ({''.join(f'{n!r}, ' for n in names)})" for what, names in program.names.items()]
    lines.append("")
    if program.m:
        lines += [*solvers.PYTHON.splitlines(), ""]
    lines.append("")
    lines += [
        "def make_rhs(parameters, feeds=None):",
        '    """rhs and jac for a mapping of parameter values and of functions of (t, y) for inputs without law."""',
    ]
    lines += [f"    {w.add(s)} = float(parameters[{s.name!r}])" for s in program.parameters]
    lines += [f"    {_feed(w, s)} = feeds[{s.name!r}]" for s, e in program.inputs.items() if e is None]
    lines += _assign(w, once, 4)
    bodies = {
        "accel": _accel(w, program), "inputs": [*_inputs(w, program), f"        return ({_tuple(w, program.inputs)})"],
        "outputs": _outputs(w, program), "rhs": _rhs(w, program),
    }  # fmt: skip
    if jacobian:
        bodies["jac"] = _jac(w, program)
    if program.m:
        bodies["manifold"] = _manifold(w, program)
    unpack = f"        ({_tuple(w, program.state)}) = y" if program.state else ""
    for name, body in bodies.items():
        lines += ["", f"    def {name}({'y, u' if name == 'accel' else 't, y'}):", unpack, *body, ""]
    lines += ["    rhs.accel, rhs.inputs, rhs.outputs = accel, inputs, outputs"]
    lines += ["    rhs.manifold = manifold"] * (program.m > 0)
    lines += [f"    return rhs, {'jac' if jacobian else 'None'}", ""]
    return "\n".join(lines)


def _feed(w: Writer, s: sp.Symbol) -> str:
    return f"feed_{w.add(s)}"


def _tuple(w: Writer, expressions: object) -> str:
    return "".join(w(e) + ", " for e in expressions)  # type: ignore[attr-defined]


def _assign(w: Writer, assignments: Assignments, indent: int) -> list[str]:
    return [f"{' ' * indent}{w.add(s)} = {w(e)}" for s, e in assignments]


def _inputs(w: Writer, program: OrderedProgram) -> list[str]:
    return [f"        {w.add(s)} = {f'{_feed(w, s)}(t, y)' if e is None else w(e)}" for s, e in program.inputs.items()]


def _accel(w: Writer, program: OrderedProgram) -> list[str]:
    given = [f"        ({_tuple(w, program.inputs)}) = u"] if program.inputs else []
    body = _assign(w, program.order([*program.mass, *program.rhs]), 8)
    return [*given, *body, f"        return ({_tuple(w, program.mass)}), ({_tuple(w, program.rhs)})"]


def _outputs(w: Writer, program: OrderedProgram) -> list[str]:
    results = list(program.outputs.values())
    lines = _inputs(w, program)
    if program.outputs_need_accelerations:
        before = program.order(program.system)
        lines += [*_assign(w, before, 8), *_solve(w, program), *_unknowns(w, program)]
        done = {s for s, _ in before}
        lines += _assign(w, tuple(p for p in program.order(results) if p[0] not in done), 8)
    else:
        lines += _assign(w, program.order(results), 8)
    return [*lines, f"        return ({_tuple(w, results)})"]


def _unknowns(w: Writer, program: OrderedProgram) -> list[str]:
    lines = [f"        {w.add(s)} = a_{i}" for i, s in enumerate(program.accelerations)]
    return lines + [f"        {w.add(s)} = force_{i}" for i, s in enumerate(program.unknowns[program.n :])]


def _rhs(w: Writer, program: OrderedProgram) -> list[str]:
    needed = program.order([*program.system, *program.rates])
    lines = [*_inputs(w, program), *_assign(w, needed, 8), *_solve(w, program)]
    accelerations = "".join(f"a_{i}, " for i in range(program.n))
    return [*lines, f"        return [{_tuple(w, program.rates)}{accelerations}]"]


def _array(w: Writer, entries: object, columns: int) -> str:
    items = [w(e) for e in entries]  # type: ignore[attr-defined]
    rows = (items[i : i + columns] for i in range(0, len(items), columns))
    return "[" + ", ".join(f"[{', '.join(row)}]" for row in rows) + "]"


def _solve(w: Writer, program: OrderedProgram) -> list[str]:
    """I a = f by LDLᵀ without pivoting: I is positive definite, a pivot that is not positive is an error."""
    n, c = program.n, program.constraints
    unknowns = "".join(f"a_{i}, " for i in range(n))
    if c is not None:
        forces = "".join(f"force_{i}, " for i in range(program.m))
        return [
            f"        M, J = np.array({_array(w, program.inertia, n)}), np.array({_array(w, c.matrix, n)})",
            f"        f, h = np.array([{_tuple(w, program.rhs)}]), np.array([{_tuple(w, c.bias)}])",
            "        a, force = constrained(M, f, J, h)",
            f"        ({unknowns}), ({forces}) = a.tolist(), force.tolist()",
        ]
    if n > UNROLLED:
        I = _array(w, program.inertia, n)
        return [f"        {unknowns} = np.linalg.solve({I}, [{_tuple(w, program.rhs)}]).tolist()"]
    lines, inertia = [], program.inertia
    for j in range(n):
        for i in range(j, n):  # v_ij = l_ij d_j
            parts = "".join(f" - v_{i}_{k}*l_{j}_{k}" for k in range(j))
            lines.append(f"        v_{i}_{j} = {w(inertia[j, i])}{parts}")
        lines.append(f"        if not v_{j}_{j} > 0.0:")
        name = program.speeds[j].name
        lines.append(f"            raise ArithmeticError('mass matrix is not positive definite at {name}')")
        lines += [f"        l_{i}_{j} = v_{i}_{j}/v_{j}_{j}" for i in range(j + 1, n)]
    for i in range(n):
        lines.append(f"        b_{i} = {w(program.rhs[i])}" + "".join(f" - l_{i}_{k}*b_{k}" for k in range(i)))
    for i in reversed(range(n)):
        lines.append(f"        a_{i} = b_{i}/v_{i}_{i}" + "".join(f" - l_{k}_{i}*a_{k}" for k in range(i + 1, n)))
    return lines


def _jac(w: Writer, program: OrderedProgram) -> list[str]:
    J = jacobian_of(program)
    lines = [*_rhs(w, program)[:-1], *_unknowns(w, program)]
    done = {s for s, _ in program.order([*program.system, *program.rates])}
    lines += _assign(w, tuple((s, e) for s, e in J.step if s not in done or dict(program.step).get(s) != e), 8)
    size = len(program.state)
    lines.append(f"        low = np.array({_array(w, J.dg, size)})")
    if program.m:
        lines.append(f"        low, _ = constrained(M, low, J, np.array({_array(w, J.dh, size)}))")
    else:
        lines.append(f"        low = np.linalg.solve({_array(w, program.inertia, program.n)}, low)")
    return [*lines, f"        return np.array([*{_array(w, J.drates, size)}, *low])"]


def _manifold(w: Writer, program: OrderedProgram) -> list[str]:
    c = program.constraints
    assert c is not None
    needed = program.order([*program.mass, *c.matrix, *c.residual, *c.turning])
    shapes = (_array(w, program.inertia, program.n), _array(w, c.matrix, program.n))
    turning = _array(w, c.turning, program.n)
    return [
        *_inputs(w, program),
        *_assign(w, needed, 8),
        f"        return np.array({shapes[0]}), np.array({shapes[1]}), np.array([{_tuple(w, c.velocity)}]), "
        f"np.array([{_tuple(w, c.position.values())}]), np.array({turning})",
    ]
