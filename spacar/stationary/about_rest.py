"""The linearized equations about a small equilibrium at rest, in one call of C (compiled/linearized.c).

The counterpart of `spacar.linearization`, of the velocity transfer, of the bound of the condition number and of
`Dynamics.complete`, for what `Equilibrium` takes. Dense, up to the size to which all matrices of a linearization are;
zeros in the factors are passed over.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.dynamics.forces import active_entries, gravity_field
from spacar.frame import Frame
from spacar.kinematics.constraint_condition import Conditioning, of_gradient
from spacar.linear_systems.matrix import DENSE_LIMIT, matrix, zero_matrix
from spacar.linearization.matrices import Linearization, no_rates
from spacar.mechanism.mechanism import Loads, Mechanism
from spacar.stationary.equilibrium import Equilibrium


class AboutRest(NamedTuple):
    """A state at rest: x (nx,), its deformations e (ne,), all stresses sigma (ne,), and about it

    W (nx, ndof), We (ne, ndof)      transfer functions
    m0, k0, g0 (ndof, ndof)          of the elements; m0 without the inertia of deformations
    V (ne, nx), S (ne, ne)           S of the deformations that are not given
    mass, geometric, gravity (nx, nx)
    bound, terms, guard              of the condition number; of the geometric stiffness; the smallest of all elements
    """

    mechanism: Mechanism
    x: Array
    e: Array
    sigma: Array
    W: Array
    We: Array
    m0: Array
    k0: Array
    g0: Array
    V: Array
    S: Array
    geometric: Array
    mass: Array
    gravity: Array
    bound: float
    terms: float
    guard: float

    @classmethod
    def of(cls, equations: Equilibrium, x: Array, sigma: Array) -> AboutRest | None:
        """At x (nx,) with the stresses sigma (ne,), at the loads of the equations. None: for NumPy."""
        from spacar.compiled.interface import structure
        from spacar.compiled.library import address_of

        m = equations.mechanism
        n = m.numbering
        nx, ne, ndof = n.nx, n.ne, n.ndof
        if n.nk or max(nx, ne) > DENSE_LIMIT:
            return None
        xs, es = n.x_class, n.e_class
        # what results keep, and what is forgotten with the linearization, lie apart
        shapes = [(nx, ndof), (ne, ndof), *3 * [(ndof, ndof)]], [(ne, nx), (ne, ne), (nx, nx), (nx, nx)]
        (kept, at_kept), (others, at_others) = map(_zeros, shapes)
        (W, We, m0, k0, g0), (V, S, geometric, mass) = kept, others
        stresses, column = sigma.copy(), m.scale[xs["calculable"]]  # nothing is kinematic
        gravity = np.zeros((nx, nx)) if equations.heavy else None
        for b, M in equations.constant_masses:
            np.add.at(mass, (b.x[:, None], b.x), M)
        c = structure("Linearized")(
            address_of(m.deformation_scale), address_of(column), *at_kept, *at_others,
            None if gravity is None else address_of(gravity), address_of(stresses), len(column),
            xs["calculable"].start, *_input_and_dynamic(xs), *_input_and_dynamic(es), equations.n_groups,
        )  # fmt: skip
        if not equations.linearize(x, sigma, c):
            return None
        gravity = zero_matrix((nx, nx)) if gravity is None else gravity
        e = equations.arrays.e.copy()
        return cls(
            m, x, e, stresses, W, We, m0, k0, g0, V, S, geometric, mass, gravity, c.bound, c.terms, c.guard
        )  # fmt: skip

    @property
    def condition(self) -> Conditioning:
        """Of the choice of the degrees of freedom."""
        return Conditioning(self.bound, partial(of_gradient, self.mechanism, self.V))

    def frame(self, t: float, sigma: Array, loads: Loads) -> Frame:
        """What is stored of the state with the stresses sigma (ne,) under these loads. Gravity and what holds it up are
        the same, so that the total forces are those of the stresses."""
        nx, ne = self.mechanism.numbering.nx, self.mechanism.numbering.ne
        weighs = loads.gravity.any()
        return Frame(
            t=t, x=self.x.copy(), xd=np.zeros(nx), xdd=np.zeros(nx), e=self.e, ed=np.zeros(ne), edd=np.zeros(ne),
            sig=sigma, fx=loads.force.copy(), fxtot=sigma @ self.V,
            fxgrav=self.mass @ gravity_field(self.mechanism, loads) if weighs else np.zeros(nx),
        )  # fmt: skip

    def linearization(self) -> Linearization:
        """The linearized equations."""
        m, n = self.mechanism, self.mechanism.numbering
        W, We, m0, of_e = self.W, self.We, self.m0, (n.ne, n.ne)
        nothing, none = zero_matrix((n.nx, n.nx)), zero_matrix((n.ne, n.nx))
        Sd = matrix(*active_entries(m.damping, n.e_class["input"].stop), of_e)
        c0, d0, n0, bk0, ak0 = np.zeros((5, n.ndof, n.ndof))
        ak0.reshape(-1)[:: n.ndof + 1] = 1.0
        if len(m.damping[0]):
            d0 = We.T @ Sd @ We
        if len(m.deformation_inertia[0]):
            m0 = m0 + We.T @ matrix(*m.deformation_inertia, of_e) @ We
        Z, Ze, Y, Ye, Yv, Yev = no_rates(n.ne, n.nx, n.ndof, n.nkdof)
        return Linearization(
            m0=m0, c0=c0, d0=d0, k0=self.k0, n0=n0, g0=self.g0, ak0=ak0, bk0=bk0,
            W=W, We=We, G=W, Ge=We, Z=Z, Ze=Ze, Y=Y, Ye=Ye, Yv=Yv, Yev=Yev,
            sigma=self.sigma, V=self.V, M=self.mass, inertia_x=self.geometric, inertia_v=nothing,
            load_x=self.gravity, load_v=nothing, S=self.S, Sd=Sd, stress_x=none, stress_v=none,
            geometric_terms=self.terms,
        )  # fmt: skip


def _input_and_dynamic(classes: dict[str, slice]) -> tuple[int, int]:
    """The first degree of freedom, and how many there are: they follow each other."""
    first, last = classes["input"].start, classes["dynamic"].stop
    return first, last - first


def _zeros(shapes: list[tuple[int, int]]) -> tuple[list[Array], list[int]]:
    """Arrays of zeros behind each other, and their addresses."""
    from spacar.compiled.library import address_of

    sizes = [a * b for a, b in shapes]
    room = np.zeros(sum(sizes))
    at, arrays, addresses, first = 0, [], [], address_of(room)
    for shape, size in zip(shapes, sizes, strict=True):
        arrays.append(room[at : at + size].reshape(shape))
        addresses.append(first + 8 * at)
        at += size
    return arrays, addresses
