"""The nominal motion of mode 2, or the stationary solutions of modes 7 to 10, as mode 3 needs them, and their
comparison with the mechanism of mode 3.

Nodes and elements must be the same; the classes may differ (RLSE in mode 2 becomes INPUTE in mode 3), so everything
is looked up by node and coordinate, element and mode.
"""

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import EPS, Array
from spacar.errors import UsageError
from spacar.mechanism.mechanism import DriveState, Mechanism
from spacar.mechanism.numbering import Numbering
from spacar.modes import MODES

if TYPE_CHECKING:
    from spacar.result import Result

# A prescribed deformation whose change over its typical size is at most this rests. The position keeps a prescribed
# value to 1e-11 only, and to the rounding of the coordinates far from the origin: a smaller motion would be lost in it.
REST = sqrt(EPS)


@dataclass(frozen=True)
class Nominal:
    """The nominal motion: one row a step, in the numbering (lnp, le, ln: 1-based tables) of mode 2.

    name      where it comes from, for messages
    t         (steps,) [s];  x, xd, xdd (steps, nx);  e, ed, edd, sig (steps, ne)
    keywords  element type of every element number, "" where there is none
    n_fixed   number of fixed deformations: the first ones of e
    n_given   number of fixed and prescribed deformations; the prescribed ones follow the fixed ones
    u0        (steps, inputs) nominal inputs, None when they are not known
    warnings  what the log of mode 3 must say about the source
    mode      number of the mode of the run
    """

    name: str
    t: Array
    x: Array
    xd: Array
    xdd: Array
    e: Array
    ed: Array
    edd: Array
    sig: Array
    lnp: NDArray[np.int64]
    le: NDArray[np.int64]
    ln: NDArray[np.int64]
    keywords: tuple[str, ...]
    n_fixed: int
    n_given: int
    mode: int
    u0: Array | None = None
    warnings: tuple[str, ...] = ()

    @property
    def stationary(self) -> bool:
        """Are the rows load steps instead of the steps of a motion?"""
        return MODES[self.mode].stationary

    @classmethod
    def of(cls, result: "Result") -> "Nominal":
        """From a run in memory. Raises UsageError when it is of a mode other than 2 and 7 to 10."""
        mode = MODES.get(getattr(result, "mode", -1))
        if mode is None or not mode.nominal:
            found = f"not {result!r:.60}" if mode is None else f"this one is of mode {mode.number}"
            text = f"mode 3 needs a result of mode 2, {found} (7 to 10 do as well)"
            raise UsageError(text, "files.not-mode-2")
        n = result.mechanism.numbering
        keywords = tuple(n.keyword.get(i, "") for i in range(1, len(n.le) + 1))
        u0 = result["u0"] if "u0" in result.frames[0].state_space else None
        return cls(
            name=result.mechanism.deck.source, t=result.t, x=result["x"], xd=result["xd"], xdd=result["xdd"],
            e=result["e"], ed=result["ed"], edd=result["edd"], sig=result["sig"],
            lnp=n.lnp, le=n.le, ln=n.ln, keywords=keywords,
            n_fixed=n.e_class["fixed"].stop, n_given=n.e_class["input"].stop, mode=result.mode, u0=u0,
        )  # fmt: skip

    def __str__(self) -> str:
        return self.name

    # -- in the numbering of another mechanism -----------------------------------------------------------------------
    def x_columns(self, n: Numbering) -> NDArray[np.int64]:
        """(nx,) columns of x here for the coordinates of a mechanism with the same nodes."""
        owners = np.array([n.x_owner(i) for i in range(n.nx)]) - 1
        return np.asarray(self.lnp[owners[:, 0], owners[:, 1]] - 1)

    def e_columns(self, n: Numbering) -> NDArray[np.int64]:
        """(ne,) columns of e here for the deformations of a mechanism with the same elements.

        Normalizations of Euler parameters get -1.
        """
        owners = [n.e_owner(i) for i in range(n.ne)]
        found = [self.le[element - 1, mode - 1] - 1 if element > 0 else -1 for element, mode in owners]
        return np.array(found, np.int64)

    def rests(self, mechanism: Mechanism) -> NDArray[np.bool_]:
        """(ne,) which deformations of a mechanism with the same elements are fixed in this motion, or prescribed and at
        rest. In a stationary solution everything rests, and only those that are fixed count.
        """
        columns = self.e_columns(mechanism.numbering)
        if self.stationary:
            return (columns >= 0) & (columns < self.n_fixed)
        travel = np.abs(self.e[:, columns] - self.e[0, columns]).max(axis=0)
        still = (columns < self.n_given) & (travel <= REST * mechanism.deformation_scale)
        return (columns >= 0) & ((columns < self.n_fixed) | still)


def check_same_mechanism(nominal: Nominal, n: Numbering) -> None:
    """Raises UsageError that names the first element or node in which two mechanisms differ."""
    where = f"the mechanism differs from that of {nominal.name}"
    here = {number: (keyword, nodes) for number, keyword, nodes in n.elements}
    there = {
        i: (keyword, tuple(int(k) for k in nodes if k))
        for i, (keyword, nodes) in enumerate(zip(nominal.keywords, nominal.ln, strict=True), 1)
        if keyword
    }
    for element in sorted({*here, *there}):
        if here.get(element) != there.get(element):
            ours, theirs = (_described(elements.get(element)) for elements in (here, there))
            raise UsageError(f"{where}: element {element} is {ours} here, {theirs} there", "files.different-mechanism")
    for node in range(1, max(len(n.lnp), len(nominal.lnp)) + 1):
        tables = (n.lnp, nominal.lnp)
        sizes = [int(np.count_nonzero(table[node - 1])) if node <= len(table) else 0 for table in tables]
        if sizes[0] != sizes[1]:
            text = f"{where}: node {node} has {sizes[0]} coordinates here, {sizes[1]} there"
            raise UsageError(text, "files.different-mechanism")


def _described(element: tuple[str, tuple[int, ...]] | None) -> str:
    return f"{element[0]} with nodes {' '.join(map(str, element[1]))}" if element else "absent"


class NominalDrive:
    """Prescribed motion at the steps of a nominal motion (and nowhere else), in the classes of a mechanism.

    Deformations that rest there keep exactly one value: the stored ones have the error of the position, which a stiff
    element would turn into a moment.
    """

    breaks: tuple[float, ...] = ()

    def __init__(self, nominal: Nominal, mechanism: Mechanism) -> None:
        self.t, n = nominal.t, mechanism.numbering
        xi = nominal.x_columns(n)[n.x_class["input"]]
        ei = nominal.e_columns(n)[n.e_class["input"]]
        self.x = np.stack((nominal.x[:, xi], nominal.xd[:, xi], nominal.xdd[:, xi]), axis=1)
        self.e = np.stack((nominal.e[:, ei], nominal.ed[:, ei], nominal.edd[:, ei]), axis=1)
        still = nominal.rests(mechanism)[n.e_class["input"]]
        self.e[:, 1:, still] = 0.0
        self.e[:, 0, still] = np.where(ei < nominal.n_fixed, 0.0, nominal.e[0, ei])[still]

    def at(self, t: float) -> DriveState:
        """The values of the step nearest to t [s]."""
        k = int(np.argmin(np.abs(self.t - t)))
        return DriveState(*self.x[k], *self.e[k])
