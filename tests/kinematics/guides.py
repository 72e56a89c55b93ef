"""Leaf-spring guides with a rigid coupler, as input text, and the textbook stiffness of their coupler.

n leaf springs (clamped at y = 0, height L, at x = 0, d, 2 d, ...) carry one rigid coupler. With one element a leaf the
guide is over-constrained 6 (n - 1) times, and its six degrees of freedom are those of the coupler as a rigid body.
"""

import numpy as np
from scipy.linalg import eigh

L, D, W, T = 0.1, 0.05, 0.05, 5e-4  # height, distance, width (along z), thickness [m]
E, G, RHO = 2.1e11, 8.0e10, 7800.0
EA, EIY, EIZ, GIT = E * W * T, E * W * T**3 / 12, E * T * W**3 / 12, G * W * T**3 / 3
MASS, INERTIA = 0.16875, (2e-4, 0.0, 0.0, 3e-4, 0.0, 4e-4)  # of the coupler, at the top of the first leaf


def guide(n: int, coupler: str = "", more: str = "", load: float = 0.0, mass: bool = False) -> str:
    """Input text; leaf i has the element number 2 i + 1, the coupler between leaf i - 1 and i the number 2 i.

    `coupler` and `more` are further lines of the kinematics and dynamics block; `mass`: leaves and coupler have their
    distributed mass, else there is a rigid body on node 3, 4.
    """
    kin, dyn = [], []
    for i in range(n):
        b = 6 * i
        kin += [f"X {b + 1} {D * i!r} 0. 0.", f"X {b + 3} {D * i!r} {L} 0.", f"FIX {b + 1}", f"FIX {b + 2}"]
        kin += [f"BEAM {2 * i + 1} {b + 1} {b + 2} {b + 3} {b + 4} 0. 0. 1.", f"DYNE {2 * i + 1}   % leaf {i + 1}"]
        dyn += [f"ESTIFF {2 * i + 1} {EA!r} {GIT!r} {EIY!r} {EIZ!r}"]
        if mass:
            dyn += [f"EM {2 * i + 1} {RHO * W * T!r}"]
        if i:
            kin += [f"BEAM {2 * i} {b - 3} {b - 2} {b + 3} {b + 4} 0. 0. 1."]
            if mass:
                dyn += [f"EM {2 * i} {MASS / D!r} 1e-3 2e-3 2e-3"]
    if not mass:
        dyn += [f"XM 3 {MASS}", f"XM 4 {' '.join(map(str, INERTIA))}"]
    if load:
        dyn += [f"XF 3 {load!r} 0. 0."]
    return "\n".join([*kin, coupler, "END HALT", *dyn, more, "END END\n"])


def coupler_stiffness(n: int) -> np.ndarray:
    """(6, 6) of the rigid coupler at the top of the first leaf, displacement then rotation: textbook cantilevers.

    A cantilever along y bends along a with EI: force 12 EI/L^3 u - 6 EI/L^2 s, moment -6 EI/L^2 u + 4 EI/L s, where
    s is the rotation about y x a. The tips of the leaves follow the coupler, u_i = u + theta x r_i.
    """
    axis = np.array([0.0, 1.0, 0.0])
    K = np.zeros((6, 6))
    for i in range(n):
        k = np.zeros((6, 6))
        k[:3, :3] += EA / L * np.outer(axis, axis)
        k[3:, 3:] += GIT / L * np.outer(axis, axis)
        for direction, EI in (((1.0, 0.0, 0.0), EIY), ((0.0, 0.0, 1.0), EIZ)):
            a = np.array(direction)
            v = np.zeros((6, 2))
            v[:3, 0], v[3:, 1] = a, np.cross(axis, a)
            k += v @ (EI * np.array([[12 / L**3, -6 / L**2], [-6 / L**2, 4 / L]])) @ v.T
        x, y, z = D * i, 0.0, 0.0
        S = np.eye(6)
        S[:3, 3:] = -np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        K += S.T @ k @ S
    return K


def coupler_frequencies(n: int) -> np.ndarray:
    """omega [rad/s], ascending, of the coupler as a rigid body on massless leaves."""
    xx, xy, xz, yy, yz, zz = INERTIA
    M = np.zeros((6, 6))
    M[:3, :3] = MASS * np.eye(3)
    M[3:, 3:] = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    return np.sqrt(eigh(coupler_stiffness(n), M, eigvals_only=True))
