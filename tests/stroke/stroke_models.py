"""Planar flexures of two leaf springs with a rigid body between their ends, as texts."""

import numpy as np

LENGTH, WIDTH, THICKNESS, E, RHO = 0.1, 0.05, 5e-4, 210e9, 7800.0
EA, EI = E * WIDTH * THICKNESS, E * WIDTH * THICKNESS**3 / 12.0
BODY = 0.5  # kg
GUIDE = ((-0.05, 0.0), (-0.05, 0.1), (0.05, 0.0), (0.05, 0.1))
CROSS = ((0.0, 0.0), (0.1, 0.1), (0.1, 0.0), (0.0, 0.1))


def two_leaves(
    ends: tuple[tuple[float, float], ...], n: int, kinematics: tuple[str, ...] = (), dynamics: tuple[str, ...] = ()
) -> str:
    """Leaves ends[0]-ends[1] and ends[2]-ends[3], n beams each; the body is rigid.

    Nodes: 1, 2 and 3, 4 clamps; 5, 6 the body at the end of the first leaf, 7 its place at the end of the second, 9 the
    middle between them. Every deformation is dynamic but those of the last beam of the second leaf, which the body
    determines; where `kinematics` prescribes the body, so is mode 2 of the last beam of the first leaf.
    """
    lines = [f"X {k} {x!r} {y!r}" for k, (x, y) in zip((1, 5, 3, 7), ends, strict=True)]
    middle = 0.5 * (np.array(ends[1]) + np.array(ends[3]))
    lines += [f"X 9 {middle[0]} {middle[1]}", "PLRBEAM 1 5 6 7", "PLRBEAM 2 5 6 9"]
    node, element = 10, 3
    stiff = []
    for first, (p, q), last in ((1, ends[:2], 5), (3, ends[2:], 7)):
        before = first
        for k in range(1, n + 1):
            after, turn = (last, 6) if k == n else (node, node + 1)
            if k < n:
                x, y = (np.array(p) + k / n * (np.array(q) - np.array(p))).tolist()
                lines.append(f"X {node} {x!r} {y!r}")
                node += 2
            lines.append(f"PLBEAM {element} {before} {before + 1} {after} {turn}")
            ending = k == n
            if ending and last == 7:
                lines.append(f"RLSE {element} 1 2 3")
            elif ending and any(s.startswith("INPUT") for s in kinematics):
                lines += [f"DYNE {element} 1 3", f"RLSE {element} 2"]
            else:
                lines.append(f"DYNE {element}")
            stiff += [f"ESTIFF {element} {EA!r} {EI!r}", f"EM {element} {RHO * WIDTH * THICKNESS!r}"]
            before, element = after, element + 1
    lines += ["FIX 1", "FIX 2", "FIX 3", "FIX 4", *kinematics, "END", "HALT", *stiff]
    lines += [f"XM 5 {BODY / 2!r}", f"XM 7 {BODY / 2!r}", f"XM 6 {BODY * 1e-3!r}", *dynamics, "END", "END"]
    return "\n".join(lines) + "\n"
