"""Fortran 2008, free form, lines of at most 132 characters, every routine with bind(c).

Subroutines eom_once(p, c), eom_step(c, p, y, u, M, f), accel(p, y, u, M, f), eom_feed(t, c, p, y, u), eom_rates,
eom_outputs; functions rhs, outputs and, on request, jac(t, c, p, y, u, J), called as those of C and with their return
values. M is the full symmetric matrix as a vector, J is row by row. The solvers have the method of `solvers.py`.
"""

import textwrap

from spacar.symbolic.emit.routines import Routine, compiled_routines, sizes
from spacar.symbolic.emit.scalars import FortranText, Writer
from spacar.symbolic.ordered import OrderedProgram

_WIDTH = 120

SIZES = """\
  integer, parameter :: n_q = {ydot}, n_s = {f}, n_y = {y}, n_g = {h}  ! coordinates, speeds, state, constraints
"""

SOLVE = """\
  ! L D L^T without pivoting, the matrix m is overwritten; k columns of b become the solution
  function solve(n, m, b, k) result(bad)
    integer, intent(in) :: n, k
    real(dp), intent(inout) :: m(n, n), b(k, n)
    integer(c_int) :: bad
    real(dp) :: d(n), v(n)
    integer :: i
    do i = 1, n
      bad = i
      v(:i - 1) = m(i, :i - 1)*d(:i - 1)
      d(i) = m(i, i) - dot_product(m(i, :i - 1), v(:i - 1))
      if (.not. d(i) > 0.0_dp) return
      m(i + 1:, i) = (m(i + 1:, i) - matmul(m(i + 1:, :i - 1), v(:i - 1)))/d(i)
    end do
    do i = 1, n
      b(:, i) = b(:, i) - matmul(b(:, :i - 1), m(i, :i - 1))
    end do
    do i = n, 1, -1
      b(:, i) = b(:, i)/d(i) - matmul(b(:, i + 1:), m(i + 1:, i))
    end do
    bad = 0
  end function solve
"""

CONSTRAINED = """\
  ! M a - J^T l = b, J a = -h for k columns; b becomes a, h becomes l. mass and rows are overwritten.
  ! Dependent speeds are chosen by pivoting. j when the pivot of speed j is not positive, -1 when the constraints
  ! depend on each other.
  function constrained(mass, rows, b, h, k) result(bad)
    integer, intent(in) :: k
    real(dp), intent(inout) :: mass(n_s, n_s), rows(n_s, n_g), b(k, n_s), h(k, n_g)
    integer(c_int) :: bad
    integer, parameter :: n_i = n_s - n_g
    real(dp) :: d(n_s), e(n_g, n_g), w(n_s, n_g), t(n_i, n_s), a(n_i, n_i), x(k, n_i), s(k, n_s), largest
    integer :: pivot(n_g), kept(n_i), i, j, l, q, at(2)
    logical :: dependent(n_s), done(n_g)
    bad = -1
    e = 0.0_dp
    done = .false.
    dependent = .false.
    do i = 1, n_s
      d(i) = 1.0_dp
      if (mass(i, i) > 0.0_dp) d(i) = 1.0_dp/sqrt(mass(i, i))
    end do
    do i = 1, n_s
      mass(:, i) = mass(:, i)*d*d(i)
      b(:, i) = b(:, i)*d(i)
    end do
    do l = 1, n_g
      rows(:, l) = rows(:, l)*d
      largest = maxval(abs(rows(:, l)))
      if (.not. largest > 0.0_dp) return
      w(:, l) = rows(:, l)/largest
      e(l, l) = 1.0_dp/largest
    end do
    do q = 1, n_g
      at = maxloc(abs(w), mask=.not. (spread(dependent, 2, n_g) .or. spread(done, 1, n_s)))
      if (any(at == 0)) return
      i = at(1)
      l = at(2)
      if (.not. abs(w(i, l)) > 8.0_dp*n_s*2.3e-16_dp) return
      done(l) = .true.
      dependent(i) = .true.
      pivot(l) = i
      e(:, l) = e(:, l)/w(i, l)
      w(:, l) = w(:, l)/w(i, l)
      do j = 1, n_g
        if (j == l) cycle
        e(:, j) = e(:, j) - w(i, j)*e(:, l)
        w(:, j) = w(:, j) - w(i, j)*w(:, l)
      end do
    end do
    kept = pack([(i, i = 1, n_s)], .not. dependent)
    t = merge(1.0_dp, 0.0_dp, spread(kept, 2, n_s) == spread([(i, i = 1, n_s)], 1, n_i))
    t(:, pivot) = -w(kept, :)
    s = 0.0_dp
    s(:, pivot) = -matmul(h, e)
    a = matmul(t, matmul(mass, transpose(t)))
    x = matmul(b - matmul(s, mass), transpose(t))
    bad = solve(n_i, a, x, k)
    if (bad > 0) bad = kept(bad)
    if (bad > 0) return
    s = s + matmul(x, t)
    h = matmul(matmul(s, mass(:, pivot)) - b(:, pivot), transpose(e))
    b = s*spread(d, 1, k)
  end function constrained
"""

