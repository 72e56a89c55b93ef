"""The compiled engine: equations of motion and steps of the integrators in C, for holonomic mechanisms.

NumPy spends about a microsecond per call however small the arrays are; a slider-crank needs some hundred calls per
evaluation. Here the same equations run in C. Each file says at its head what it has, engine.c in which order they are
read: lanes.c is the number type, engine.h what both sides read, generated/kernels.c and derivatives.c the functions of
the elements, which `generator` derives from the definitions in SymPy beside the families and which share nothing with
them. docs/engine.md tells what runs where.

What has no form in C (user functions, some elements, motions that are no polynomials) is evaluated in Python
(`user_callbacks`); C calls the user function of a single case itself (`python_callbacks`). The engine is built with the
package where there is a C compiler and used by default; --general, SPACAR_GENERAL=1 or `compiled=False` take NumPy
instead, which gives the same results to rounding at one state (tests/compiled). In batches of a sweep `cases` puts a
case into every lane.

Limitation: both paths look for dead points by the same rule, at accepted steps. But rounding may lead them to different
steps, and with wide tolerances a step can jump over a dead point. An integration that is reflected there instead of
passing through has gone wrong, and one path may report this where the other does not see it. Tighter tolerances help
both. README.md tells users the same.
"""

from spacar.compiled.compiled_elements import mechanism_of
from spacar.compiled.compiled_evaluator import CompiledDynamics
from spacar.compiled.compiled_model import is_compiled, why_general, why_not_in_lanes
from spacar.compiled.library import level

__all__ = ["CompiledDynamics", "is_compiled", "level", "mechanism_of", "why_general", "why_not_in_lanes"]
