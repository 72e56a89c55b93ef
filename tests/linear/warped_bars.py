"""A straight bar along x of BEAMW elements: nodes 3k+1, 3k+2, 3k+3 (position, orientation, warping) at station k."""

from typing import Any

from spacar.deck import Deck


def bar(
    n: int,
    mode: int,
    stiffness: dict[str, float],
    *,
    length: float = 1.0,
    mass: tuple[float, ...] = (),
    dynamic: tuple[int, ...] = (1, 2, 3, 4, 5, 6),
    released: tuple[int, ...] = (),
    prescribed: tuple[int, ...] = (),
    fixed: Any = ((1,), (2,), (3,)),
    f1: float = 0.0,
    loads: Any = (),
    shear: tuple[float, float] = (0.0, 0.0),
) -> Deck:
    """n elements; stiffness EA GIt EIy EIz ECw (missing: 0); fixed: arguments of FIX; loads: rows of the dynamics
    block; released: dynamic modes of the first element that are calculable; prescribed: arguments of INPUTX."""
    coefficients = [stiffness.get(k, 0.0) for k in ("EA", "GIt", "EIy", "EIz")]
    kinematics: list[Any] = []
    dynamics: list[Any] = list(loads)
    for k in range(n):
        nodes = range(3 * k + 1, 3 * k + 7)
        kinematics += [("BEAMW", k + 1, *nodes, 0.0, 1.0, 0.0, f1), ("X", 3 * k + 4, length * (k + 1) / n, 0.0, 0.0)]
        free = released if k == 0 else ()
        kinematics.append(("DYNE", k + 1, *(m for m in dynamic if m not in free)))
        if free:
            kinematics.append(("RLSE", 1, *free))
        dynamics.append(("ESTIFF", k + 1, *coefficients, *shear, stiffness.get("ECw", 0.0)))
        if mass:
            dynamics.append(("EM", k + 1, *mass))
    kinematics += [("FIX", *row) for row in fixed]
    if prescribed:
        kinematics.append(("INPUTX", *prescribed))
    return Deck.build(kinematics, dynamics, mode=mode)
