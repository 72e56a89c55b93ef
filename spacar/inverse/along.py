"""Mode 3: matrices of the perturbation method at the steps of a nominal motion (theory-system.md 7.4), or at the
stored load steps of a stationary solution.

    M0 ddq'' + (C0+D0) dq' + (K0+N0+G0) dq = I_f^T sigma0 + s_u We[NOMS]^T du_S + W[NOMF]^T du_F          (24)

All rows of q are kept; springs and dampers of prescribed deformations enter K0 and D0 as if these were free,
while the geometric stiffness uses the stresses of the nominal (rigidified) motion. sigma0 are the stresses
of the rigidified deformations (`spacar.inverse.ports`): those that are prescribed here, rest in mode 2 and are no
actuators. Whether the file of mode 2 fixes them or prescribes them at rest makes no difference.

After a mode 7 to 10 run (file NAME_3, INPUTX replaced by DYNX) no deformation is rigidified: the flexible ones carry
their elastic stress, and the loads are those of the load steps, which the same ITERSTEP in both files tells. A
coordinate that was prescribed there is a degree of freedom here: its reaction holds it, and is part of the nominal
state as any other force.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import LoadedMechanism, StressLaw
from spacar.dynamics.mass_check import linearized_doubt
from spacar.errors import Report, UsageError
from spacar.forward.accepted_steps import at_time
from spacar.frame import Frame
from spacar.inverse.nominal import Nominal, NominalDrive
from spacar.inverse.ports import ACCELERATIONS, NominalInputs, Ports, rigidified
from spacar.inverse.trajectory import groups, loaded, named
from spacar.kinematics.constraint_condition import condition_number
from spacar.linear import form
from spacar.linear.state_space import state_space
from spacar.linearization.coefficients import Coefficients, coefficients, geometric_stiffness
from spacar.linearization.matrices import Linearization, linearize
from spacar.linearization.signals import Signal
from spacar.linearization.sparse_linearization import SparseLinearization
from spacar.mechanism.mechanism import Loads, Mechanism
from spacar.stationary.loading import LoadProgram, loads_at, with_flow

T = TypeVar("T")
MATRICES = ("m0", "c0", "d0", "k0", "n0", "g0")
# Both compare two files and are chosen: far above rounding, far below a difference in the model.
SAME_POSITION = 1e-6  # of the size of the mechanism: how far a configuration may be from that of mode 2
SAME_INPUT = 1e-6  # relative difference of the nominal inputs that is worth a warning
NO_STATE: Array = np.zeros(0)


class Along:
    """Evaluates the steps of one nominal motion in their order."""

    def __init__(self, mechanism: Mechanism, nominal: Nominal, report: Report) -> None:
        n = mechanism.numbering
        self.nominal, self.report = nominal, report
        self.ports = Ports.of(mechanism)
        self.drive = NominalDrive(nominal, mechanism)
        self.x_columns = nominal.x_columns(n)
        self.e_columns = nominal.e_columns(n)
        self.rigid = rigidified(mechanism, self.ports, nominal.rests)
        self.inputs = NominalInputs(self.ports, mechanism, report, self.rigid, elastic=nominal.stationary)
        self.signals = [
            *(Signal("INPUTS" if s.kind == "NOMS" else "INPUTF", s.index, s.name) for s in self.ports.inputs),
            *(Signal("INPUTS", int(i), f"sigma0 {n.e_name(int(i))}") for i in self.rigid),
        ]
        # OUT keywords with the same quantities as the REF keywords
        kinds = ("OUT" + s.kind.removeprefix("REF").removesuffix("S") for s in self.ports.outputs)
        self.outputs = [Signal(kind, s.index, s.name) for kind, s in zip(kinds, self.ports.outputs, strict=True)]
        self.sparse = form.stores_sparse(n.ndof, mechanism.settings, 0)
        self._descriptor: SparseLinearization | None = None
        if self.sparse:
            report.add(
                f"{n.ndof} degrees of freedom (more than {form.LARGE}): sparse linearized equations are computed, no"
                " matrices of the degrees of freedom and no second order expressions; --modes 0 or MODES 0 asks for"
                " everything"
            )
        self.zero_rows = [k for k, s in enumerate(self.ports.outputs) if s.kind in ACCELERATIONS]
        if self.zero_rows:
            report.add(
                "second time derivatives (REFEDP, REFXDP) are no outputs of the linearization; their rows"
                " of C are zero: outputs " + ", ".join(str(k + 1) for k in self.zero_rows)
            )
        if not len(self.rigid) and not nominal.stationary:
            report.add(
                "no deformation that is fixed or at rest in mode 2 is prescribed here: the linearization is that of"
                " the rigid mechanism"
            )
        self.mechanism = mechanism
        self.levels = _at_levels(mechanism, nominal) if nominal.stationary else []
        # Trajectories of this file, for their times and extra loads (TRM, TRF): nothing moves along them here.
        legs = [] if nominal.stationary else [statements for _, statements in groups(mechanism.deck)]
        self.legs = [loaded(mechanism, statements) for statements in legs]
        self.ends = np.cumsum([named(statements, "TRTIME")[0].real(0) for statements in legs])
        self.models: dict[int, Dynamics] = {}
        self.dynamics = self._dynamics(0)
        self.difference = (0.0, 0.0)

    def header(self) -> dict[str, Any]:
        """Sizes of the ltv file (files.md section 6). NRBM counts the degrees of freedom that are not rigidified."""
        ndof, second = self.mechanism.numbering.ndof, self.ports.second_order[: 0 if self.sparse else None]
        q = self.mechanism.numbering.q_names
        return {
            "NNOM": len(self.ports.inputs), "NX": 2 * ndof, "NU": len(self.signals), "NY": len(self.outputs),
            "NRBM": ndof - len(self.rigid), "DFT": 0, "X0": np.zeros(2 * ndof), "NYS": len(second),
            "states": [*q, *(f"d/dt {name}" for name in q)], "inputs": [s.name for s in self.signals],
            "outputs": [s.name for s in self.ports.outputs], **({"NYSI": second + 1} if len(second) else {}),
        }  # fmt: skip

    def frame(self, k: int) -> Frame:
        """Step k (from 0): nominal frame, matrices, state space, set-points.

        Raises AnalysisError, and UsageError when the configuration is not that of the nominal motion.
        """
        t = float(self.nominal.t[k])
        dynamics = self._dynamics(k)
        iterations = dynamics.iterations
        frame = at_time(dynamics, t, NO_STATE)
        frame.statistics = {"iterations": iterations}
        self._require_same_position(frame, k)
        u0, sigma0 = self.inputs(dynamics, frame)
        self.inputs.apply(dynamics, frame, u0)
        self._compare(u0, k)
        given = {"sig0": sigma0, "u0": u0, "y0": self.ports.reference(frame)}
        if self.sparse:
            frame.state_space.update(self._sparse(self._at(coefficients, dynamics, frame, u0), dynamics) | given)
            return frame
        L = self._at(linearize, dynamics, frame, u0)
        if k == 0:
            condition = condition_number(dynamics.kinematics)
            doubt = linearized_doubt(
                self.mechanism, lambda: dynamics.sweep, L.c.M.diagonal(), L.m0, condition, everything=True
            )
            if doubt:
                self.report.add(f"warning: {doubt}")
        for name in MATRICES:
            frame.matrices[name] = getattr(L, name)
        system = state_space(dynamics, L, self.signals, self.outputs, everything=True)
        C = system.C.copy()
        C[self.zero_rows] = 0.0
        frame.state_space.update(A=system.A, B=system.B, C=C)
        frame.state_space.update(m0=L.m0, c0b=L.damping, k0b=L.stiffness, **given)
        if len(self.ports.second_order):
            frame.state_space["G"] = self._second_order(dynamics, L)
        return frame

    def finish(self) -> None:
        """After the last step: the warnings about the nominal inputs of all steps."""
        self.inputs.finish()
        size, t = self.difference
        if size > SAME_INPUT:
            self.report.add(
                f"warning: the nominal inputs differ from those of {self.nominal.name} by {size:.3g} of their size at"
                f" t = {t:.9g}: masses, forces or extra loads (TRM, TRF) are not the same in both files"
            )

    def _dynamics(self, k: int) -> Dynamics:
        """Evaluator with the loads of step k, in the configuration of that step."""
        model = self.levels[k] if self.levels else self.mechanism
        if self.legs:
            leg = int(np.searchsorted(self.ends, self.nominal.t[k] * (1 - 1e-12)))
            model = self.legs[min(leg, len(self.legs) - 1)]
        dynamics = self.models.get(id(model))
        if dynamics is None:
            dynamics = self.models[id(model)] = Dynamics(replace(model, drive=self.drive))
            if self.nominal.stationary:  # elastic deformations are prescribed here, and act on the released ones
                dynamics.use(replace(dynamics.model, own_law=self._elastic(dynamics.loads)))
        kinematics = dynamics.kinematics
        # The configuration of mode 2 is the solution: from there Newton's method stays on its branch.
        given = dynamics.given(self.drive.at(float(self.nominal.t[k])), NO_STATE)
        e = np.where(self.e_columns >= 0, self.nominal.e[k, self.e_columns], given[1])
        kinematics.start_at(self.nominal.x[k, self.x_columns], e)
        kinematics.position(*given)
        self.dynamics = dynamics
        return dynamics

    def _require_same_position(self, frame: Frame, k: int) -> None:
        n = self.mechanism.numbering
        off = np.abs(frame.x - self.nominal.x[k, self.x_columns]) / self.mechanism.scale
        worst = int(np.argmax(off))
        if off[worst] > SAME_POSITION:
            ours, theirs = frame.x[worst], self.nominal.x[k, self.x_columns][worst]
            text = (
                f"the mechanism differs from that of {self.nominal.name}: at t = {frame.t:.9g} {n.x_name(worst)} is"
                f" {ours:.9g} here, {theirs:.9g} there; compare the X, direction and INPUT statements of both files"
            )
            raise UsageError(text, "files.different-mechanism")

    def _compare(self, u0: Array, k: int) -> None:
        stored = self.nominal.u0
        if stored is None or stored.shape[1] != len(u0) or not len(u0):
            return
        size = float(np.max(np.abs(stored)))
        difference = float(np.max(np.abs(u0 - stored[k]))) / size if size > 0.0 else 0.0
        if difference > self.difference[0]:
            self.difference = difference, float(self.nominal.t[k])

    def _sparse(self, c: Coefficients, dynamics: Dynamics) -> dict[str, Array]:
        """asp, bsp, csp of the equations with these coefficients. Raises AnalysisError for a singular mass."""
        law = self._elastic(dynamics.loads)
        self._descriptor = self._descriptor or SparseLinearization(dynamics, self.signals, self.outputs, free=law)
        system = self._descriptor(c)
        system.follow(np.zeros((system.A.shape[0] - system.n_states, 1)))  # accelerations that are unique
        tables = system.entries()
        tables["csp"] = tables["csp"][~np.isin(tables["csp"][:, 0] - 1.0, self.zero_rows)]
        return tables

    def _at(self, what: Callable[..., T], dynamics: Dynamics, frame: Frame, u0: Array) -> T:
        """`linearize` or `coefficients` over all degrees of freedom, with the nominal inputs as stresses and forces."""
        n = self.mechanism.numbering
        loads = dynamics.loads
        law, usual = self._elastic(loads), dynamics.model
        force = np.zeros(n.nx)
        for signal, value in zip(self.signals[: len(u0)], u0, strict=True):
            if signal.kind == "INPUTF":
                force[signal.index] += value
        if force.any():
            pushed = replace(loads, force=loads.force + force)
            dynamics.use(LoadedMechanism.of(dynamics.mechanism, pushed, dynamics.drive))
        try:
            return what(dynamics, frame.xdd, frame.sig, law=law, t=frame.t)
        finally:
            if dynamics.model is not usual:
                dynamics.use(usual)

    def _elastic(self, loads: Loads) -> StressLaw:
        return StressLaw.of(self.mechanism, loads, first=self.mechanism.numbering.e_class["input"].start)

    def _second_order(self, dynamics: Dynamics, L: Linearization) -> Array:
        """G of (16): one row for every output with a second order expression, from one adjoint solution each. The
        coefficient of dq_i dq_j stands in column i + ndof j.
        """
        kinematics, n = dynamics.kinematics, self.mechanism.numbering
        rows = []
        for k in self.ports.second_order:
            signal = self.ports.outputs[k]
            tau, g = np.zeros(n.ne), np.zeros(n.nx)
            if signal.kind == "REFES":
                tau[signal.index] = 1.0
                g = L.c.V[signal.index]
            else:
                g[signal.index] = 1.0
            tau[kinematics.E] -= kinematics.velocity_system.solve_transposed(g[kinematics.U])
            second = L.W.T @ geometric_stiffness(dynamics.sweep, tau) @ L.W
            rows.append(second.ravel(order="F"))
        return np.array(rows)


def _at_levels(mechanism: Mechanism, nominal: Nominal) -> list[Mechanism]:
    """The mechanism with the loads of every stored load step. Raises UsageError when their number differs."""
    levels = [level for level in LoadProgram(mechanism.settings) if level.store]
    if len(levels) != len(nominal.t):
        raise UsageError(
            f"{nominal.name} holds {len(nominal.t)} load steps, but ITERSTEP of this file asks for {len(levels)};"
            " write the same ITERSTEP in both files",
            "files.different-steps",
        )
    loads = [loads_at(mechanism, level) for level in levels]
    return [with_flow(replace(mechanism, loads=each), each) for each in loads]
