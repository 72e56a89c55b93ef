"""C99: eom_once(p, c), eom_step(c, p, y, u, M, f), accel(p, y, u, M, f), eom_feed, eom_rates, eom_outputs, rhs, jac.

M is the full symmetric matrix, row by row. Functions that solve for accelerations return 0, or j when the pivot of
speed j (counted from 1) is not positive.
"""

from __future__ import annotations

from spacar.symbolic.emit.routines import Routine, compiled_routines
from spacar.symbolic.emit.scalars import C, Writer
from spacar.symbolic.program import Program

_PREAMBLE = """\
#include <math.h>

#define NP {np}  /* parameters p */
#define NC {nc}  /* once c */
#define NQ {nq}  /* coordinates */
#define N {n}  /* speeds */
#define NY {ny}  /* state y */
#define NU {nu}  /* inputs u */
#define NOUT {nout}  /* outputs */

static inline double power_2(double x) {{ return x*x; }}
static inline double power_3(double x) {{ return x*x*x; }}
static inline double power_4(double x) {{ return (x*x)*(x*x); }}
"""

_SOLVE = """\
void accel(const double *p, const double *y, const double *u, double *M, double *f)
{
    double c[NC + 1];
    eom_once(p, c);
    eom_step(c, p, y, u, M, f);
}

/* LDL^T without pivoting, M overwritten; m columns of b, row by row, become the solution. */
static int solve(double *M, double *b, int m)
{
    for (int j = 0; j < N; j++) {
        for (int k = 0; k < j; k++) M[j*N + j] -= M[j*N + k]*M[j*N + k]*M[k*N + k];
        if (!(M[j*N + j] > 0.0)) return j + 1;
        for (int i = j + 1; i < N; i++) {
            for (int k = 0; k < j; k++) M[i*N + j] -= M[i*N + k]*M[k*N + k]*M[j*N + k];
            M[i*N + j] /= M[j*N + j];
        }
    }
    for (int i = 0; i < N; i++)
        for (int k = 0; k < i; k++)
            for (int h = 0; h < m; h++) b[i*m + h] -= M[i*N + k]*b[k*m + h];
    for (int i = N - 1; i >= 0; i--) {
        for (int h = 0; h < m; h++) b[i*m + h] /= M[i*N + i];
        for (int k = i + 1; k < N; k++)
            for (int h = 0; h < m; h++) b[i*m + h] -= M[k*N + i]*b[k*m + h];
    }
    return 0;
}

/* inputs without a law are taken from u, the others are computed */
int rhs(double t, const double *c, const double *p, const double *y, double *u, double *ydot)
{
    double M[N*N];
    eom_feed(t, c, p, y, u);
    eom_step(c, p, y, u, M, ydot + NQ);
    eom_rates(c, p, y, u, ydot);
    return solve(M, ydot + NQ, 1);
}
"""

_JAC = """\
/* d(ydot)/dy, row by row */
int jac(double t, const double *c, const double *p, const double *y, double *u, double *J)
{
    double M[N*N], a[N], K[N*N];
    eom_feed(t, c, p, y, u);
    eom_step(c, p, y, u, M, a);
    for (int i = 0; i < N*N; i++) K[i] = M[i];
    int bad = solve(K, a, 1);
    if (bad) return bad;
    eom_slopes(t, c, p, y, u, a, J);
    return solve(M, J + NQ*NY, NY);
}
"""


def source(program: Program, jacobian: bool, head: list[str]) -> str:
    """The C file as text."""
    once, routines = compiled_routines(program, jacobian)
    sizes = {
        "np": len(program.parameters), "nc": len(once), "nq": len(program.coordinates), "n": program.n,
        "ny": len(program.state), "nu": len(program.inputs), "nout": len(program.outputs),
    }  # fmt: skip
    comment = ["/*", *(f" * {line}".rstrip() for line in head), " */"] if head else []
    parts = [*comment, _PREAMBLE.format(**sizes)]
    parts += [_function(program, r) for r in routines]
    return "\n".join([*parts, _SOLVE, *([_JAC] if jacobian else [])])


def _function(program: Program, r: Routine) -> str:
    w = Writer(C, r.known)
    arguments = ", ".join(
        "double t" if a == "t" else f"{'' if a in r.changed else 'const '}double *{a}" for a in r.arguments
    )
    lines = [f"{'static ' if r.internal else ''}void eom_{r.name}({arguments})", "{"]
    lines += [f"    const double {w.add(s)} = {a}[{i}];" for a, i, s in r.reads]
    lines += [f"    const double {w.add(s)} = {w(e)};" for s, e in r.body]
    unused = [a for a in r.arguments if a not in r.changed and a != "t" and a not in {x for x, _, _ in r.reads}]
    unused += ["t"] if "t" in r.arguments and not r.uses_time else []
    unused += [a for a in r.changed if not any(x == a for x, _, _ in r.results)]
    lines += [f"    (void){a};" for a in unused]
    lines += [f"    {a}[{i}] = {w(e)};" for a, i, e in r.results]
    return "\n".join([*lines, "}", ""])
