"""An optional right-hand side compiled with the system's C compiler, for small holonomic mechanisms.

NumPy spends about a microsecond per call however small the arrays are; a slider-crank needs some hundred calls per
evaluation. Here the same equations run in C: the element functions (`kernels.c`) are generated from the definitions of
the deformations in `definitions`, which share nothing with the hand-written element families, and `solver.c` does
Newton's iteration and the saddle-point form in dense storage. Results equal those of the general path to rounding
(tests/compiled). Never required: chosen with `spacar 1 FILE --compiled` or `spacar.run(..., compiled=True)`.

Dead points are watched by the same rule, but with wide tolerances the two paths may choose other steps there, so that a
reflection which the general path reports can pass unseen.
"""

from spacar.compiled.dynamics import CompiledDynamics
from spacar.compiled.model import why_not

__all__ = ["CompiledDynamics", "why_not"]
