"""Keywords of the dynamics block: methods and settings of the solvers (reference/input-language.md section 5.5)."""

from spacar.deck.table_types import BlockKind, Keyword, form, integer, real, span

_D = BlockKind.DYNAMICS

KEYWORDS = (
    Keyword(
        "INTEGRAT", _D, "integration method",
        (form((integer("type of integrator"), real("step size or initial step size", "s", 0.0))),), unique=0,
        notes=(
            "Without INTEGRAT the method chooses itself, type -1: 0, and 595 from where a vibration faster than the "
            "motion limits the steps; the log says when.",
            "Types: 0 Shampine-Gordon (what the original program takes without INTEGRAT); 130, 140 explicit "
            "Runge-Kutta of order 3, 4 with fixed step, 135, 155 of order 3, 5 with variable step; 220, 225 for second"
            " order systems, fixed and variable; 310, 320, 330 Rosenbrock; 410 implicit Euler; 420, 430 diagonally "
            "implicit Runge-Kutta. Ours: 553, 595 Radau IIA of order 5, 9 with variable step, for stiff models; 853 "
            "explicit Runge-Kutta of order 8 with variable step; -1 the default.",
        ),
    ),
    Keyword(
        "ERROR", _D, "error tolerances of the integration",
        (form((real("absolute error", "", 1e-5), real("relative error", "", 1e-4)), 1, 2),), unique=0,
        notes=(
            "Used by types 0, 135, 155, 225, 553, 595, 853; for 410, 420, 430 the absolute error is the tolerance of "
            "the Newton iteration.",
        ),
    ),
    Keyword(
        "ITERSTEP", _D, "settings of the stationary solution",
        (
            form(
                (
                    integer("maximum number of iterations", default=10), integer("number of load steps", default=4),
                    real("error tolerance: largest force out of balance", "N", 5e-7),
                    integer("number of steps between output steps", default=1),
                    integer("type of analysis 0-3", default=0),
                    integer("number of load steps for the initial solution", default=0),
                    integer("follow the equilibrium path beyond limit points: 0 no, 1 yes", default=0),
                ),
                *span(1, 7),
            ),
        ),
        unique=0,
        notes=(
            "Type 0: initial loading; 1: the same with N0 zero; 2: initial and additional loading; 3: the same with N0"
            " zero.",
            "At a limit point of the loading (snap-through) the analysis stops and says which part of the loading was "
            "reached; position 7 = 1 follows the equilibrium path beyond it to where it reaches the load again.",
        ),
    ),
    Keyword(
        "MODES", _D, "number of modes of vibration and buckling (modes 7, 8, 10; of large models also 4 and 9)",
        (form((integer("number of lowest modes; 0: all"),)),), unique=0,
        notes=(
            "Ours. Without it all modes of a model with up to 200 dynamic degrees of freedom are computed, and the 20 "
            "lowest of a larger one at rest. A larger model has sparse matrices instead of the reduced ones then; 0 "
            "asks for everything.",
            "Modes 4 and 9 store sparse equations of models with more than 200 dynamic degrees of freedom, and their n"
            " lowest modes only with MODES n; 0 asks for the reduced matrices and A, B, C, D. So does mode 3 with more"
            " than 200 degrees of freedom, prescribed ones counted, without modes.",
        ),
    ),
)  # fmt: skip

# -1, 553, 595 and 853 are ours; the others are those of the original program.
INTEGRATORS = (-1, 0, 130, 135, 140, 155, 220, 225, 310, 320, 330, 410, 420, 430, 553, 595, 853)
INTEGRATOR_ALIASES = {255: 225}  # input-language.md note d14 names both


def alias_note(code: int) -> str:
    """What is said about a code that stands for another one."""
    return f"integrator type {code} is read as {INTEGRATOR_ALIASES[code]}"
