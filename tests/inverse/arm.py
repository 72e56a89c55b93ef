"""A planar 2R arm with point masses at elbow and tip: decks for all modes, and its closed form.

Angles: q1 of the first link, q2 of the elbow (relative). Textbook equations of motion, gravity g downwards:

    M11 = m1 l1^2 + m2 (l1^2 + l2^2 + 2 l1 l2 cos q2), M12 = m2 (l2^2 + l1 l2 cos q2), M22 = m2 l2^2
    h1 = -m2 l1 l2 sin q2 (2 q1' q2' + q2'^2), h2 = m2 l1 l2 sin q2 q1'^2
"""

import numpy as np

from spacar import Deck

L1, L2, M1, M2, G = 0.7, 0.5, 3.0, 5.0, 9.81
Q0 = np.array([0.4, 1.1])  # start angles of both links


def elbow_and_tip(q):
    elbow = L1 * np.array([np.cos(q[0]), np.sin(q[0])])
    return elbow, elbow + L2 * np.array([np.cos(q[0] + q[1]), np.sin(q[0] + q[1])])


START = elbow_and_tip(Q0)[1]


def kinematics(driven, q=Q0):
    """`driven`: the statements that choose the degrees of freedom."""
    elbow, tip = elbow_and_tip(q)
    return [
        ("PLTOR", 1, 1, 2), ("PLBEAM", 3, 3, 2, 4, 5), ("PLTOR", 2, 5, 6), ("PLBEAM", 4, 4, 6, 7, 8),
        ("X", 3, 0.0, 0.0), ("X", 4, *map(float, elbow)), ("X", 7, *map(float, tip)), ("FIX", 1), ("FIX", 3), *driven,
    ]  # fmt: skip


DYNAMICS = [("XM", 4, M1), ("XM", 7, M2), ("GRAVITY", 0.0, -G)]
END_POINT = [("INPUTX", 7, 1), ("INPUTX", 7, 2), ("RLSE", 1, 1), ("RLSE", 2, 1)]
PRESCRIBED_JOINTS = [("INPUTE", 1, 1), ("INPUTE", 2, 1)]
FREE_JOINTS = [("DYNE", 1, 1), ("DYNE", 2, 1)]
MOTORS = [("NOMS", 1, 1, 1), ("NOMS", 2, 2, 1)]
REFERENCES = [("REFE", 1, 1, 1), ("REFE", 2, 2, 1), ("REFX", 3, 7, 1), ("REFXP", 4, 7, 1)]


def deck(driven, third=(), mode=2, dynamics=DYNAMICS, q=Q0):
    return Deck.build(kinematics(driven, q), dynamics, third, mode=mode, source="arm.dat")


def mass(q):
    c = np.cos(q[1])
    a, b = M1 * L1**2 + M2 * (L1**2 + L2**2 + 2 * L1 * L2 * c), M2 * (L2**2 + L1 * L2 * c)
    return np.array([[a, b], [b, M2 * L2**2]])


def torques(q, qd, qdd):
    s = M2 * L1 * L2 * np.sin(q[1])
    h = np.array([-s * (2 * qd[0] * qd[1] + qd[1] ** 2), s * qd[0] ** 2])
    far = M2 * G * L2 * np.cos(q[0] + q[1])
    weight = np.array([(M1 + M2) * G * L1 * np.cos(q[0]) + far, far])
    return mass(q) @ qdd + h + weight


def joints(tip, velocity, acceleration):
    """Angles, rates and accelerations of the links that give this motion of the tip (elbow on the right-hand side)."""
    r2 = float(tip @ tip)
    q2 = np.arccos((r2 - L1**2 - L2**2) / (2 * L1 * L2))
    q1 = np.arctan2(tip[1], tip[0]) - np.arctan2(L2 * np.sin(q2), L1 + L2 * np.cos(q2))
    q = np.array([q1, q2])

    def jacobian(q):
        a, b = q[0], q[0] + q[1]
        return np.array(
            [[-L1 * np.sin(a) - L2 * np.sin(b), -L2 * np.sin(b)], [L1 * np.cos(a) + L2 * np.cos(b), L2 * np.cos(b)]]
        )

    J = jacobian(q)
    qd = np.linalg.solve(J, velocity)
    a, b, w1, w2 = q[0], q[0] + q[1], qd[0], qd[0] + qd[1]
    centripetal = -(w1**2) * L1 * np.array([np.cos(a), np.sin(a)]) - w2**2 * L2 * np.array([np.cos(b), np.sin(b)])
    return q, qd, np.linalg.solve(J, acceleration - centripetal)
