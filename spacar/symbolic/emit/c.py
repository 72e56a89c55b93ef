"""C99: eom_once(p, c), eom_step(c, p, y, u, M, f), accel(p, y, u, M, f), eom_feed, eom_rates, rhs, outputs, jac;
rhs_many for many states at once.

With constraints eom_step and accel also give J and h = γ, and eom_manifold the residuals.

M is the full symmetric matrix, row by row. Functions that solve for accelerations return 0, or j when the pivot of
speed j (counted from 1) is not positive, or -1 when the constraints depend on each other at this position.
"""

from spacar.symbolic.emit import solvers
from spacar.symbolic.emit.routines import Routine, compiled_routines, sizes
from spacar.symbolic.emit.scalars import CText, Writer
from spacar.symbolic.ordered import OrderedProgram

_PREAMBLE = """\
#include <math.h>

#define NP {p}  /* parameters p */
#define NC {c}  /* once c */
#define NQ {ydot}  /* coordinates */
#define N {f}  /* speeds */
#define NY {y}  /* state y */
#define NU {u}  /* inputs u */
#define NOUT {out}  /* outputs */
#define NM {h}  /* constraints */
#define NG {ng}  /* of them with a position */

static inline double power_2(double x) {{ return x*x; }}
static inline double power_3(double x) {{ return x*x*x; }}
static inline double power_4(double x) {{ return (x*x)*(x*x); }}
"""

_ACCEL = """\
void accel(const double *p, const double *y, const double *u, double *M, double *f{more})
{{
    double c[NC + 1];
    eom_once(p, c);
    eom_step(c, p, y, u, M, f{filled});
}}
"""

_RHS = """\
/* accelerations and constraint forces a */
static int accelerations(const double *c, const double *p, const double *y, const double *u, double *a)
{{
    double M[N*N]{arrays};
    eom_step(c, p, y, u, M, a{filled});
{solve}
}}

/* inputs without a law are taken from u, the others are computed */
int rhs(double t, const double *c, const double *p, const double *y, double *u, double *ydot)
{{
    double a[N + NM];
    eom_feed(t, c, p, y, u);
    eom_rates(c, p, y, u, ydot);
    int bad = accelerations(c, p, y, u, a);
    for (int i = 0; i < N; i++) ydot[NQ + i] = a[i];
    return bad;
}}

/* the named outputs */
int outputs(double t, const double *c, const double *p, const double *y, double *u, double *out)
{{
    eom_feed(t, c, p, y, u);
{outputs}}}
"""

_MANY = """\
/* rhs of count states, one after the other; the number of the first (from 1) at which it fails, else 0 */
int rhs_many(int count, const double *t, const double *c, const double *p, const double *y, double *u, double *ydot)
{
    for (int i = 0; i < count; i++)
        if (rhs(t[i], c, p, y + i*NY, u + i*NU, ydot + i*NY)) return i + 1;
    return 0;
}
"""

_JAC = """\
/* d(ydot)/dy, row by row */
int jac(double t, const double *c, const double *p, const double *y, double *u, double *J)
{{
    double M[N*N], a[N + NM], K[(NY + NM)*NY]{arrays};
    eom_feed(t, c, p, y, u);
    int bad = accelerations(c, p, y, u, a);
    if (bad) return bad;
    eom_slopes(t, c, p, y, u, a, K);
    eom_step(c, p, y, u, M, a{filled});
    bad = {solve};
    for (int i = 0; i < NY*NY; i++) J[i] = K[i];
    return bad;
}}
"""


def source(program: OrderedProgram, jacobian: bool, head: list[str]) -> str:
    once, routines = compiled_routines(program, jacobian)
    ng = len(program.constraints.position) if program.constraints else 0
    comment = ["/*", *(f" * {line}".rstrip() for line in head), " */"] if head else []
    parts = [*comment, _PREAMBLE.format(ng=ng, **sizes(program, once))]
    parts += [_function(program, r) for r in routines]
    return "\n".join([*parts, *_solving(program, jacobian)])


def _solving(program: OrderedProgram, jacobian: bool) -> list[str]:
    tied = program.m > 0
    filled = ", J_, h" if tied else ""
    arrays = ", J_[NM*N], h[NM]" if tied else ""
    solve = "    return solve(N, M, a, 1);"
    if tied:
        solve = "    int bad = constrained(M, J_, a, h, 1);\n    for (int i = 0; i < NM; i++) a[N + i] = h[i];"
        solve += "\n    return bad;"
    out = "    eom_outputs(c, p, y, u, out);\n    return 0;\n"
    if program.outputs_need_accelerations:
        out = "    double a[N + NM];\n    int bad = accelerations(c, p, y, u, a);\n"
        out += "    eom_outputs(c, p, y, u, a, out);\n    return bad;\n"
    rhs = _RHS.format(arrays=arrays, filled=filled, solve=solve, outputs=out)
    accel = _ACCEL.format(more=", double *J, double *h" if tied else "", filled=", J, h" if tied else "")
    parts = [accel, solvers.SOLVE, *[solvers.CONSTRAINED] * tied, rhs, _MANY]
    if jacobian:
        many = "constrained(M, J_, K + NQ*NY, K + NY*NY, NY)" if tied else "solve(N, M, K + NQ*NY, NY)"
        parts.append(_JAC.format(arrays=arrays, filled=filled, solve=many))
    return parts


def _function(program: OrderedProgram, r: Routine) -> str:
    w = Writer(CText, r.known)
    arguments = ", ".join(
        "double t" if a == "t" else f"{'' if a in r.changed else 'const '}double *{a}" for a in r.arguments
    )
    lines = [f"{'static ' if r.internal else ''}void eom_{r.name}({arguments})", "{"]
    lines += [f"    const double {w.add(s)} = {a}[{i}];" for a, i, s in r.reads]
    lines += [f"    const double {w.add(s)} = {w(e)};" for s, e in r.body]
    lines += [f"    (void){a};" for a in r.unused]
    lines += [f"    {a}[{i}] = {w(e)};" for a, i, e in r.results]
    return "\n".join([*lines, "}", ""])