RHS = """\
  ! accelerations and constraint forces a; 0, j when the pivot of speed j is not positive, -1 for dependent constraints
  function accelerations(c, p, y, u, a) result(bad)
    real(dp), intent(in) :: c(*), p(*), y(*), u(*)
    real(dp), intent(inout) :: a(n_s + n_g)
    integer(c_int) :: bad
    real(dp) :: mass(n_s*n_s){arrays}
    call eom_step(c, p, y, u, mass, a{filled})
    bad = {solve}
{moved}  end function accelerations

  ! inputs without a law are taken from u, the others are computed
  function rhs(t, c, p, y, u, ydot) result(bad) bind(c)
    real(dp), intent(in), value :: t
    real(dp), intent(in) :: c(*), p(*), y(*)
    real(dp), intent(inout) :: u(*), ydot(n_y)
    integer(c_int) :: bad
    real(dp) :: a(n_s + n_g)
    call eom_feed(t, c, p, y, u)
    call eom_rates(c, p, y, u, ydot)
    bad = accelerations(c, p, y, u, a)
    ydot(n_q + 1:) = a(1:n_s)
  end function rhs

  ! the named outputs
  function outputs(t, c, p, y, u, out) result(bad) bind(c)
    real(dp), intent(in), value :: t
    real(dp), intent(in) :: c(*), p(*), y(*)
    real(dp), intent(inout) :: u(*), out(*)
    integer(c_int) :: bad
{outputs}  end function outputs
"""

JAC = """\
  ! d(ydot)/dy, row by row
  function jac(t, c, p, y, u, J) result(bad) bind(c)
    real(dp), intent(in), value :: t
    real(dp), intent(in) :: c(*), p(*), y(*)
    real(dp), intent(inout) :: u(*), J(n_y*n_y)
    integer(c_int) :: bad
    real(dp) :: mass(n_s*n_s), a(n_s + n_g), slopes((n_y + n_g)*n_y){arrays}
    call eom_feed(t, c, p, y, u)
    bad = accelerations(c, p, y, u, a)
    if (bad /= 0) return
    call eom_slopes(t, c, p, y, u, a, slopes)
    call eom_step(c, p, y, u, mass, a{filled})
    bad = {solve}
    J = slopes(1:n_y*n_y)
  end function jac
"""


def source(program: OrderedProgram, jacobian: bool, head: list[str]) -> str:
    once, routines = compiled_routines(program, jacobian)
    lengths = sizes(program, once)
    lines = [f"! {line}".rstrip() for line in head]
    lines += [
        "module equations_of_motion",
        "  use, intrinsic :: iso_c_binding, only: dp => c_double, c_int",
        "  implicit none",
        *SIZES.format(**lengths).splitlines(),
        f"  private :: accelerations, solve{', constrained' * (program.m > 0)}{', eom_slopes' * jacobian}",
        "  private :: n_q, n_s, n_y, n_g",
    ]
    lines += ["contains", ""]
    for r in routines:
        own = {"J": (len(program.state) + program.m) * len(program.state)} if r.internal else {}
        lines += _subroutine(r, lengths | own)
    lines += _accel(lengths, ("M", "f", "J", "h") if program.m else ("M", "f"))
    lines += _solving(program, jacobian)
    lines += ["end module equations_of_motion", ""]
    return "\n".join(piece for line in lines for piece in _wrap(line))


def _solving(program: OrderedProgram, jacobian: bool) -> list[str]:
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


def _declare(argument: str, intent: str, lengths: dict[str, int]) -> str:
    if argument == "t":
        return "    real(dp), intent(in), value :: t"
    return f"    real(dp), intent({intent}) :: {argument}({lengths[argument]})"


def _subroutine(r: Routine, lengths: dict[str, int]) -> list[str]:
    w = Writer(FortranText, r.known)
    lines = [f"  subroutine eom_{r.name}({', '.join(r.arguments)}){'' if r.internal else ' bind(c)'}"]
    lines += [_declare(a, "inout" if a in r.changed else "in", lengths) for a in r.arguments]
    local = [w.names[s] for s in r.known]
    lines += [f"    real(dp) :: {', '.join(local[i : i + 8])}" for i in range(0, len(local), 8)]
    if r.unused:
        lines += ["    associate (" + ", ".join(f"unused_{a} => {a}" for a in r.unused) + ")", "    end associate"]
    lines += [f"    {w.names[s]} = {a}({i + 1})" for a, i, s in r.reads]
    lines += [f"    {w.names[s]} = {w(e)}" for s, e in r.body]
    lines += [f"    {a}({i + 1}) = {w(e)}" for a, i, e in r.results]
    return [*lines, f"  end subroutine eom_{r.name}", ""]


def _accel(lengths: dict[str, int], filled: tuple[str, ...]) -> list[str]:
    results = ", ".join(filled)
    lines = [f"  subroutine accel(p, y, u, {results}) bind(c)"]
    lines += [_declare(a, "inout" if a in filled else "in", lengths) for a in ("p", "y", "u", *filled)]
    lines += [
        f"    real(dp) :: c({lengths['c']})",
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
