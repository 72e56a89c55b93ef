"""Fortran 2008, free form, lines of at most 132 characters, every routine with bind(c).

Subroutines eom_once(p, c), eom_step(c, p, y, u, M, f), accel(p, y, u, M, f), eom_feed(t, c, p, y, u), eom_rates,
eom_outputs; functions rhs, outputs and, on request, jac(t, c, p, y, u, J), called as those of C and with their return
values. M is the full symmetric matrix as a vector, J is row by row.
"""

import textwrap

from spacar.symbolic.emit.fortran_solvers import CONSTRAINED, JAC, RHS, SIZES, SOLVE
from spacar.symbolic.emit.routines import Routine, compiled_routines
from spacar.symbolic.emit.scalars import FORTRAN, Writer
from spacar.symbolic.ordered import OrderedProgram

_WIDTH = 120


def source(program: OrderedProgram, jacobian: bool, head: list[str]) -> str:
    """The Fortran module as text."""
    once, routines = compiled_routines(program, jacobian)
    n = program.n
    sizes = {
        "p": len(program.parameters), "c": len(once), "y": len(program.state), "u": len(program.inputs), "M": n * n,
        "f": n, "ydot": len(program.coordinates), "out": len(program.outputs), "J": program.m * n, "h": program.m,
        "a": len(program.unknowns), "turn": len(program.coordinates) * n,
        "res": len(program.constraints.residual) if program.constraints else 0,
    }  # fmt: skip
    lines = [f"! {line}".rstrip() for line in head]
    lines += [
        "module equations_of_motion",
        "  use, intrinsic :: iso_c_binding, only: dp => c_double, c_int",
        "  implicit none",
        *SIZES.format(nq=len(program.coordinates), n=n, ny=len(program.state), nm=program.m).splitlines(),
        f"  private :: accelerations, solve{', constrained' * (program.m > 0)}{', eom_slopes' * jacobian}",
        "  private :: n_q, n_s, n_y, n_g",
    ]
    lines += ["contains", ""]
    for r in routines:
        own = {"J": (len(program.state) + program.m) * len(program.state)} if r.internal else {}
        lines += _subroutine(r, sizes | own)
    lines += _accel(sizes, ("M", "f", "J", "h") if program.m else ("M", "f"))
    lines += _solving(program, jacobian)
    lines += ["end module equations_of_motion", ""]
    return "\n".join(piece for line in lines for piece in _wrap(line))


def _solving(program: OrderedProgram, jacobian: bool) -> list[str]:
    """What solves for accelerations, with or without constraints."""
    tied = program.m > 0
    names = {"arrays": ", rows(n_s*n_g), h(n_g)" if tied else "", "filled": ", rows, h" if tied else ""}
    solve = "constrained(mass, rows, a, h, 1)" if tied else "solve(n_s, mass, a, 1)"
    out = "    call eom_feed(t, c, p, y, u)\n    call eom_outputs(c, p, y, u, out)\n    bad = 0\n"
    if program.outputs_need_accelerations:
        out = "    real(dp) :: a(n_s + n_g)\n    call eom_feed(t, c, p, y, u)\n"
        out += "    bad = accelerations(c, p, y, u, a)\n    call eom_outputs(c, p, y, u, a, out)\n"
    moved = "    a(n_s + 1:) = h\n" if tied else ""
    parts = [SOLVE, *[CONSTRAINED] * tied, RHS.format(solve=solve, moved=moved, outputs=out, **names)]
    if jacobian:
        places = "slopes(n_q*n_y + 1), slopes(n_y*n_y + 1), n_y" if tied else "slopes(n_q*n_y + 1), n_y"
        many = f"constrained(mass, rows, {places})" if tied else f"solve(n_s, mass, {places})"
        parts.append(JAC.format(solve=many, **names))
    return [*"\n".join(parts).splitlines(), ""]


def _declare(argument: str, intent: str, sizes: dict[str, int]) -> str:
    if argument == "t":
        return "    real(dp), intent(in), value :: t"
    return f"    real(dp), intent({intent}) :: {argument}({sizes[argument]})"


def _subroutine(r: Routine, sizes: dict[str, int]) -> list[str]:
    w = Writer(FORTRAN, r.known)
    lines = [f"  subroutine eom_{r.name}({', '.join(r.arguments)}){'' if r.internal else ' bind(c)'}"]
    lines += [_declare(a, "inout" if a in r.changed else "in", sizes) for a in r.arguments]
    local = [w.names[s] for s in r.known]
    lines += [f"    real(dp) :: {', '.join(local[i : i + 8])}" for i in range(0, len(local), 8)]
    if r.unused:
        lines += ["    associate (" + ", ".join(f"unused_{a} => {a}" for a in r.unused) + ")", "    end associate"]
    lines += [f"    {w.names[s]} = {a}({i + 1})" for a, i, s in r.reads]
    lines += [f"    {w.names[s]} = {w(e)}" for s, e in r.body]
    lines += [f"    {a}({i + 1}) = {w(e)}" for a, i, e in r.results]
    return [*lines, f"  end subroutine eom_{r.name}", ""]


def _accel(sizes: dict[str, int], filled: tuple[str, ...]) -> list[str]:
    results = ", ".join(filled)
    lines = [f"  subroutine accel(p, y, u, {results}) bind(c)"]
    lines += [_declare(a, "inout" if a in filled else "in", sizes) for a in ("p", "y", "u", *filled)]
    lines += [
        f"    real(dp) :: c({sizes['c']})",
        "    call eom_once(p, c)",
        f"    call eom_step(c, p, y, u, {results})",
    ]
    return [*lines, "  end subroutine accel", ""]


def _wrap(line: str) -> list[str]:
    """Continuation lines; broken at blanks and after multiplication signs."""
    if len(line) <= _WIDTH or line.lstrip().startswith("!"):
        return [line]
    indent = line[: len(line) - len(line.lstrip())]
    breakable = line.strip().replace("*", "* ").replace("* * ", "**").replace("/", "/ ")
    pieces = textwrap.wrap(breakable, _WIDTH - len(indent) - 6, break_long_words=False, break_on_hyphens=False)
    return [f"{indent}{'  ' if i else ''}{p}{' &' if i < len(pieces) - 1 else ''}" for i, p in enumerate(pieces)]
