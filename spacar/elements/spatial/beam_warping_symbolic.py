"""BEAMW in SymPy (theory-warping.md section 3; its angle measure in theory-beam-order4.md section 2.8)."""

import sympy as sp

from spacar.elements.definition_symbolic import Definition, length
from spacar.elements.spatial.beam_symbolic import (
    BEAM,
    beam_angle_guard,
    beam_angles,
    beam_guard,
    beam_line,
    beam_local,
    beam_raw,
    beam_second_order,
)


def without_warping(x: list) -> list:
    """The coordinates of a beam among those of a beam with warping."""
    return [*x[:7], *x[8:15]]


def beamw_local(x: list, p: dict) -> list:
    return [*beam_local(without_warping(x), p), x[7], x[15]]


def beamw_strain(z: list, p: dict) -> list:
    """theory-warping.md section 3."""
    e1, e2, e3, e4, e5, e6 = beam_raw(z[:15], p)
    k, l0 = p["second"], p["l0"]
    e7, e8 = e2 - l0**2 * z[15], l0**2 * z[16] - e2
    (z_, y, left_z, left_y), bent, both = beam_second_order((e3, e4, e5, e6), p)
    twisted = e2**2 + (2 * e7**2 + e7 * e8 + 2 * e8**2) / 15
    at_p, at_q = e2 / 4 + e7 / 20, e2 / 4 - e8 / 20
    return [
        e1 + k * (bent + p["f"] * twisted / (2 * l0**3)),
        e2 + k * both,
        e3 + k * (e2 * y / 6 - e5 * e7 / 10 - e8 * y / 30 - left_y * at_p) / l0,
        e4 + k * (-e2 * y / 6 - e6 * e8 / 10 - e7 * y / 30 - left_y * at_q) / l0,
        e5 + k * (-e2 * z_ / 6 + e3 * e7 / 10 + e8 * z_ / 30 + left_z * at_p) / l0,
        e6 + k * (e2 * z_ / 6 + e4 * e8 / 10 + e7 * z_ / 30 + left_z * at_q) / l0,
        e7 + k * both,
        e8 - k * both,
    ]


def beamw_angle_strain(z: list, p: dict) -> list:
    """theory-beam-order4.md section 2.8."""
    psi, Ay, Az = beam_angles(z[:15], p)
    l0, k, wp, wq = p["l0"], p["second"], z[15], z[16]
    ay, az = Ay * p["sz"], Az * p["sy"]
    Mx = psi[0] + k * (ay * psi[2] - az * psi[1]) / 2
    A, c = l0 * (wq - wp) / 6, l0 * (wp + wq) / 2 - Mx
    My = psi[1] + k * (az * psi[0] / 2 - A * psi[2] / 2 - c * az / 10)
    Mz = psi[2] - k * (ay * psi[0] / 2 - A * psi[1] / 2 - c * ay / 10)
    Ay, Az = Ay - k * (3 * A * az / 10 + c * psi[2] / 30), Az + k * (3 * A * ay / 10 + c * psi[1] / 30)
    bent = (psi[1] ** 2 + psi[2] ** 2) / 24 + (ay**2 + az**2) / 40
    twisted = Mx**2 + 3 * A**2 + c**2 / 5
    e1 = length(z[:3]) - l0 + k * (l0 * bent + p["f"] * twisted / (2 * l0))
    bending = [l0 * (My - Ay) / 2, l0 * (My + Ay) / 2, l0 * (Mz - Az) / 2, l0 * (Mz + Az) / 2]
    return [e1, l0 * Mx, *bending, l0 * Mx - l0**2 * wp, l0**2 * wq - l0 * Mx]


def beamw_line(x: list, p: dict) -> tuple[list, sp.Matrix]:
    return beam_line(without_warping(x), p)


def beamw_guard(z: list, p: dict) -> list:
    return beam_guard(z[:15], p)


def beamw_angle_guard(z: list, p: dict) -> list:
    return beam_angle_guard(z[:15], p)


DEFINITIONS = (
    Definition("beamw", 16, BEAM, beamw_strain, beamw_line, guard=beamw_guard, local=beamw_local),
    Definition("beamw_angle", 16, BEAM, beamw_angle_strain, beamw_line, guard=beamw_angle_guard, local=beamw_local),
)
