"""What an element type states in SymPy: deformations D(x), slips, inertia, and the order of its parameters.

Each type has a module of that beside its NumPy family, `NAME_symbolic.py`, which no run imports. `kernels.c` and
`derivatives.c` are derived from all of them, and tests compare them with the families, as independent statements.

What is not said there follows by differentiation: V, H(v,v), M, h. For elements with mass the quantities y(x) are those
in which the kinetic energy is 1/2 y'^T C y' with a constant C, so that M = Y^T C Y and h = Y^T C y''(x + s v) with
Y = dy/dx.
"""

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

LEFT = 0.7  # added to the part of a length that is left, so that guards compare it with GUARD too


def no_strain(x: list, p: dict) -> list:
    return []


@dataclass(frozen=True)
class Definition:
    """One element type: number of coordinates, names of its parameters, and functions of both.

    The family of the type gives the parameters in this order (`Family.parameters`). Definitions that share a function
    share it in C when their parameters agree as far as both go.
    """

    name: str
    n_coordinates: int
    parameters: tuple[str, ...]
    strain: Callable[[list[sp.Symbol], dict[str, sp.Symbol]], list[sp.Expr]] = no_strain  # D(z)
    line: Callable[[list[sp.Symbol], dict[str, sp.Symbol]], tuple[list[sp.Expr], sp.Matrix]] | None = None  # y, C
    inertia: Callable[[list, list, dict], tuple[sp.Matrix, list]] | None = None  # M, h where no y exists
    guard: Callable[[list, dict], list] | None = None  # of z; all beyond GUARD: surely in the range of the theory
    local: Callable[[list, dict], list] | None = None  # z(x), linear in x; without it, z = x
    slips: Callable[[list, list, dict], list] | None = None  # rates (x, v, p), linear in v, that are rows of V behind D
    turn: Callable[[dict], list] | None = None  # change of D when its angle grows by a whole turn
    angle: Callable[[list, list, dict], sp.Expr] | None = None  # in which turns are counted, of x, D; without it, D[0]
    flow: Callable[[dict], tuple[sp.Matrix, sp.Matrix]] | None = None  # D, A of the force D y' + A y in h


def dot(a: list, b: list) -> sp.Expr:
    return sum(x * y for x, y in zip(a, b, strict=True))


def length(d: list) -> sp.Expr:
    return sp.sqrt(dot(d, d))
