"""Integration in time (INTEGRAT, ERROR): one table of codes and one function, `integrate`."""

from .drive import integrate
from .methods import METHODS, Method
from .problem import IntegrationStatistics, Output, Problem, Step

__all__ = ["METHODS", "IntegrationStatistics", "Method", "Output", "Problem", "Step", "integrate"]
