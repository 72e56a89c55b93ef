"""Systems and quadrature that several tests of this room build."""

from functools import cache
from typing import Any

import mpmath as mp
import numpy as np

from spacar.symbolic import MultibodySystem


def pendulum() -> tuple[Any, Any, Any]:
    """A particle m on a massless arm L, at an angle q with the speed s from the horizontal: system, frame, point."""
    S = MultibodySystem(gravity=("0", "-g", "0"))
    q, _ = S.coordinate("q", speed="s")
    m, L = S.parameters("m L")
    A = S.frame("A", S.N, 3, q)
    P = S.point("P", S.O, L * A[1])
    S.particle("bob", P, m)
    return S, A, P


def links(count: int) -> tuple[Any, Any, Any]:
    """Rigid rods in a row in the plane: system, frame and end of the last one."""
    S = MultibodySystem(gravity=("0", "-g", "0"))
    frame, end = S.N, S.O
    for i in range(1, count + 1):
        q, _ = S.coordinate(f"q{i}", speed=f"s{i}")
        frame = S.frame(f"B{i}", frame, 3, q)
        middle = S.point(f"C{i}", end, S.expression("L/2") * frame[1])
        S.rigid_body(f"body{i}", frame, middle, "m", (0, 0, "J"))
        end = S.point(f"P{i}", end, S.expression("L") * frame[1])
    return S, frame, end


@cache
def gauss(nodes: int) -> list[tuple[Any, Any]]:
    """Places and weights on [0, 1], to 120 digits."""
    with mp.workdps(120):
        P = lambda x: mp.legendre(nodes, x)  # noqa: E731
        guesses = np.polynomial.legendre.leggauss(nodes)[0]
        roots = [mp.findroot(P, (mp.mpf(x), mp.mpf(x) + mp.mpf(10) ** -12)) for x in guesses]
        return [((1 + x) / 2, 1 / ((1 - x * x) * mp.diff(P, x) ** 2)) for x in roots]
