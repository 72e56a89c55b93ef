"""The element types in SymPy, one row each: deformations D(x), slips, inertia.

The formulas are in `planar_definitions` and `spatial_definitions`.

Used to derive `kernels.c` and `derivatives.c`, and in tests as an independent statement of the elements.

Everything that is not said here follows by differentiation: V, H(v,v), M, h. For elements with mass the quantities y(x)
are those in which the kinetic energy is 1/2 y'^T C y' with a constant C, so that M = Y^T C Y and h = Y^T C y''(x + s v)
with Y = dy/dx.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from spacar.compiled import planar_definitions as planar
from spacar.compiled import spatial_definitions as spatial
from spacar.compiled.planar_definitions import FLOW
from spacar.compiled.spatial_definitions import ENDS, FRAME, START


def no_strain(x: list, p: dict) -> list:
    return []


@dataclass(frozen=True)
class Definition:
    """One element type: number of coordinates, names of its parameters, and functions of both.

    Definitions that share a function share it in C when their parameters agree as far as both go.
    """

    name: str
    n_coordinates: int
    parameters: tuple[str, ...]
    strain: Callable[[list[sp.Symbol], dict[str, sp.Symbol]], list[sp.Expr]] = no_strain  # D(z)
    line: Callable[[list[sp.Symbol], dict[str, sp.Symbol]], tuple[list[sp.Expr], sp.Matrix]] | None = None  # y, C
    inertia: Callable[[list, list, dict], tuple[sp.Matrix, list]] | None = None  # M, h where no y exists
    guard: Callable[[list, dict], list] | None = None  # of z; all beyond GUARD: surely in the range of the theory
    local: Callable[[list, dict], list] | None = None  # z(x), linear in x; without it, z = x
    slips: Callable[[list, list, dict], list] | None = None  # rates (x, v, p), linear in v, that are rows of V behind D
    turn: Callable[[dict], list] | None = None  # change of D when its angle grows by a whole turn
    angle: Callable[[list, list, dict], sp.Expr] | None = None  # in which turns are counted, of x, D; without it, D[0]
    flow: Callable[[dict], tuple[sp.Matrix, sp.Matrix]] | None = None  # D, A of the force D y' + A y in h


PLBEAM = ("l0", "beta_p", "beta_q", "A", "B", "s0", "s1", "s2", "unit", "lumped")
PLANGLE = (*PLBEAM[:-1], "rotary")
BEAM = ("l0", *ENDS, "f", "second", "unit", "sz", "sy")
ANGLE = ("alpha", "beta", "by", "bz")

DEFINITIONS = (
    Definition(
        "plbeam", 6, PLBEAM, planar.plbeam_strain, planar.plbeam_line,
        guard=planar.plbeam_guard, local=planar.plbeam_local,
    ),
    Definition(
        "plbeam_angle", 6, PLANGLE, planar.plbeam_angle_strain, planar.plbeam_angle_line,
        guard=planar.plbeam_guard, local=planar.plbeam_local,
    ),
    Definition(
        "pltube", 6, (*PLBEAM, *FLOW), planar.plbeam_strain, planar.plbeam_line,
        guard=planar.plbeam_guard, local=planar.plbeam_local, flow=planar.flow_matrices,
    ),
    Definition(
        "pltube_angle", 6, (*PLANGLE, *FLOW), planar.plbeam_angle_strain, planar.plbeam_angle_line,
        guard=planar.plbeam_guard, local=planar.plbeam_local, flow=planar.flow_matrices,
    ),
    Definition("pltruss", 4, ("l0",), planar.truss_strain, guard=planar.truss_guard),
    Definition("pltor", 2, (), planar.pltor_strain),
    Definition("plpinbod", 5, ("a0", "b0", "d0", "a1", "b1", "d1"), planar.plpinbod_strain),
    Definition("plwheel", 4, ("radius", "angle"), slips=planar.plwheel_slips),
    Definition(
        "plbelt", 6, ("l0", "r_p", "r_q", "u0", "u1", "unit", *(f"wound_{k}" for k in range(6))), planar.plbelt_strain,
        inertia=planar.plbelt_inertia, guard=planar.plbelt_guard, turn=planar.plbelt_turn, angle=planar.plbelt_angle,
    ),
    Definition(
        "beam", 14, (*BEAM, *START), spatial.beam_strain, spatial.beam_line,
        guard=spatial.beam_guard, local=spatial.beam_local,
    ),
    Definition(
        "beam_angle", 14, (*BEAM, *START, *ANGLE), spatial.beam_angle_strain, spatial.beam_line,
        guard=spatial.beam_angle_guard, local=spatial.beam_local,
    ),
    Definition(
        "tube", 14, (*BEAM, *START, *FLOW), spatial.beam_strain, spatial.beam_line,
        guard=spatial.beam_guard, local=spatial.beam_local, flow=planar.flow_matrices,
    ),
    Definition(
        "tube_angle", 14, (*BEAM, *START, *ANGLE, *FLOW), spatial.beam_angle_strain, spatial.beam_line,
        guard=spatial.beam_angle_guard, local=spatial.beam_local, flow=planar.flow_matrices,
    ),
    Definition(
        "beamw", 16, BEAM, spatial.beamw_strain, spatial.beamw_line,
        guard=spatial.beamw_guard, local=spatial.beamw_local,
    ),
    Definition(
        "beamw_angle", 16, BEAM, spatial.beamw_angle_strain, spatial.beamw_line,
        guard=spatial.beamw_angle_guard, local=spatial.beamw_local,
    ),
    Definition("truss", 6, ("l0",), planar.truss_strain, guard=planar.truss_guard),
    Definition("hinge", 8, FRAME, spatial.hinge_strain, turn=spatial.hinge_turn),
    Definition("pinbody", 10, (*FRAME, "r0", "r1", "r2"), spatial.pinbody_strain),
    Definition("screw", 14, (*FRAME, "r0", "r1", "r2", "pitch"), spatial.screw_strain, turn=spatial.screw_turn),
    Definition(
        "wheel", 10, ("a0", "a1", "a2", "radius", "rho", "height"), spatial.wheel_strain,
        guard=spatial.wheel_guard, slips=spatial.wheel_slips,
    ),
    Definition("normalization", 4, (), spatial.normalization_strain),
    Definition("body", 4, ("J00", "J01", "J02", "J11", "J12", "J22"), inertia=spatial.body_inertia),
)  # fmt: skip
