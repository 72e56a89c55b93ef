"""What an element family is: all elements of one type, evaluated at once.

Notation of theory-system.md section 0. Arrays are *component first*: `x` of shape (n_coordinates, n), so that
`xp, yp, ... = x` unpacks into contiguous rows; the element axis is last: every operation is elementwise over it.
Parameters have shape (n,).

Duties of a family
1. `strain` gives the deformations e = D(x) and the velocity map V (V = dD/dx for holonomic rows; for slips V is
   the given row and e stays zero). It returns a *configuration*: whatever the later calls at the same x can reuse.
2. The second derivative H[e,i,j] = dV[e,i]/dx_j appears only contracted: `convective_strain` H(v,v),
   `gradient_rate` H1(v)[e,j] = sum_i H[e,i,j] v_i, `gradient_transport` H2(v)[e,i] = sum_j H[e,i,j] v_j (equal to H1
   for holonomic rows), `geometric_stiffness` Hs(sigma)[i,j] = sum_e sigma_e H[e,i,j].
3. The third derivative appears only as `rate_gradient` T(v)[e,j] = d/dx_j sum_ik H[e,i,k] v_i v_k.
4. Inertia: the virtual power of the inertia forces is -dx . (M a + h). `mass` gives M, `inertia_force` M a + h,
   `inertia_gradient` its derivatives with respect to x (at fixed v, a) and to v.  Gravity needs no code of its own: it
   is minus the inertia force of the acceleration -g at the position coordinates.
5. Output arrays are zero on entry where a family writes nothing: it may leave structural zeros alone.
6. Nothing here loops over elements, and everything works for complex x where the formulas are analytic
   (complex-step tests), except branch choices (`branch`). Constructors take complex numbers of the deck too (x0,
   geometry, em, estiff, edamp with a direction, `spacar.deck.directed`): arrays of constants have their type.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array

Configuration = Any

GUARD = 0.71  # what guards of the compiled form must be above: cosines of angles (45 degrees pass)


class ElementGroup(NamedTuple):
    """The input of all elements of one keyword, as a family's constructor gets it.

    keyword      'PLBEAM', ...
    numbers      (n,) user's element numbers, ascending
    x0           (n_coordinates, n) reference configuration (all angles 0, all lambda = 1, 0, 0, 0)
    geometry     per element the values behind the node numbers in the element statement
    nonlinear    (n,) bool, False where LDEFORM switches the second order strain terms off
    directions   per element the ORPINBOD or ORTUBE values, or None
    projections  per element the DRPINBOD values, or None
    em, estiff, edamp   (n, 9), (n, 7), (n, 7): values of EM, ESTIFF, EDAMP from position 2 on, zero where not given
                 (EM position 5 of tubes, the flow shape factor, is already 1 by default)
    elastic      (n_deformations, n) bool, False where a deformation is fixed or prescribed; None: all True. Only
                 for the angle measure, no other family asks for it
    """

    keyword: str
    numbers: NDArray[np.int64]
    x0: Array
    geometry: tuple[tuple[float, ...], ...]
    nonlinear: NDArray[np.bool_]
    directions: tuple[tuple[float, ...] | None, ...]
    projections: tuple[tuple[float, ...] | None, ...]
    em: Array
    estiff: Array
    edamp: Array
    elastic: NDArray[np.bool_] | None = None

    @property
    def n(self) -> int:
        return len(self.numbers)


class GeometryError(ValueError):
    """The start geometry of one element is impossible; `index` is its place in the group."""

    def __init__(self, index: int, text: str) -> None:
        super().__init__(text)
        self.index = index


@dataclass(frozen=True)
class Trouble:
    """A state that an element cannot represent well (`fatal` False) or at all (True)."""

    index: int
    text: str
    fatal: bool


class Internal(NamedTuple):
    """An unknown a inside every element: the strain energy contains stiffness a^2/2 + a coupling.dx."""

    coupling: Array  # (n_coordinates, n) proportional to the stresses
    stiffness: Array  # (n,) infinite where the element has no such unknown
    eliminated: NDArray[np.bool_]  # (n,) whether the deformations follow it; else it is zero in them


class Family:
    """Base class: a family without strain, stiffness or mass. Subclasses override what they have."""

    n_coordinates: ClassVar[int]
    n_deformations: ClassVar[int] = 0
    slips: ClassVar[tuple[int, ...]] = ()  # local rows that exist as rates only
    position_rows: ClassVar[tuple[int, ...]] = ()  # local coordinates that are positions, in the order x, y(, z), ...
    compiled: ClassVar[bool] = False  # the functions are those of the engine
    constant_gradient: bool = False  # V does not depend on x: H, H1, T, Hs vanish and are not called
    constant_mass: bool = False  # M does not depend on x and h = 0
    has_mass: bool = False
    has_own_branch: bool = False  # turns are counted in something else than the deformations: `branch`
    measure: ClassVar[str] = ""  # "angle": the deformations of ADEFORM (theory-beam-order4.md)
    definition: ClassVar[str] = ""  # name of the type in SymPy and in the engine; empty without one

    keyword: str
    numbers: NDArray[np.int64]
    # (n, n_deformations) each: of S and S_d that are diagonal, dual to the deformations in their units
    coefficients: tuple[Array, Array] = (np.zeros((1, 1)), np.zeros((1, 1)))
    frame_p: Array | None = None  # (n, 9) rows x', y', z' of the local frame at p in the start configuration
    frame_q: Array | None = None  # (n, 9) the same at q
    data: Array | None = None  # (n, k) geometric data stored as dr0 (column 1: torsion-elongation f of beams)

    def _take(self, group: ElementGroup) -> None:
        """What most types have as it is given: numbers, and ESTIFF and EDAMP as `coefficients`."""
        n = self.n_deformations
        self.keyword, self.numbers = group.keyword, group.numbers
        self.coefficients = group.estiff[:, :n], group.edamp[:, :n]

    @property
    def n(self) -> int:
        return len(self.numbers)

    @cached_property
    def length(self) -> Array:
        """(n,) undeformed length [m], 0 where the type has none."""
        return np.zeros(self.n)

    @cached_property
    def constitutive(self) -> tuple[Array, Array]:
        """`stiffness`, evaluated once; every asker gets the same arrays, which cannot be written to."""
        found = self.stiffness()
        for S in found:
            S.setflags(write=False)
        return found

    def parameters(self) -> Array:
        """Numbers of the elements in the order of the parameters of `definition`, (n_parameters, n)."""
        return np.zeros((0, self.n))

    # -- deformations -------------------------------------------------------------------------------------------
    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> Configuration:
        """Write e (n_deformations, n) and V (n_deformations, n_coordinates, n) at x (n_coordinates, n).

        `branch` (n_deformations, n) is that of the last accepted state; families with angles beyond one turn take the
        turn that is closest to it, the others ignore it.
        """
        raise NotImplementedError

    def branch(self, x: Array, e: Array) -> Array:
        """What states after (x, e) have their branch by, (n_deformations, n); where not `has_own_branch` it is e."""
        raise NotImplementedError

    def convective_strain(self, c: Configuration, v: Array, out: Array) -> None:
        """Write H(v,v), the part of the second time derivative of e without accelerations, (n_deformations, n)."""

    def gradient_rate(self, c: Configuration, v: Array, out: Array) -> None:
        """Write H1(v), (n_deformations, n_coordinates, n)."""

    def gradient_transport(self, c: Configuration, v: Array, out: Array) -> None:
        """Write H2(v), (n_deformations, n_coordinates, n)."""
        self.gradient_rate(c, v, out)

    def rate_gradient(self, c: Configuration, v: Array, out: Array) -> None:
        """Write T(v), (n_deformations, n_coordinates, n)."""

    def geometric_stiffness(self, c: Configuration, sigma: Array, out: Array) -> None:
        """Write Hs(sigma), (n_coordinates, n_coordinates, n); row = force, column = coordinate."""

    def internal(self, c: Configuration, sigma: Array) -> Internal | None:
        """The unknown inside every element that is not a coordinate, at the stresses sigma; None without."""
        return None

    # -- stresses -----------------------------------------------------------------------------------------------
    def stiffness(self) -> tuple[Array, Array]:
        """Constant S and S_d of sigma = S e + S_d de/dt, each (n_deformations, n_deformations, n), symmetric."""
        modes = np.arange(self.n_deformations)
        full = np.zeros((2, len(modes), len(modes), self.n), np.result_type(*self.coefficients))
        for S, diagonal in zip(full, self.coefficients, strict=True):
            S[modes, modes] = diagonal.T
        return full[0], full[1]

    # -- inertia ------------------------------------------------------------------------------------------------
    def mass(self, c: Configuration, out: Array) -> None:
        """Write M, (n_coordinates, n_coordinates, n). Only called when `has_mass`."""

    def inertia_force(self, c: Configuration, v: Array, a: Array | None) -> Array:
        """M a + h, (n_coordinates, n); `a` None means zero accelerations. Only called when `has_mass`."""
        raise NotImplementedError

    def inertia_gradient(self, c: Configuration, v: Array, a: Array) -> tuple[Array, Array]:
        """d(M a + h)/dx and dh/dv, each (n_coordinates, n_coordinates, n); column = coordinate."""
        zero = np.zeros((self.n_coordinates, self.n_coordinates, *v.shape[1:]))
        return zero, zero

    def orientation_inertia(self) -> tuple[tuple[int, Array], ...]:
        """Inertia tensors that belong to spatial orientation nodes: (first local row of lambda, J (n, 3, 3)) each.

        J has the components along the global axes in the start configuration. The mechanism sums all tensors of a
        node (elements and XM) and evaluates one rigid body there. [kg m^2]
        """
        return ()

    def lumped_inertia(self) -> tuple[tuple[int, Array], ...]:
        """Constant inertia that belongs to single coordinates of nodes: (local row, (n,)) each.

        The mechanism adds it to the XM of the node. [kg m^4 for a twist rate]
        """
        return ()

    # -- limits -------------------------------------------------------------------------------------------------
    def troubles(self, c: Configuration, e: Array, sigma: Array) -> list[Trouble]:
        """Elements outside the range of their theory; called for output steps, not in the right-hand side."""
        return []


def arc_tangent(y: NDArray[Any], x: NDArray[Any]) -> NDArray[Any]:
    """atan2(y, x); of complex arguments the first order continuation that a complex step needs."""
    if not (np.iscomplexobj(x) or np.iscomplexobj(y)):
        return np.arctan2(y, x)
    slope = (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2)
    return np.arctan2(y.real, x.real) + 1j * slope
