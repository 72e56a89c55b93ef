"""What modes 4 and 9 store of the linearized equations: matrices and state space, or of a large model the sparse form.

asp, bsp, csp  (entries, 3): row, column (from 1), value of A, B, C of `spacar.linear.descriptor`, the same places at
               all steps;  A, B, C, D of such a model follow from them when somebody asks for them
"""

from __future__ import annotations

import numpy as np

from spacar.arrays import Array
from spacar.deck.rewrite.divide import stiffness_modes
from spacar.dynamics.array_evaluator import Dynamics
from spacar.frame import Frame
from spacar.linear.descriptor_modes import lowest_modes
from spacar.linear.idle_inputs import IdleInputs
from spacar.linear.large_results import vibration_motions
from spacar.linear.linearization_signals import linearization_signals
from spacar.linear.sparse_linearization import SparseLinearization
from spacar.linear.state_space import chosen_rows, has_feedthrough, state_space
from spacar.linearization.coefficients import coefficients
from spacar.linearization.matrices import Linearization
from spacar.mechanism import Mechanism
from spacar.stream import Run


class StoredSystem:
    """Adds the linearized equations to the frames of one run, and announces the signals in its header.

    sparse  in the sparse form, with the `wanted` lowest modes (0: none);  may_move  whether states have velocities
    """

    def __init__(self, run: Run, sparse: bool, wanted: int, may_move: bool) -> None:
        self.run, self.sparse, self.wanted, self.may_move = run, sparse, wanted, may_move
        self.inputs, self.outputs = linearization_signals(run.mechanism)
        n = run.mechanism.numbering
        run.header.update(NNOM=len(self.inputs), NX=n.nkddof + n.nddof, NU=len(self.inputs), NY=len(self.outputs))
        run.header.update(NRBM=n.nddof - _elastic(run.mechanism), X0=np.zeros(n.nkddof + n.nddof))
        run.header.update(inputs=[s.name for s in self.inputs], outputs=[s.name for s in self.outputs])
        if sparse:
            run.header["DFT"] = int(has_feedthrough(self.inputs, self.outputs))
        self.idle = IdleInputs(self.inputs)
        self._linearization: SparseLinearization | None = None

    def add_sparse(self, frame: Frame, dynamics: Dynamics, xdd: Array, sigma: Array, t: float) -> None:
        """The sparse form at the placed state, and its lowest modes. Raises AnalysisError for a singular mass."""
        if self._linearization is None:
            self._linearization = SparseLinearization(dynamics, self.inputs, self.outputs, self.may_move)
        system = self._linearization(coefficients(dynamics, xdd, sigma, t=t))
        self.idle.see_sparse(self._linearization, system)
        frame.state_space.update({f"{name.lower()}sp": table for name, table in system.entries().items()})
        if self.wanted:
            n = dynamics.numbering
            modes = lowest_modes(system, n.nkddof, n.nx, self.run.report, min(self.wanted, n.nddof))
            frame.matrices["eigval"] = np.column_stack((modes.values.real, modes.values.imag))
            frame.matrices["eigvre"], frame.matrices["eigvim"] = modes.vectors.real, modes.vectors.imag
            frame.matrices.update(vibration_motions(modes))

    def add(self, frame: Frame, L: Linearization, dynamics: Dynamics) -> None:
        """A, B, C, D and the matrices of the same equations."""
        ss = state_space(dynamics, L, self.inputs, self.outputs)
        q, s = chosen_rows(L, dynamics)
        if self.inputs and len(q):
            n = dynamics.numbering
            frame.matrices["b0"] = (L.m0[np.ix_(q, q)] @ ss.B[len(s) :]).reshape(n.nddof, len(self.inputs))
        store = frame.state_space
        store["A"], store["B"], store["C"] = ss.A, ss.B, ss.C
        if has_feedthrough(self.inputs, self.outputs):
            store["D"] = ss.D
        if len(q):
            store["m0"], store["c0b"] = L.m0[np.ix_(q, q)], L.damping[np.ix_(q, q)]
            store["k0b"] = L.stiffness[np.ix_(q, s)]
        self.idle.see(dynamics, L)


def _elastic(mechanism: Mechanism) -> int:
    """The number of dynamic deformations with stiffness; the other degrees of freedom are those of rigid bodies."""
    stiffness, n = stiffness_modes(mechanism.deck.statements), mechanism.numbering
    dynamic = n.e_class["dynamic"]
    owners = map(n.e_owner, range(dynamic.start, dynamic.stop))
    return sum(bool(stiffness.get(element, {}).get(mode)) for element, mode in owners)
