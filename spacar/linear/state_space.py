"""State space matrices for the inputs and outputs of modes 3, 4 and 9 (theory-system.md section 5).

State z = (ds, dqd) with s = (q, k) and qd restricted to the chosen rows (dynamic ones; all in mode 3).

    A = [Bk0, Ak0; -M^-1 K, -M^-1 C],   B = [Bk0 P0 + Ak0 P1; M^-1 B0]                                        (15)
    B0 = W^T E_f + s_u We^T E_sigma - M0 P2 - (C0 + D0) P1 - (K0 + N0 + G0) P0                                 (14)

E_f, E_sigma select forces and driving stresses, P0, P1, P2 values, rates and accelerations of prescribed degrees of
freedom (independent inputs). s_u = +1: an actuator input is the driving force that does positive work on its rate.
Outputs are linear in (ds, dqd, dqdd) and the inputs; reactions come from the linearized equilibrium (section 5.3).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.linearization.coefficients import Coefficients
from spacar.linearization.matrices import Linearization, chosen_rows, require_mass, solve_mass, state_matrix
from spacar.linearization.signals import DRIVING_SIGN, ORDER, Signal, prescribed_row


class StateSpace(NamedTuple):
    """dz/dt = A z + B u, y = C z + D u."""

    A: Array
    B: Array
    C: Array
    D: Array


def state_space(
    dynamics: Dynamics,
    L: Linearization,
    inputs: Sequence[Signal],
    outputs: Sequence[Signal],
    *,
    everything: bool = False,
) -> StateSpace:
    """Matrices for the given signals. `everything` takes all rows of q as states (mode 3)."""
    n = dynamics.numbering
    q, s = chosen_rows(n, everything)
    require_mass(L, q)
    A = state_matrix(L, q, s)
    P = _prescribed(dynamics, inputs)
    Ef, Es = _unit(n.nx, inputs, "INPUTF"), _unit(n.ne, inputs, "INPUTS")
    P0s = np.vstack((P[0], np.zeros((n.nk, len(inputs)))))
    B0 = (
        L.W.T @ Ef + DRIVING_SIGN * L.We.T @ Es
        - L.m0 @ P[2] - L.damping @ P[1] - L.stiffness @ P0s
    )[q]  # fmt: skip
    ns = len(s)
    B = np.zeros((len(A), len(inputs)))
    B[:ns] = (L.bk0 @ P0s + L.ak0 @ P[1])[s]
    B[ns:] = solve_mass(L.m0[np.ix_(q, q)], B0) if len(q) else B0
    nz, nu = B.shape
    ds, dqd, dqdd = np.zeros((n.nkdof, nz + nu)), np.zeros((n.ndof, nz + nu)), np.zeros((n.ndof, nz + nu))
    ds[s, np.arange(ns)] = 1.0
    dqd[q, ns + np.arange(len(q))] = 1.0
    ds[:, nz:] += P0s
    dqd[:, nz:] += P[1]
    dqdd[:, nz:] += P[2]
    dqdd[q] += np.hstack((A, B))[ns:]
    # every output as a linear map of z (first columns) and u (last columns)
    maps = {
        "OUTX": lambda: L.G @ ds,
        "OUTXP": lambda: L.W @ dqd + L.Z @ ds,
        "OUTXDP": lambda: L.W @ dqdd + L.Yv @ dqd + L.Y @ ds,
        "OUTE": lambda: L.Ge @ ds,
        "OUTEP": lambda: L.We @ dqd + L.Ze @ ds,
        "OUTEDP": lambda: L.We @ dqdd + L.Yev @ dqd + L.Ye @ ds,
    }
    kinds = {signal.kind for signal in outputs}
    rows = {kind: maps[kind]() for kind in kinds if kind in maps}
    if kinds & {"OUTS", "OUTF"}:
        changes = [maps[kind]() for kind in maps]
        rows["OUTS"], rows["OUTF"] = _reactions(dynamics, L.c, changes, Ef, Es, nz)
    table = np.array([rows[signal.kind][signal.index] for signal in outputs]).reshape(len(outputs), nz + nu)
    return StateSpace(A, B, table[:, :nz], table[:, nz:])


def _unit(size: int, signals: Sequence[Signal], kind: str) -> Array:
    E = np.zeros((size, len(signals)))
    for j, signal in enumerate(signals):
        if signal.kind == kind:
            E[signal.index, j] = 1.0
    return E


def _prescribed(dynamics: Dynamics, inputs: Sequence[Signal]) -> Array:
    """P0, P1, P2: (3, ndof, number of inputs)."""
    n = dynamics.numbering
    P = np.zeros((3, n.ndof, len(inputs)))
    for j, signal in enumerate(inputs):
        if signal.kind in ORDER:
            P[ORDER[signal.kind], prescribed_row(n, signal), j] = 1.0
    return P


def _reactions(
    dynamics: Dynamics, c: Coefficients, changes: list[Array], Ef: Array, Es: Array, nz: int
) -> tuple[Array, Array]:
    """Changes of all stresses (ne, .) and of the total external forces fxtot (nx, .) with those of x, e and rates."""
    k, n = dynamics.kinematics, dynamics.numbering
    dx, dxd, dxdd, de, ded, dedd = changes
    free = np.arange(n.e_class["input"].stop, n.ne)
    dsigma = np.zeros_like(de)
    dsigma[free] = (c.S @ de + c.Sd @ ded + c.stress_x @ dx + c.stress_v @ dxd)[free]
    dsigma[free, nz:] -= DRIVING_SIGN * Es[free]
    force = c.M @ dxdd + c.inertia_v @ dxd + (c.inertia_x + c.geometric) @ dx
    if dynamics.coupling.present:
        i, j, value = dynamics.coupling.table
        stress = np.zeros_like(dedd)
        np.add.at(stress, i, value[:, None] * dedd[j])
        force += c.V.T @ stress
    applied = np.zeros_like(force)
    applied[:, nz:] = Ef
    multipliers = dsigma.copy()
    multipliers[k.E] = 0.0
    residual = force + (c.load_x + c.user_x) @ dx + c.user_v @ dxd - applied + c.V.T @ multipliers
    multipliers[k.E] = k.velocity_system.solve_transposed(-residual[k.U])
    total = force + c.V.T @ multipliers
    constrained = np.arange(n.e_class["input"].stop)
    dsigma[constrained] = multipliers[constrained]
    return dsigma, total
