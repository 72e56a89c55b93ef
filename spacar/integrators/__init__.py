"""Integration in time (INTEGRAT, ERROR): one table of codes and one function, `integrate`."""

from .drive import integrate, steps
from .methods import AUTOMATIC, METHODS, NAMES, Method, named
from .problem import IntegrationStatistics, Output, Problem, Step, Tolerance
from .times import MOST_STEPS, EvenTimes

__all__ = [
    "AUTOMATIC", "METHODS", "MOST_STEPS", "NAMES", "EvenTimes", "IntegrationStatistics", "Method", "Output", "Problem",
    "Step", "Tolerance", "integrate", "named", "steps",
]  # fmt: skip
