"""The contents of an `.ltv` result as arrays: set-points of mode 2, time-varying linear system of modes 3, 4 and 9."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from spacar.arrays import Array, Index
from spacar.errors import UsageError
from spacar.linearization.descriptor import dense_steps, of_frame

if TYPE_CHECKING:
    from spacar.result import Result


@dataclass(frozen=True)
class TimeVarying:
    """dz/dt = A z + B u, y = y0 + C z + D u with z = (dq, dqd), and the set-points, step by step (files.md section 6).

    name      where it comes from, for messages;  t (k,) [s]
    A (k, n, n), B (k, n, m), C (k, p, n), D (k, p, m); an absent D is zero
    m0, c0b, k0b (k, n/2, n/2): mass, damping and stiffness of the same equations
    u0 (k, n_nominal), y0 (k, p), sigma0 (k, m - n_nominal): nominal inputs, reference outputs, stresses of the
              rigidified deformations
    second    (k, s, n/2, n/2) second order expressions of the outputs `second_rows` (s,): y += dq^T G dq / 2
    x0        (n,) initial state
    n_nominal number of the first columns of B that are nominal inputs;  n_rigid  number of rigid degrees of freedom

    A field that the result does not have is None.
    """

    name: str
    t: Array
    n_nominal: int = 0
    n_rigid: int = 0
    A: Array | None = None
    B: Array | None = None
    C: Array | None = None
    D: Array | None = None
    m0: Array | None = None
    c0b: Array | None = None
    k0b: Array | None = None
    u0: Array | None = None
    y0: Array | None = None
    sigma0: Array | None = None
    second: Array | None = None
    second_rows: Index = field(default_factory=lambda: np.zeros(0, np.int64))
    x0: Array | None = None
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()

    @classmethod
    def of(cls, result: Result) -> TimeVarying:
        """From a run of mode 2, 3, 4 or 9 in memory. Raises UsageError for another mode."""
        first = result.frames[0].state_space
        if not first:
            raise UsageError(
                f"a result of mode {result.mode} has no set-points and no state space", "simulation.no-ltv"
            )
        header, count = result.header, len(result.frames)

        def get(name: str) -> Array | None:
            return result[name] if name in first and first[name].size else None

        full = {name: get(name) for name in (*"ABCD", "m0", "c0b", "k0b", "u0", "y0")}
        if "asp" in first:  # of a large model
            full |= dense_steps((of_frame(f.state_space, header) for f in result.frames), count)
            full["D"] = full["D"] if header["DFT"] else None  # without feedthrough D is rounding
        second = get("G")
        if second is not None:
            n = int(header["NX"]) // 2
            second = second.reshape(count, -1, n, n).swapaxes(-1, -2)
        return cls(
            name=result.mechanism.deck.source, t=result.t, n_nominal=int(header.get("NNOM", 0)),
            n_rigid=int(header.get("NRBM", 0)), **full, sigma0=get("sig0"), second=second,
            second_rows=np.ravel(header.get("NYSI", np.zeros(0, np.int64))).astype(np.int64) - 1,
            x0=header.get("X0"), inputs=tuple(header.get("inputs", ())), outputs=tuple(header.get("outputs", ())),
        )  # fmt: skip

    def need(self, *names: str) -> list[Array]:
        """The named arrays. Raises UsageError that says which is missing and what would compute it."""
        for name in names:
            if getattr(self, name) is None:
                source = {
                    "u0": "NOMS or NOMF statements and mode 2 or 3", "y0": "REF... statements and mode 2 or 3",
                    "sigma0": "mode 3 with deformations that are rigid in mode 2 and prescribed in mode 3",
                }.get(name, "mode 3")  # fmt: skip
                if self.A is not None and name in ("m0", "c0b", "k0b"):  # sparse equations were stored
                    size = f"a large model ({self.A.shape[1] // 2} degrees of freedom)"
                    source = f"modes 3, 4 and 9 of {size} with --modes 0 (MODES 0): run it again with that"
                raise UsageError(f"{self.name} has no {name}; it comes from {source}", "simulation.missing")
        return [getattr(self, name) for name in names]

    @property
    def distribution(self) -> Array:
        """E (k, n/2, m): generalized forces of unit inputs, M0 times the lower half of B.

        Raises UsageError for a reduced system, whose inputs also drive the upper half.
        """
        m0, B = self.need("m0", "B")
        if np.any(B[:, : m0.shape[1]]):
            text = f"{self.name} is a reduced system: fold in gains and choose modes before the reduction"
            raise UsageError(text, "simulation.reduced")
        return m0 @ B[:, m0.shape[1] :]
