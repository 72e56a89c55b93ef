"""An optional right-hand side compiled with the system's C compiler, for holonomic mechanisms.

NumPy spends about a microsecond per call however small the arrays are; a slider-crank needs some hundred calls per
evaluation. Here the same equations run in C:

    lanes.c    the number type: one double, or eight of as many cases that differ in numbers only
    kernels.c  the element functions, generated from the definitions of the deformations in `definitions`, which share
               nothing with the hand-written element families
    sparse.c   sparse LU in an order of the pivots that is chosen from numbers and kept as long as it is good
    elements.c what Python gives, the model, and its elements
    motion.c   Newton's iteration, accelerations from the saddle-point form or, with few degrees of freedom, from the
               reduced form
    state.c    states of the integrators: right-hand side, stages of a Runge-Kutta step, frames
    model.c    which entries V and M have

Results equal those of the general path to rounding (tests/compiled). Never required: chosen with `spacar 1 FILE
--compiled` or `spacar.run(..., compiled=True)`; in batches of a sweep `cases` puts a case into every lane.

Dead points are watched by the same rule, but with wide tolerances the two paths may choose other steps there, so that a
reflection which the general path reports can pass unseen.
"""

from spacar.compiled.dynamics import CompiledDynamics
from spacar.compiled.model import why_not

__all__ = ["CompiledDynamics", "why_not"]
