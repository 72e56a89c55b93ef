"""The compiled engine: equations of motion and steps of the integrators in C, for holonomic mechanisms.

NumPy spends about a microsecond per call however small the arrays are; a slider-crank needs some hundred calls per
evaluation. Here the same equations run in C:

    engine.h   structures and functions that both sides read (`interface`); sizes are compared when the engine is loaded
    lanes.c    the number type: one double, or eight of as many cases that differ in numbers only
    memory.c   memory that is cut piece by piece and given back as a whole
    generated/kernels.c  the element functions, which `generator` derives from the definitions in SymPy beside the
               element families, which share nothing with them
    sparse.c   sparse LU in an order of the pivots that is chosen from numbers and kept as long as it is good
    elements.c what Python gives, the model, and its elements
    motion.c   what is given, Newton's iteration, accelerations from the saddle-point form or, with few degrees of
               freedom, from the reduced form
    rigid_tree.c, tree_motion.c  mechanisms without loops whose positions need no equations: found, and evaluated;
               tree_blocks.c has V of them by blocks, for stresses and the condition
    state.c    states of the integrators: right-hand side, stages of a Runge-Kutta step
    outputs.c  everything of a state, as frames have it
    spec.c     what a model is made of; model.c which entries V and M have; last_state.c answers what Python asks of a
               state
    stepper.c    accepted steps from output to output, by adams.c and runge_kutta.c
    radau.c    Newton's iteration of the stages of a Radau step, whose control stays in Python
    batches.c  all elements of a batch at a state, as the families of `spacar.elements` give them: what statics and
               linearized equations need (`compiled_elements`), with generated/derivatives.c
    equilibrium.c  states at rest, for `spacar.stationary.equilibrium`: structures, flexibility of the elements, places
               in the band; rest_equations.c has residual and tangent, rest_newton.c Newton's iteration, definite.c
               proves stability, band.c and dense.c have the linear systems

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
