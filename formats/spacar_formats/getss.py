"""getss: the state space matrices A, B, C, D of one step of an `.ltv` file (reference/files.md sections 6 and 7), and
its frequency response C (j omega - A)^-1 B + D; of a large model by `spacar.linearization.sparse_response`."""

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from spacar.errors import Report, UsageError
from spacar.linear.lowest import WANTED, lowest_modes
from spacar.linearization.descriptor import DescriptorSystem, of_frame
from spacar.linearization.sparse_response import response
from spacar.result import Result
from spacar_formats.exports import export_to, to_mat, to_npz
from spacar_formats.getfrsbf import stored_step
from spacar_formats.locate import open_result
from spacar_formats.safety import write_text
from spacar_formats.sbf import SbfFile
from spacar_formats.sparse_system import descriptor_of, is_sparse

SHOWN = 6  # names of one kind in a short text


@dataclass(frozen=True, slots=True, repr=False)
class StateSpaceStep:
    """dz/dt = A z + B u, y = C z + D u at time `t`: A (nx, nx), B (nx, nu), C (ny, nx), D (ny, nu) or None.

    D is None when the file says that there is no direct feedthrough. Signals are named as in the file (text
    variables XNAMES, UNAMES, YNAMES), otherwise x1, x2 ..., u1 ..., y1 ...
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray | None
    t: float
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @property
    def feedthrough(self) -> np.ndarray:
        """D, or the zero matrix in its place."""
        return np.zeros((self.C.shape[0], self.B.shape[1])) if self.D is None else self.D

    def __iter__(self) -> Iterator[np.ndarray]:
        """A, B, C, D: `A, B, C, D = system`; D zero when there is no feedthrough."""
        return iter((self.A, self.B, self.C, self.feedthrough))

    def __repr__(self) -> str:
        lines = [f"state space at t = {self.t:g}: {len(self.states)} states, {len(self.inputs)} inputs, "
                 f"{len(self.outputs)} outputs"]  # fmt: skip
        for what, names in (("states", self.states), ("inputs", self.inputs), ("outputs", self.outputs)):
            few = ", ".join(names[:SHOWN]) + (f", ... ({len(names)})" if len(names) > SHOWN else "")
            lines.append(f"  {what:<8}{few or 'none'}")
        return "\n".join(lines)

    def arrays(self) -> dict[str, np.ndarray]:
        """The matrices by name; D only if there is one."""
        found = {"A": self.A, "B": self.B, "C": self.C}
        return found if self.D is None else found | {"D": self.D}

    def to_scipy(self) -> Any:
        """As `scipy.signal.StateSpace` (continuous time)."""
        from scipy.signal import StateSpace

        return StateSpace(self.A, self.B, self.C, self.feedthrough)

    def to_control(self) -> Any:
        """As `control.ss` with named signals. Raises UsageError when python-control is not installed."""
        from spacar.simulation.control_systems import python_control

        names = {"states": list(self.states), "inputs": list(self.inputs), "outputs": list(self.outputs)}
        return python_control("files.control-missing").ss(self.A, self.B, self.C, self.feedthrough, **names)


def state_space_of(result: Result, step: int = 1) -> StateSpaceStep:
    """The same of a result in memory. Raises UsageError for a mode without state space and for no such step."""
    k = stored_step(step, len(result.frames), "the result") - 1
    found = result.frames[k].state_space
    if "asp" in found:  # a large model is stored sparse
        found = dict(zip("ABCD", of_frame(found, result.header).state_space(), strict=True))
        if not result.header["DFT"]:
            del found["D"]  # without direct feedthrough the elimination leaves only rounding there
    if "A" not in found:
        text = f"a result of mode {result.mode} has no state space; modes 3, 4 and 9 compute it"
        raise UsageError(text, "files.no-state-space")
    a = np.asarray(found["A"], float)
    b = np.asarray(found.get("B", np.zeros((len(a), 0))), float)
    c = np.asarray(found.get("C", np.zeros((0, len(a)))), float)
    d = np.asarray(found["D"], float) if "D" in found else None
    states = result.header.get("states") or result.mechanism.numbering.state_names
    inputs, outputs = (result.header.get(what, ()) for what in ("inputs", "outputs"))
    return _step(a, b, c, d, float(result.t[k]), (states, inputs, outputs))


def getss(name: str | os.PathLike[str], step: int = 1) -> StateSpaceStep:
    """The state space matrices of one step (1, 2, ...) of the `.ltv` file `name`, extension optional.

    Raises UsageError when the file, the matrices (the file of a mode 2 run has none) or the step are missing,
    when their sizes do not fit together; SbfError when the bytes are damaged.
    """
    with open_result(name, "ltv") as file:
        d: np.ndarray | None
        if is_sparse(file):
            a, b, c, d = descriptor_of(file, step).state_space()
            d = d if _has_feedthrough(file) else None  # else only rounding of the elimination
        else:
            a, b, c = (_matrix(file, ident, step) for ident in "ABC")
            d = _matrix(file, "D", step) if _has_feedthrough(file) else None
        t = file.time(step)
        (nx, nu), ny = b.shape, c.shape[0]
        if a.shape != (nx, nx) or c.shape[1] != nx or (d is not None and d.shape != (ny, nu)):
            raise UsageError(f"the sizes of A, B, C, D in {file.path} do not fit together", "files.size")
        if not all(np.isfinite(m).all() for m in (a, b, c, *([] if d is None else [d]))):
            text = f"A, B, C or D of step {step} in {file.path} has numbers that are not finite"
            raise UsageError(text, "files.finite")
        return _step(a, b, c, d, t, [file.texts(name) for name in ("XNAMES", "UNAMES", "YNAMES")])


@dataclass(frozen=True, slots=True)
class SparseStep:
    """The sparse system of a step of a large model, with the names of its inputs and outputs."""

    system: DescriptorSystem
    t: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


def linear_system(name: str | os.PathLike[str], step: int) -> StateSpaceStep | SparseStep:
    """As `getss`, but of a large model the sparse form, which nobody has to eliminate for a frequency response."""
    with open_result(name, "ltv") as file:
        if is_sparse(file):
            system = descriptor_of(file, step)
            inputs = _fitting(file.texts("UNAMES"), "u", system.B.shape[1])
            outputs = _fitting(file.texts("YNAMES"), "y", system.C.shape[0])
            return SparseStep(system, file.time(step), inputs, outputs)
    return getss(name, step)


def frequency_response(system: StateSpaceStep | SparseStep, omega: np.ndarray) -> np.ndarray:
    """(len(omega), outputs, inputs) complex; infinite where j omega is an eigenvalue. omega [rad/s]."""
    if isinstance(system, SparseStep):
        return response(system.system, omega)
    n = len(system.A)
    out = np.empty((len(omega), len(system.C), system.B.shape[1]), complex)
    for k, w in enumerate(omega):
        try:
            out[k] = system.C @ np.linalg.solve(1j * w * np.eye(n) - system.A, system.B) + system.feedthrough
        except np.linalg.LinAlgError:
            out[k] = np.inf
    return out


def frequencies(system: StateSpaceStep | SparseStep, low: float | None, high: float | None, points: int) -> np.ndarray:
    """Angular frequencies [rad/s]: a decade around the non-zero eigenvalues, denser at lightly damped ones.

    Of a large model the 20 lowest eigenvalues, and no decade beyond them.
    """
    beyond = 10.0
    if isinstance(system, SparseStep):
        n, beyond = system.system.n_states, 1.0
        poles = lowest_modes(system.system, n // 2, 0, Report(), min(WANTED, n // 2)).values
        poles = poles[~np.isnan(poles)]
    else:
        poles = np.linalg.eigvals(system.A)
    size = np.abs(poles)
    size = size[size > 1e-6 * size.max(initial=0.0)]
    low = low if low is not None else (0.1 * float(size.min()) if len(size) else 0.1)
    high = high if high is not None else (beyond * float(size.max()) if len(size) else 100.0)
    grid = [np.geomspace(low, max(high, low * (1 + 1e-9)), points)]
    for pole in poles[poles.imag > 0.0]:
        width = max(abs(pole.real) / abs(pole), 1e-4)
        near = pole.imag * (1.0 + width * np.linspace(-6.0, 6.0, 25))
        grid.append(near[(near > low) & (near < high)])
    return np.unique(np.concatenate(grid))


def export_getss(system: StateSpaceStep, target: Path) -> None:
    """Write A, B, C (and D) to a `.mat`, `.npz` or `.json` file. Raises UsageError for another extension."""
    arrays = system.arrays()
    export_to(target, {
        ".mat": lambda: to_mat(arrays, target), ".npz": lambda: to_npz(arrays, target),
        ".json": lambda: write_text(target, json.dumps(as_json(system)) + "\n"),
    })  # fmt: skip


def as_json(system: StateSpaceStep) -> dict[str, object]:
    """Matrices as lists of rows, D null when there is none, and the names of the signals."""
    found: dict[str, object] = {"t": system.t, "D": None}
    found |= {name: matrix.tolist() for name, matrix in system.arrays().items()}
    return found | {"states": system.states, "inputs": system.inputs, "outputs": system.outputs}


def _matrix(file: SbfFile, ident: str, step: int) -> np.ndarray:
    return np.asarray(file.get(ident, step if file.variable(ident).is_step else None))


def _has_feedthrough(file: SbfFile) -> bool:
    return bool(file.count("DFT")) if "DFT" in file.header else file.has("D")


def _step(
    A: np.ndarray, B: np.ndarray, C: np.ndarray, D: np.ndarray | None, t: float, names: Sequence[Sequence[str]]
) -> StateSpaceStep:
    """The step with these names of states, inputs and outputs, or numbered ones when there are not as many."""
    counts = len(A), B.shape[1], len(C)
    return StateSpaceStep(A, B, C, D, t, *map(_fitting, names, "xuy", counts))


def _fitting(names: Sequence[str], letter: str, count: int) -> tuple[str, ...]:
    return tuple(names) if len(names) == count else tuple(f"{letter}{k + 1}" for k in range(count))
