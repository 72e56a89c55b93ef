"""What modes 4 and 9 store of the linearized equations: matrices and state space, or of a large model the sparse form.

asp, bsp, csp  (entries, 3): row, column (from 1), value of A, B, C (`spacar.linearization.descriptor`), the same places
               at all steps;  A, B, C, D of such a model follow from them when somebody asks for them

Inputs that do not act on the states: their column of B is zero, and the warning says what to write instead.

The value, the rate and the acceleration of a prescribed coordinate are three independent inputs (INX, INXP, INXDP):
they act through the stiffness K, the damping C and the mass M between it and the dynamic degrees of freedom (and the
kinematic coordinates of wheels), so the road input of a car on springs is INX, and INXP only where a damper touches the
road. A force or stress acts where its coordinate or deformation moves with them. An entry X_qr of K, C or M counts as
zero when it is rounding of sqrt(|X_qq X_rr|), which bounds it in a positive semidefinite matrix.

What is stored of a large model instead of dense matrices and transfer functions (reference/files.md section 5).

ktan  (entries, 3): row, column (from 1) and value of the tangent in mixed form, theory-system.md 6.7:
      unknowns dx of the calculable and dynamic coordinates, in the order of x, then all stresses over the typical
      stiffness. Of its inverse the rows and columns of the coordinates are dx/df: the compliance.
mtan  the same of the mass matrix of these coordinates.
eigxre, eigxim  (nx, n): motions of all coordinates in the modes of vibration;  bmodex (nx, n) in those of buckling

The pattern is the same at all steps; `spconvert(ktan)` of MATLAB and `coo_array((v, (i - 1, j - 1)))` of SciPy read it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.deck.rewrite.divide import stiffness_modes
from spacar.dynamics.array_evaluator import Dynamics
from spacar.frame import Frame
from spacar.linear import form
from spacar.linear.eigen import Modes
from spacar.linear.lowest import lowest_modes
from spacar.linear.state_space import state_space
from spacar.linear_systems.linear_system import rows_of
from spacar.linearization.coefficients import coefficients
from spacar.linearization.descriptor import DescriptorSystem
from spacar.linearization.matrices import Linearization, chosen_rows
from spacar.linearization.signals import Signal, has_feedthrough, linearization_signals, prescribed_row
from spacar.linearization.sparse_linearization import SparseLinearization
from spacar.mechanism import Mechanism
from spacar.stationary.tangent import SparseTangent
from spacar.stream import Run

NOISE = 1e3  # times the rounding that three random probes show: what acts exceeds it by far
SERIES = {"INX": ("INX", "INXP", "INXDP"), "INE": ("INE", "INEP", "INEDP")}


class StoredSystem:
    """Adds the linearized equations to the frames of one run, and announces the signals in its header.

    sparse  in the sparse form, with the `wanted` lowest modes (0: none), by the size of the model and what is asked for
    may_move  whether states have velocities
    """

    def __init__(self, run: Run, may_move: bool) -> None:
        n, settings = run.mechanism.numbering, run.mechanism.settings
        self.run, self.may_move, self.wanted = run, may_move, settings.modes or 0
        self.sparse = form.stores_sparse(n.nddof, settings, self.wanted)
        self.inputs, self.outputs = linearization_signals(run.mechanism)
        run.header.update(NNOM=len(self.inputs), NX=n.nkddof + n.nddof, NU=len(self.inputs), NY=len(self.outputs))
        run.header.update(NRBM=n.nddof - _elastic(run.mechanism), X0=np.zeros(n.nkddof + n.nddof))
        run.header.update(inputs=[s.name for s in self.inputs], outputs=[s.name for s in self.outputs])
        if self.sparse:
            run.header["DFT"] = int(has_feedthrough(self.inputs, self.outputs))
            lowest = f"the {self.wanted} lowest modes with their motions and " if self.wanted else ""
            run.report.add(
                f"{n.nddof} dynamic degrees of freedom (more than {form.LARGE}): {lowest}sparse linearized equations"
                " are computed, no reduced matrices, no A, B, C, D and no transfer functions; --modes N or MODES N asks"
                " for the N lowest modes, 0 for everything"
            )
        self.idle = IdleInputs(self.inputs)
        self._linearization: SparseLinearization | None = None

    def add_sparse(
        self, frame: Frame, dynamics: Dynamics, xdd: Array, sigma: Array, t: float, modes: Modes | None = None
    ) -> None:
        """The sparse form at the placed state, and its lowest modes where the symmetric tangent has not given them.
        Raises AnalysisError for a singular mass."""
        if self._linearization is None:
            self._linearization = SparseLinearization(dynamics, self.inputs, self.outputs, self.may_move)
        system = self._linearization(coefficients(dynamics, xdd, sigma, t=t))
        self.idle.see_sparse(self._linearization, system)
        frame.state_space.update(system.entries())
        if self.wanted:
            n = dynamics.numbering
            modes = modes or lowest_modes(system, n.nkddof, n.nx, self.run.report, min(self.wanted, n.nddof))
            frame.matrices.update(modes.stored(True))

    def add(self, frame: Frame, L: Linearization, dynamics: Dynamics) -> None:
        """A, B, C, D and the matrices of the same equations."""
        ss = state_space(dynamics, L, self.inputs, self.outputs)
        q, s = chosen_rows(dynamics.numbering)
        M, C, K, *_ = L.chosen(q, s)
        if self.inputs and len(q):
            frame.matrices["b0"] = (M @ ss.B[len(s) :]).reshape(len(q), len(self.inputs))
        store = frame.state_space
        store["A"], store["B"], store["C"] = ss.A, ss.B, ss.C
        if has_feedthrough(self.inputs, self.outputs):
            store["D"] = ss.D
        if len(q):
            store["m0"], store["c0b"], store["k0b"] = M, C, K
        self.idle.see(dynamics, L)


def _elastic(mechanism: Mechanism) -> int:
    """The number of dynamic deformations with stiffness; the other degrees of freedom are those of rigid bodies."""
    stiffness, n = stiffness_modes(mechanism.deck.statements), mechanism.numbering
    dynamic = n.e_class["dynamic"]
    owners = map(n.e_owner, range(dynamic.start, dynamic.stop))
    return sum(bool(stiffness.get(element, {}).get(mode)) for element, mode in owners)


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
        q, _ = chosen_rows(n)
        self.has_states = self.has_states or bool(len(q))
        for j, signal in enumerate(self.inputs):
            if signal.kind[:3] in SERIES:
                r = prescribed_row(n, signal)
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
        if not any(map(self._idle, range(len(self.inputs)))):
            return
        tried = [(j, k, Signal(kind, signal.index, signal.name)) for j, signal in enumerate(self.inputs)
                 for k, kind in enumerate(SERIES.get(signal.kind[:3], (signal.kind,)))]  # fmt: skip
        B = linearization.input_matrix([signal for _, _, signal in tried])
        effect, rounding = system.effects(B)
        acts = np.any(np.abs(effect) > NOISE * rounding, axis=0)
        for (j, k, _), acting in zip(tried, acts.tolist(), strict=True):
            self.acting[j, k] |= acting

    def lines(self) -> list[str]:
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
    diagonal = np.abs(np.diag(X))
    size = np.sqrt(diagonal[q] * diagonal[r])
    entries = np.abs(X[q, r])
    # without a diagonal (indefinite couplings) any entry counts
    return bool(np.any(entries > len(X) * EPS * size))


def sparse_matrices(tangent: SparseTangent) -> dict[str, Array]:
    """ktan and mtan of the present state, by columns; entries that happen to be zero stay."""
    return {"ktan": _table(tangent.static_matrix()), "mtan": _table(tangent.mass_matrix())}


def _table(A: Any) -> Array:
    """Row, column and value of a matrix in compressed columns."""
    return np.column_stack((A.indices + 1.0, rows_of(A) + 1.0, A.data))
