"""Vectors and Euler parameters in SymPy, for the definitions of spatial elements (theory-spatial.md section 1)."""

import sympy as sp

FRAME = tuple(f"{axis}{k}" for axis in ("fx", "fy", "fz") for k in range(3))  # start frame at p


def numbers(name: str, n: int, p: dict) -> list:
    return [p[f"{name}{k}"] for k in range(n)]


def frame(p: dict, name: str = "f") -> tuple[list, list, list]:
    return tuple(numbers(f"{name}{axis}", 3, p) for axis in "xyz")  # type: ignore[return-value]


def cross(a: list, b: list) -> list:
    return list(sp.Matrix(a).cross(sp.Matrix(b)))


def rotated(lam: list, c: list) -> list:
    """R(lambda) c in the homogeneous quadratic form."""
    l0, l = lam[0], sp.Matrix(lam[1:])
    v = sp.Matrix(c)
    return list((l0**2 - l.dot(l)) * v + 2 * l.dot(v) * l + 2 * l0 * l.cross(v))


def relative(p: list, q: list, axis: list) -> sp.Expr:
    """mu_axis of the rotation of q relative to p."""
    lp, lq, a = sp.Matrix(p[1:]), sp.Matrix(q[1:]), sp.Matrix(axis)
    return p[0] * a.dot(lq) - q[0] * a.dot(lp) - lp.cross(lq).dot(a)


def body_map(lam: list) -> sp.Matrix:
    """L(lambda), (3, 4): the angular velocity in body components is 2 L lambda'."""
    a, b, c, d = lam
    return sp.Matrix([[-b, a, d, -c], [-c, -d, a, b], [-d, c, -b, a]])


def global_map(lam: list) -> sp.Matrix:
    """The same for global components: [-l, lambda0 I + l~]."""
    a, b, c, d = lam
    return sp.Matrix([[-b, a, -d, c], [-c, d, a, -b], [-d, -c, b, a]])
