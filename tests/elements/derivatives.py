"""Checker of any element family: everything the contract calls a derivative is compared with a derivative.

The truth is the complex step, f'(x) = Im f(x + i h)/h with h = 1e-30: no subtraction, hence no truncation
or cancellation error, so that only round-off of the formulas remains. Tolerance 1e-12 relative to the
largest entry of the compared array (or to 1 if that is smaller): some fifty operations of 1e-16 each,
amplified by at most 1e2 for the curvatures that the tests use.

    V   = de/dx                        (rows that are not slips)
    H1  = d(V v)/dx,  H2 v-transport = dV along v,  H(v,v) = H2 v = H1 v
    T   = d H(v,v)/dx,  Hs = d(V^T sigma)/dx
    h   = dM/dt v - grad(v^T M v)/2    (families that follow Lagrange; others pass lagrange=False)
    d(M a + h)/dx, dh/dv

What this cannot see is a wrong e or a wrong M: the tests of each family compare those with a definition of
their own.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spacar.elements.family import ElementGroup, Family

STEP = 1e-30
TOLERANCE = 1e-12


def group(
    keyword: str, x0: Any, *, geometry: Any = None, nonlinear: Any = None, directions: Any = None,
    projections: Any = None, em: Any = None, estiff: Any = None, edamp: Any = None,
) -> ElementGroup:
    """An ElementGroup; what is left out gets its default, em, estiff, edamp are padded with zeros."""
    x0 = np.asarray(x0, float)
    n = x0.shape[1]

    def table(values: Any, width: int) -> NDArray[np.float64]:
        out = np.zeros((n, width))
        if values is not None:
            rows = np.asarray(values, float)
            out[:, : rows.shape[1]] = rows
        return out

    return ElementGroup(
        keyword=keyword, numbers=np.arange(1, n + 1), x0=x0,
        geometry=((),) * n if geometry is None else tuple(tuple(g) for g in geometry),
        nonlinear=np.ones(n, bool) if nonlinear is None else np.asarray(nonlinear, bool),
        directions=(None,) * n if directions is None else tuple(directions),
        projections=(None,) * n if projections is None else tuple(projections), em=table(em, 9),
        estiff=table(estiff, 7), edamp=table(edamp, 7),
    )


def evaluate(family: Family, x: Any, branch: Any = None) -> tuple[Any, Any, Any]:
    """Configuration, e, V at x, in the number type of x."""
    x = np.asarray(x)
    kind = complex if np.iscomplexobj(x) else float
    ne, nx, n = family.n_deformations, family.n_coordinates, x.shape[1]
    e, V = np.zeros((ne, n), kind), np.zeros((ne, nx, n), kind)
    branch = np.zeros((ne, n)) if branch is None else branch
    family.strain(x, branch, e, V)
    return family.strain(x, branch, e, V), e, V  # twice, as steps give the same arrays again


def written(method: Callable[..., None], shape: tuple[int, ...], kind: Any, *arguments: Any) -> Any:
    """The array that a method of the contract writes into `out`, into one that holds its earlier answer already."""
    out = np.zeros(shape, kind)
    method(*arguments, out)
    method(*arguments, out)
    return out


def close(got: Any, truth: Any, what: str, tolerance: float = TOLERANCE) -> None:
    """Compare relative to the largest entry of the truth, never to less than 1."""
    got, truth = np.asarray(got), np.asarray(truth)
    assert got.shape == truth.shape, f"{what}: shape {got.shape} instead of {truth.shape}"
    scale = max(1.0, float(np.max(np.abs(truth), initial=0.0)))
    error = float(np.max(np.abs(got - truth), initial=0.0)) / scale
    assert error <= tolerance, f"{what}: relative error {error:.3g} > {tolerance:g}\n{got}\n{truth}"


def gradient(f: Callable[[Any], Any], x: Any) -> Any:
    """df/dx_j by complex steps, one coordinate of all elements at a time; new axis before the last."""
    columns = []
    for j in range(len(x)):
        z = x.astype(complex)
        z[j] += 1j * STEP
        columns.append(f(z).imag / STEP)
    return np.stack(columns, axis=-2)


def along(f: Callable[[Any], Any], x: Any, v: Any) -> Any:
    """Derivative of f at x in the direction v by a complex step."""
    return f(x + 1j * STEP * v).imag / STEP


def check_strain(family: Family, x: Any, v: Any, sigma: Any, branch: Any = None, tolerance: float = TOLERANCE) -> None:
    """V, H(v,v), H1, H2, T and Hs at x (nx, n) for the rates v (nx, n) and the stresses sigma (ne, n)."""
    ne, nx, n = family.n_deformations, family.n_coordinates, x.shape[1]
    c, e, V = evaluate(family, x, branch)
    holonomic = [k for k in range(ne) if k not in family.slips]

    def V_of(z: Any) -> Any:
        return evaluate(family, z, branch)[2]

    def convective(z: Any) -> Any:
        cz = evaluate(family, z, branch)[0]
        return written(family.convective_strain, (ne, n), complex, cz, v)

    truth_V = gradient(lambda z: evaluate(family, z, branch)[1], x)
    close(V[holonomic], truth_V[holonomic], "V", tolerance)
    close(e[list(family.slips)], np.zeros((len(family.slips), n)), "slips have no e", 0.0)
    truth_H1 = gradient(lambda z: (V_of(z) * v).sum(1), x)
    truth_H2 = along(V_of, x, v)
    truth_Hs = gradient(lambda z: (V_of(z) * sigma[:, None]).sum(0), x)
    if family.constant_gradient:  # the other methods are never called
        for truth in (truth_H1, truth_H2, truth_Hs):
            close(truth, np.zeros_like(truth), "constant gradient", 0.0)
        return
    close(written(family.gradient_rate, (ne, nx, n), float, c, v), truth_H1, "H1", tolerance)
    close(written(family.gradient_transport, (ne, nx, n), float, c, v), truth_H2, "H2", tolerance)
    close(written(family.convective_strain, (ne, n), float, c, v), (truth_H1 * v).sum(1), "H(v,v)", tolerance)
    close(written(family.rate_gradient, (ne, nx, n), float, c, v), gradient(convective, x), "T", tolerance)
    close(written(family.geometric_stiffness, (nx, nx, n), float, c, sigma), truth_Hs, "Hs", tolerance)
    if not family.slips:
        close(truth_Hs, np.swapaxes(truth_Hs, 0, 1), "Hs is symmetric", tolerance)


def check_stiffness(family: Family) -> None:
    """S and S_d symmetric."""
    for S, name in zip(family.stiffness(), ("S", "S_d"), strict=True):
        assert S.shape == (family.n_deformations, family.n_deformations, family.n), name
        close(S, np.swapaxes(S, 0, 1), f"{name} is symmetric", 0.0)


def mass_of(family: Family, x: Any, branch: Any = None) -> Any:
    """M (nx, nx, n) at x, in the number type of x."""
    x = np.asarray(x)
    c = evaluate(family, x, branch)[0]
    return written(family.mass, (len(x), *x.shape), x.dtype, c)


def check_inertia(
    family: Family, x: Any, v: Any, a: Any, branch: Any = None, *, lagrange: bool = True,
    tolerance: float = TOLERANCE,
) -> None:
    """M, M a + h and its derivatives; with `lagrange` h is the force of the kinetic energy v.M.v/2."""
    assert family.has_mass

    def M_of(z: Any) -> Any:
        return mass_of(family, z, branch)

    def force(z: Any, rate: Any, acceleration: Any) -> Any:
        return family.inertia_force(evaluate(family, z, branch)[0], rate, acceleration)

    M = M_of(x)
    close(M, np.swapaxes(M, 0, 1), "M is symmetric", tolerance)
    h = force(x, v, None)
    Ma = (M * a).sum(1)
    close(force(x, v, a), Ma + h, "M a + h is linear in a", tolerance)
    close(force(x, np.zeros_like(v), a) - force(x, np.zeros_like(v), None), Ma, "M a", tolerance)
    dM = gradient(M_of, x)  # dM[i, j, k] = dM_ij/dx_k
    if lagrange:
        truth = (dM * v[:, None] * v).sum((1, 2)) - 0.5 * (dM * v[:, None, None] * v[:, None]).sum((0, 1))
        close(h, truth, "h (Lagrange)", tolerance)
    if family.constant_mass:
        close(dM, np.zeros_like(dM), "constant mass", 0.0)
        close(h, np.zeros_like(h), "constant mass has h = 0", 0.0)
    dx, dv = family.inertia_gradient(evaluate(family, x, branch)[0], v, a)
    close(dx, gradient(lambda z: force(z, v, a), x), "d(M a + h)/dx", tolerance)
    z = x.astype(complex)  # families take the number type of everything from x
    close(dv, gradient(lambda w: force(z, w, a), v), "dh/dv", tolerance)


def check_gravity(family: Family, x: Any, g: Any, branch: Any = None, tolerance: float = TOLERANCE) -> Any:
    """Weight by the contract: inertia force of the acceleration g at the positions; returns M g (nx, n)."""
    c = evaluate(family, x, branch)[0]
    a = np.zeros_like(x)
    for k, row in enumerate(family.position_rows):
        a[row] = g[k % len(g)]
    rest = np.zeros_like(x)
    weight = family.inertia_force(c, rest, a) - family.inertia_force(c, rest, None)
    close(weight, (mass_of(family, x, branch) * a).sum(1), "weight = M g", tolerance)
    return weight
