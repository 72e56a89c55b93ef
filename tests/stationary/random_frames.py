"""Frames that nobody has drawn: random places, stiffness over many powers of ten, rigid members, releases."""

import numpy as np

from spacar.deck import Deck, parse_deck
from spacar.dynamics.array_evaluator import Dynamics
from spacar.mechanism import build
from spacar.stationary.flexibility import Flexibility
from spacar.stationary.tangent import SparseTangent


def frame(
    seed: int, spatial: bool, ratio: float = 1.0, rigid: float = 0.0, held: bool = True,
    cells: tuple[int, ...] = (), noise: float = 0.15, warping: bool = False,
) -> Deck:  # fmt: skip
    """A grid of cells with moved nodes; stiffness between 1 and `ratio`, a part `rigid` of the members
    without any deformation, in trees. `held`: clamped at one end, else free in space. `warping`: of spatial members."""
    rng = np.random.default_rng(seed)
    cells = cells or ((3, 2, 1) if spatial else (3, 3))
    nodes = list(np.ndindex(*(k + 1 for k in cells)))
    number = {at: 2 * k + 1 for k, at in enumerate(nodes)}
    keyword = "BEAMW" if warping else "BEAM" if spatial else "PLBEAM"
    own = [lambda p: p, lambda p: p + 1, *([lambda p: 1000 + p] if warping else [])]  # nodes of a place
    lines, properties, element = [], [], 0
    root = {at: (0,) * len(cells) if held and at[0] == 0 else at for at in nodes}  # of the rigid body of a node
    for at in nodes:
        for axis in range(len(cells)):
            to = tuple(k + (a == axis) for a, k in enumerate(at))
            if to not in number or (held and at[0] == 0 and axis):
                continue
            element += 1
            p, q = number[at], number[to]
            side = " ".join(("0. 1. 0.", "0. 0. 1.", "1. 0. 0.")[axis : axis + 1]) if spatial else ""
            ends = " ".join(str(node(k)) for k in (p, q) for node in own)
            lines.append(f"{keyword} {element} {ends} {side}")
            properties.append(f"EM {element} 0.1" + (" 1e-4" if spatial else ""))
            a, b = root[at], root[to]
            if a != b and rng.random() < rigid:  # rigid members close no loops
                lowest, other = sorted((a, b))
                root = {k: lowest if r == other else r for k, r in root.items()}
            else:
                s = ratio ** rng.random()
                lines.append(f"RLSE {element}")
                stiffness = (1e3 * s, s, 1.5 * s, 1.5 * s) if spatial else (1e3 * s, s)
                stiffness += (0.0, 0.0, 0.1 * s) * warping
                properties.append(f"ESTIFF {element} " + " ".join(f"{v:.8g}" for v in stiffness))
    for at in nodes:
        place = np.array(at) + noise * rng.standard_normal(len(at))
        lines.append(f"X {number[at]} " + " ".join(f"{v:.6f}" for v in place))
        if held and at[0] == 0:
            lines += [f"FIX {node(number[at])}" for node in own]
        elif root[at] == at:
            parts = ["", " 2 3 4" if spatial else "", ""]
            lines += [f"DYNX {node(number[at])}{part}" for node, part in zip(own, parts, strict=False)]
    return parse_deck("\n".join([*lines, "END", "HALT", *properties, "END", "END", ""]), mode=7)


def tangent_of(deck: Deck, seed: int, stress: float) -> SparseTangent:
    """The tangent a little away from the reference configuration, with random stresses of the size of the critical ones
    times `stress`: states before and after buckling."""
    m = build(deck, 7)
    d = Dynamics(m)
    n = m.numbering
    rng = np.random.default_rng(seed)
    x = m.x0.copy()
    free = np.r_[n.x_class["calculable"], n.x_class["dynamic"]]
    x[free] += 0.01 * rng.standard_normal(len(free))
    d.sweep.strain(x)
    tangent = SparseTangent(d, Flexibility(d))
    tangent.sigma = stress * rng.standard_normal(n.ne)
    return tangent
