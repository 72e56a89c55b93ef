"""Inputs that do not act on the states: their column of B is zero, and the warning says what to write instead.

The value, the rate and the acceleration of a prescribed coordinate are three independent inputs (INX, INXP, INXDP):
they act through the stiffness K, the damping C and the mass M between it and the dynamic degrees of freedom (and the
kinematic coordinates of wheels), so the road input of a car on springs is INX, and INXP only where a damper touches the
road. A force or stress acts where its coordinate or deformation moves with them. An entry X_qr of K, C or M counts as
zero when it is rounding of sqrt(|X_qq X_rr|), which bounds it in a positive semidefinite matrix.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from spacar.arrays import Array, Index
from spacar.dynamics.array_evaluator import Dynamics
from spacar.linear.backward_error import EPS
from spacar.linear.descriptor import DescriptorSystem
from spacar.linear.sparse_linearization import SparseLinearization
from spacar.linear.state_space import Signal, chosen_rows
from spacar.linearization.matrices import Linearization

NOISE = 1e3  # times the rounding that three random probes show: what acts exceeds it by far
SERIES = {"INX": ("INX", "INXP", "INXDP"), "INE": ("INE", "INEP", "INEDP")}


class IdleInputs:
    """Watches the steps of a run; `lines` are the warnings after the last one."""

    def __init__(self, inputs: Sequence[Signal]) -> None:
        self.inputs = inputs
        # Columns value, rate, acceleration; forces and stresses use the first one only.
        self.acting = np.zeros((len(inputs), 3), bool)
        self.has_states = False

    def see(self, dynamics: Dynamics, L: Linearization) -> None:
        """Note which inputs act at this linearization."""
        n = dynamics.numbering
        q, _ = chosen_rows(L, dynamics)
        self.has_states = self.has_states or bool(len(q))
        rows = {("INX", int(i)): k for k, i in enumerate(n.q_x)}
        rows |= {("INE", int(i)): len(n.q_x) + k for k, i in enumerate(n.q_e)}
        for j, signal in enumerate(self.inputs):
            if signal.kind[:3] in SERIES:
                r = rows[signal.kind[:3], signal.index]
                couplings = (L.stiffness[:, : n.ndof], L.damping, L.m0)
                self.acting[j] |= [_couples(X, q, r) for X in couplings]
                self.acting[j] |= [L.bk0[n.ndof :, r].any(), L.ak0[n.ndof :, r].any(), False]
            else:
                transfer = L.W if signal.kind == "INPUTF" else L.We
                self.acting[j, 0] |= bool(
                    np.any(np.abs(transfer[signal.index, q]) > n.ndof * EPS * np.abs(transfer[:, q]).max(axis=0))
                ) if len(q) else False  # fmt: skip

    def see_sparse(self, linearization: SparseLinearization, system: DescriptorSystem) -> None:
        """The same for a large model: B of the values, rates and accelerations compared with the rounding in it."""
        self.has_states = True
        if self.all_acted:
            return
        tried = [(j, k, Signal(kind, signal.index, signal.name)) for j, signal in enumerate(self.inputs)
                 for k, kind in enumerate(SERIES.get(signal.kind[:3], (signal.kind,)))]  # fmt: skip
        B = linearization.input_matrix([signal for _, _, signal in tried])
        effect, rounding = system.effects(B)
        acts = np.any(np.abs(effect) > NOISE * rounding, axis=0)
        for (j, k, _), acting in zip(tried, acts.tolist(), strict=True):
            self.acting[j, k] |= acting

    @property
    def all_acted(self) -> bool:
        """Did every input act at some step?"""
        return not any(self._idle(j) for j in range(len(self.inputs)))

    def lines(self) -> list[str]:
        """One warning for every input that acted at no step."""
        return [self._line(j) for j in range(len(self.inputs)) if self._idle(j)] if self.has_states else []

    def _idle(self, j: int) -> bool:
        kind = self.inputs[j].kind
        return not self.acting[j, SERIES[kind[:3]].index(kind) if kind[:3] in SERIES else 0]

    def _line(self, j: int) -> str:
        signal = self.inputs[j]
        kind = signal.kind
        start = (
            f"warning: input {j + 1} ({signal.name}) does not act on the dynamic degrees of freedom: its column of B is"
            " zero; "
        )
        if kind[:3] not in SERIES:
            what, write = ("coordinate", "DYNX") if kind == "INPUTF" else ("deformation", "DYNE")
            return (
                f"{start}the {what} does not move with them; make it a degree of freedom ({write}), or name another one"
            )
        series = SERIES[kind[:3]]
        acting = [name for name, acts in zip(series, self.acting[j], strict=True) if acts]
        what, free = ("coordinate", "DYNX and INPUTF") if kind[:3] == "INX" else ("deformation", "DYNE and INPUTS")
        quantity = ("value", "rate", "acceleration")[series.index(kind)]
        if acting:
            names = " and ".join(acting)
            missing = ("spring", "damper", "mass")[series.index(kind)]
            return (
                f"{start}no {missing} couples its {quantity} to them, and {', '.join(series)} are independent inputs;"
                f" write {names} {j + 1} ... for this {what}, or {free} if it is to move by a force"
            )
        return f"{start}nothing couples this {what} to them; name another one, or {free} if it is to move by a force"


def _couples(X: Array, q: Index, r: int) -> bool:
    """Is any X[q, r] more than rounding?"""
    diagonal = np.abs(np.diag(X))
    size = np.sqrt(diagonal[q] * diagonal[r])
    entries = np.abs(X[q, r])
    # without a diagonal (indefinite couplings) any entry counts
    return bool(np.any(entries > len(X) * EPS * size))
