"""Element families whose functions are those of the engine: the contract of `spacar.elements.family` in C.

One call evaluates all elements of a batch. What depends on numbers of the elements only (stiffness, lumped inertia,
limits) is that of the NumPy family, which also answers where there is no function in C, and for complex numbers. Both
give the same results to rounding (tests/compiled/test_compiled_elements.py).
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.arrays import Array
from spacar.compiled.compiled_model import is_compiled
from spacar.compiled.interface import structure
from spacar.compiled.library import address_of, element_functions, engine
from spacar.elements.family import GUARD, Configuration, Family, Internal, Trouble
from spacar.mechanism.mechanism import Mechanism
from spacar.stream import Run

if TYPE_CHECKING:
    from spacar.linear_systems.banded import BandedSystem

FACTS = (
    "n_coordinates", "n_deformations", "slips", "position_rows", "constant_gradient", "constant_mass", "has_mass",
    "has_own_branch", "measure", "definition", "keyword", "numbers", "length", "data", "frame_p", "frame_q",
    "parameters", "branch", "orientation_inertia", "lumped_inertia",
)  # fmt: skip
DOUBLE = ctypes.c_double * 1


@dataclass(eq=False)
class Place:
    """Where a batch is: x (n_coordinates, n), `branch`; the configuration of the NumPy family when it was needed."""

    x: Array
    branch: Array
    general: Configuration = None


def mechanism_of(run: Run) -> Mechanism:
    """The mechanism of a run with its elements in C where that is possible; the header says which, and why."""
    return with_compiled_elements(run.mechanism) if is_compiled(run) else run.mechanism


def with_compiled_elements(mechanism: Mechanism) -> Mechanism:
    """The mechanism with the functions of the engine in the place of those of the families that have them there."""
    batches = []
    for b in mechanism.batches:
        family = compiled_family(b.family) if b.family.n_deformations or b.family.has_mass else b.family
        batches.append(b if family is b.family else b._replace(family=family))
    return replace(mechanism, batches=tuple(batches))


def band_inverse(system: BandedSystem) -> Array:
    """Diagonal of the inverse of a matrix with a symmetric pattern, in the order of its band (band.c)."""
    lu, diagonal = np.ascontiguousarray(system.lu.T), np.empty(system.n)
    pivots = system.pivots.astype(np.int32)
    if element_functions().band_inverse(
        address_of(lu), system.n, system.lower, address_of(pivots), address_of(diagonal)
    ):
        raise MemoryError
    return diagonal


def compiled_family(family: Family) -> Family:
    """The family with functions of the engine; itself where the engine has none for it."""
    name = family.definition
    if isinstance(family, CompiledElements) or name not in element_functions().text:
        return family
    kind, count = engine(1).kinds[name]
    parameters = family.parameters()
    if count != len(parameters) or parameters.dtype != float:
        return family
    return CompiledElements(family, kind, parameters)


class CompiledElements(Family):
    """All elements of one family, in C. `general` is the NumPy family, `kind` the number of the type in C.

    `elements` is what functions of C for whole mechanisms take.
    """

    compiled = True

    def __init__(self, general: Family, kind: int, parameters: Array) -> None:
        for name in FACTS:
            if hasattr(general, name):
                setattr(self, name, getattr(general, name))
        self.general = general
        self._parameters = np.ascontiguousarray(parameters)
        sizes = general.n, general.n_coordinates, general.n_deformations, len(parameters)
        self.elements = structure("Elements")(kind, *sizes, address_of(self._parameters))
        self._at = ctypes.c_void_p(ctypes.addressof(self.elements))
        self._shape = (general.n_coordinates, general.n)
        self._call = element_functions()
        self._limited = type(general).troubles is not Family.troubles

    def __getattr__(self, name: str) -> Any:
        """What else the NumPy family has: the parameters of its type, and, of some, the same with other mass flows."""
        if name == "general":  # not yet there: copying and pickling ask
            raise AttributeError(name)
        value = getattr(self.general, name)
        return (lambda flow: compiled_family(value(flow))) if name == "with_flow" else value

    def __reduce__(self) -> Any:
        return compiled_family, (self.general,)

    # -- deformations -------------------------------------------------------------------------------------------
    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> Configuration:
        if x.shape != self._shape or x.dtype != float or e.dtype != float:
            return self.general.strain(x, branch, e, V)
        place = Place(x.copy(), branch.copy())
        if self.n_deformations:
            self._call.strain(self._at, _at(place.x), _at(place.branch), _at(e), _at(V))
        return place

    def convective_strain(self, c: Configuration, v: Array, out: Array) -> None:
        self._write(self._call.convective, self.general.convective_strain, c, v, out)

    def gradient_rate(self, c: Configuration, v: Array, out: Array) -> None:
        self._write(self._call.rates, self.general.gradient_rate, c, v, out, 0)

    def gradient_transport(self, c: Configuration, v: Array, out: Array) -> None:
        if self.slips:
            self._write(self._call.transport, self.general.gradient_transport, c, v, out)
        else:
            self.gradient_rate(c, v, out)

    def rate_gradient(self, c: Configuration, v: Array, out: Array) -> None:
        self._write(self._call.rates, self.general.rate_gradient, c, v, out, 1)

    def geometric_stiffness(self, c: Configuration, sigma: Array, out: Array) -> None:
        self._write(self._call.geometric, self.general.geometric_stiffness, c, sigma, out)

    def _write(
        self, in_c: Callable[..., None], general: Callable[..., None], c: Configuration, v: Array, out: Array,
        *which: int,
    ) -> None:  # fmt: skip
        """By C where it can, else by the NumPy family."""
        if self._here(c, v):
            in_c(self._at, _at(c.x), _at(v), *which, _at(out))
        else:
            general(self._general(c), v, out)

    def internal(self, c: Configuration, sigma: Array) -> Internal | None:
        if type(self.general).internal is Family.internal:
            return None
        return self.general.internal(self._general(c), sigma)

    def stiffness(self) -> tuple[Array, Array]:
        return self.general.constitutive

    # -- inertia ------------------------------------------------------------------------------------------------
    def mass(self, c: Configuration, out: Array) -> None:
        if self.constant_mass or not self._here(c):
            self.general.mass(self._general(c), out)
        else:
            self._call.inertia(self._at, _at(c.x), None, None, _at(out), None)

    def inertia_force(self, c: Configuration, v: Array, a: Array | None) -> Array:
        if self.constant_mass or not self._here(c, v, *(() if a is None else (a,))):
            return self.general.inertia_force(self._general(c), v, a)
        force = np.empty(self._shape)
        self._call.inertia(self._at, _at(c.x), _at(v), None if a is None else _at(a), None, _at(force))
        return force

    def inertia_gradient(self, c: Configuration, v: Array, a: Array) -> tuple[Array, Array]:
        if self.constant_mass or not self._here(c, v, a):
            return self.general.inertia_gradient(self._general(c), v, a)
        by_x, by_v = np.empty((2, self.n_coordinates, *self._shape))
        self._call.inertia_gradient(self._at, _at(c.x), _at(v), _at(a), _at(by_x), _at(by_v))
        return by_x, by_v

    # -- limits -------------------------------------------------------------------------------------------------
    def troubles(self, c: Configuration, e: Array, sigma: Array) -> list[Trouble]:
        if not self._limited or (isinstance(c, Place) and self._call.guard(self._at, _at(c.x)) > GUARD):
            return []
        return self.general.troubles(self._general(c), e, sigma)

    # -- where the NumPy family answers -------------------------------------------------------------------------
    def _here(self, c: Configuration, *vectors: Array) -> bool:
        if not isinstance(c, Place):
            return False
        return all(v.dtype == float and v.shape[1:] == self._shape[1:] for v in vectors)

    def _general(self, c: Configuration) -> Configuration:
        """The configuration of the NumPy family."""
        if not isinstance(c, Place):
            return c
        if c.general is None:
            e = np.zeros((self.n_deformations, self.n))
            c.general = self.general.strain(c.x, c.branch, e, np.zeros((self.n_deformations, *self._shape)))
        return c.general


def _at(array: Array) -> Any:
    """Where the doubles of an array begin, in the order of its axes. An output is contiguous already."""
    whole: Any = array if array.flags.c_contiguous else np.ascontiguousarray(array)
    return DOUBLE.from_buffer(whole)
