"""Integration in time (INTEGRAT, ERROR): one table of codes and one function, `integrate`."""

from .drive import integrate
from .methods import METHODS, Method
from .problem import IntegrationStatistics, Output, Problem, Step
from .times import MOST_STEPS, EvenTimes

__all__ = [
    "METHODS", "MOST_STEPS", "EvenTimes", "IntegrationStatistics", "Method", "Output", "Problem", "Step", "integrate",
]  # fmt: skip
