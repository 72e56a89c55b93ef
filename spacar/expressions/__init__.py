"""One language for quantities of a result: `x[6,1]`, `max(sig[1,1])`, `abs(eigval[1]@end)/(2*pi)`.

`spacar plot`, `report`, `eigen --against`, `sweep --result`, `trade --variable` and `result.plot` read it; the table is
what `spacar help expressions` prints. The text is parsed by Python's grammar and every node is looked up in tables
(`grammar`, `functions`); nothing is evaluated as code.

variable      x xd xdd fx fxgrav fxtot xcompl [node, coordinate]; e ed edd sig [element, mode]; t; eigval[i] (complex);
              frequency[i] (Hz, from low to high); lmult[i]; m0 c0 d0 k0 n0 g0 [i, j]. All numbers from 1. A variable is
              a series over the stored steps.
series@when   one step: @end, @start, @7 (number of the stored step, from 1) or @0.05 (a stored time, in s)
operators     + - * / ** and numbers, pi
functions     those of `functions.FUNCTIONS`
"""

from spacar.expressions.evaluation import Variables, evaluate, evaluate_cases
from spacar.expressions.expression_units import NONE, Dimensions, Unit, combine, unit, unit_text
from spacar.expressions.functions import FUNCTIONS
from spacar.expressions.grammar import MEANING, Expression, parse
from spacar.expressions.result_places import listed, place

__all__ = [
    "FUNCTIONS", "MEANING", "NONE", "Dimensions", "Expression", "Unit", "Variables", "combine", "evaluate",
    "evaluate_cases", "listed", "parse", "place", "unit", "unit_text",
]  # fmt: skip
