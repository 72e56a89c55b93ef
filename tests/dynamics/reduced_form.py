"""The reduced dense form (8) of theory-system.md as an oracle: accelerations, stresses and nodal forces of a state.

Shares the element evaluations with the program and nothing else: dense matrices, explicit transfer functions.
"""

from typing import NamedTuple

import numpy as np

from spacar import Deck
from spacar.dynamics import Dynamics
from spacar.mechanism import DriveState, build


class Solution(NamedTuple):
    xdd: np.ndarray
    edd: np.ndarray
    sigma: np.ndarray
    nodal: np.ndarray  # total external forces
    condition: float  # of the reduced mass matrix, scaled to a unit diagonal


class Parts(NamedTuple):
    """Dense matrices of a placed state."""

    V: np.ndarray
    M: np.ndarray
    load: np.ndarray  # f - h
    H: np.ndarray
    sigma: np.ndarray  # constitutive
    Me: np.ndarray


def evaluator(rows: list[tuple], dynamics: list[tuple], kind: str | None = None) -> Dynamics:
    return Dynamics(build(Deck.build(rows, dynamics)), kind=kind)


def parts(d: Dynamics, t: float) -> Parts:
    """Everything at the placed state of `d`, gathered entry by entry."""
    n, sweep = d.numbering, d.sweep
    H = sweep.convective(d.xd)
    sigma, user = d.constitutive(t)
    sweep.mass()
    M = np.zeros((n.nx, n.nx))
    np.add.at(M, (sweep.m_rows, sweep.m_columns), sweep.m_entries)
    load = d.forces(d.kinematics.x, user) - d.forces.inertia(sweep, d.xd)
    Me = np.zeros((n.ne, n.ne))
    i, j, value = d.mechanism.deformation_inertia
    np.add.at(Me, (i, j), value)
    return Parts(sweep.gradient(), M, load, H, sigma.copy(), Me)


def reduced(d: Dynamics, t: float, drive: DriveState) -> Solution:
    """Equation (8) at the placed state: q'' of the dynamic degrees of freedom from the reduced mass matrix,
    then kinetostatics (10), (11).
    """
    n = d.numbering
    V, M, load, H, sigma, Me = parts(d, t)
    E = np.arange(n.e_class["dynamic"].stop)
    U = np.r_[np.arange(n.nx)[n.x_class["calculable"]], np.arange(n.nx)[n.x_class["kinematic"]]]
    given = np.setdiff1d(np.arange(n.nx), U)
    D = V[np.ix_(E, U)]

    def complete(x_given: np.ndarray, e_rows: np.ndarray) -> np.ndarray:
        x = np.zeros((n.nx, *x_given.shape[1:]))
        x[given] = x_given[given]
        x[U] = np.linalg.solve(D, e_rows[E] - V[np.ix_(E, given)] @ x[given])
        return x

    x_unit, e_unit = np.zeros((n.nx, n.ndof)), np.zeros((n.ne, n.ndof))
    x_unit[n.q_x, np.arange(len(n.q_x))] = 1.0
    e_unit[n.q_e, len(n.q_x) + np.arange(len(n.q_e))] = 1.0
    W = complete(x_unit, e_unit)
    We = V @ W
    a0 = complete(np.zeros(n.nx), -H)
    qdd = np.zeros(n.ndof)
    rheonomic = np.concatenate((drive.xdd, drive.edd))
    qdd[n.rheonomic] = rheonomic
    total = M + V.T @ Me @ V
    mass = W.T @ total @ W
    active = sigma.copy()
    active[: n.e_class["input"].stop] = 0.0
    force = W.T @ (load - M @ a0 - V.T @ (Me @ (H + V @ a0))) - We.T @ active
    dyn, rhe = n.dynamic, n.rheonomic
    reduced_mass = mass[np.ix_(dyn, dyn)]
    scale = np.sqrt(np.diag(reduced_mass))
    condition = float(np.linalg.cond(reduced_mass / np.outer(scale, scale))) if len(dyn) else 1.0
    qdd[dyn] = np.linalg.solve(reduced_mass, force[dyn] - mass[np.ix_(dyn, rhe)] @ qdd[rhe])
    xdd = W @ qdd + a0
    edd = V @ xdd + H
    inertia = M @ xdd + V.T @ (Me @ edd)
    full = sigma.copy()
    full[E] = 0.0
    multipliers = np.linalg.solve(D.T, -(inertia - load + V.T @ full)[U])
    constrained = n.e_class["input"].stop
    full[E] = multipliers
    full[constrained : len(E)] = sigma[constrained : len(E)]  # stored: constitutive for the dynamic ones
    gravity = d.forces.gravity(d.sweep)
    applied = d.loads.force + d.forces.moments(d.kinematics.x)
    nodal = inertia - load + applied + gravity + V.T @ full
    return Solution(xdd, edd, full, nodal, condition)


def difference(a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference relative to the largest entry."""
    return float(np.max(np.abs(a - b), initial=0.0) / max(np.max(np.abs(b), initial=0.0), 1e-300))


def chain(n: int, classes: str, tip: float = 0.5, uneven: float = 0.0) -> tuple[list[tuple], list[tuple]]:
    """n planar beams in a row from the origin, about 1 m each, with mass, gravity and a tip mass.

    classes 'flexible': base angle prescribed, elongations rigid, bending dynamic; 'mixed': every class once.
    """
    rng = np.random.default_rng(n)
    pieces = 1.0 + uneven * rng.uniform(-1, 1, n)
    at = np.concatenate(([0.0], np.cumsum(pieces)))
    rows: list[tuple] = []
    dynamics: list[tuple] = [("GRAVITY", 0.0, -9.81), ("XM", 2 * n + 1, tip)]
    for k in range(1, n + 1):
        p = 2 * k - 1
        rows += [("PLBEAM", k, p, p + 1, p + 2, p + 3), ("X", p + 2, float(at[k]), 0.0)]
        dynamics += [("EM", k, 2.0, 0.01), ("ESTIFF", k, 500.0, 4.0), ("EDAMP", k, 0.5, 0.004)]
    rows.append(("FIX", 1))
    if classes == "flexible":
        rows += [("INPUTX", 2), *[("DYNE", k, 2, 3) for k in range(1, n + 1)]]
        dynamics.append(("INPUTX", 2, 1, 0.1, 2.0, 30.0))
        return rows, dynamics
    for k in range(1, n + 1):
        kind = k % 5
        if kind == 0:
            rows.append(("DYNE", k))  # all three dynamic
        elif kind == 1:
            rows.append(("DYNE", k, 2, 3))
        elif kind == 2:
            rows += [("DYNE", k, 2), ("INPUTE", k, 3)]
            dynamics.append(("INPUTE", k, 3, 0.0, 0.01, 0.7))
        elif kind == 3:
            rows += [("RLSE", k, 2), ("DYNX", 2 * k + 2), ("DYNE", k, 3)]  # the angle at q instead of the bending at p
        else:
            rows.append(("DYNE", k, 3))
    rows.append(("INPUTX", 2))
    dynamics += [("INPUTX", 2, 1, 0.1, 2.0, 30.0), ("XF", 2 * n + 1, 3.0, -2.0)]
    return rows, dynamics


def random_state(d: Dynamics, bend: float, rate: float, seed: int = 0) -> np.ndarray:
    """A state around the start with deformations and rates of this size, relative to the element length or rad."""
    rng = np.random.default_rng(seed)
    y = d.start().copy()
    n = d.n_positions
    m = d.n_xm + d.n_em
    y[:m] += bend * rng.normal(size=m)
    y[n:] += rate * rng.normal(size=len(y) - n)
    return y
