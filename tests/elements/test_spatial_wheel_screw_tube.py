"""SCREW, TUBE, WHEEL and TWHEEL: definitions, derivatives, turns, slips; forces of the fluid."""

from typing import Any

import numpy as np
import pytest

from spacar.elements.family import Family, GeometryError
from spacar.elements.spatial.beam import SpatialBeam
from spacar.elements.spatial.screw import Screw
from spacar.elements.spatial.tube import SpatialTube
from spacar.elements.spatial.wheel import DiskWheel, TorusWheel

from .derivatives import check_gravity, check_inertia, check_strain, close, evaluate, group
from .spatial_truth import G, chord_frame, moved, rates, reference, rotation, turn
from .test_spatial_joints import hinge_frame

N = 5
LAYOUT = "xlxl"


def test_screw_definition_and_derivatives() -> None:
    rng = np.random.default_rng(1)
    x0 = reference(rng, N, LAYOUT)
    geometry = rng.normal(size=(N, 4))
    family = Screw(group("SCREW", x0, geometry=geometry, estiff=[range(1, 7)] * N))
    x = moved(rng, x0, LAYOUT, angle=1.0)
    truth = []
    for k in range(N):
        frame = hinge_frame(geometry[k, :3])
        Rp, Rq = rotation(x[3:7, k]) @ frame, rotation(x[10:, k]) @ frame
        phi = np.arctan2(Rp[:, 2] @ Rq[:, 1] - Rp[:, 1] @ Rq[:, 2], Rp[:, 1] @ Rq[:, 1] + Rp[:, 2] @ Rq[:, 2])
        s = Rp.T @ (x[7:10, k] - x[:3, k]) - frame.T @ (x0[7:10, k] - x0[:3, k])
        truth.append((phi, s[0] - geometry[k, 3] * phi, s[1], s[2], -Rp[:, 2] @ Rq[:, 0], Rp[:, 1] @ Rq[:, 0]))
    close(evaluate(family, x)[1], np.transpose(truth), "e")
    close(evaluate(family, x0)[1], np.zeros((6, N)), "start")
    check_strain(family, x + 0.1 * rng.normal(size=x.shape), rng.normal(size=x.shape), rng.normal(size=(6, N)))
    np.testing.assert_array_equal(family.stiffness()[0][:, :, 0], np.diag(np.arange(1.0, 7)))


def test_screw_moves_steadily_over_turns() -> None:
    """x_q advances by h phi: e2 stays zero over three turns when the branch follows."""
    x0 = np.zeros((14, 1))
    x0[[3, 10]] = 1.0
    family, near = Screw(group("SCREW", x0, geometry=[(1.0, 0, 0, 0.01)])), np.zeros((6, 1))
    for phi in np.arange(0.0, 20.0):
        x = x0.copy()
        x[7] = 0.01 * phi
        x[10:, 0] = turn((1, 0, 0), phi)
        _, near, _ = evaluate(family, x, near)
        np.testing.assert_allclose(near[:, 0], [phi, 0, 0, 0, 0, 0], atol=1e-13)


def test_screw_without_axis() -> None:
    with pytest.raises(GeometryError, match="axis"):
        Screw(group("SCREW", reference(np.random.default_rng(0), 1, LAYOUT), geometry=[(1.0, 0)]))


FLOW = (1.2, 0.8, 0.6, 1.1)


def tubes(end: float, **kwargs: Any) -> tuple[SpatialTube, Any, Any, Any]:
    rng = np.random.default_rng(2)
    x0 = reference(rng, N, LAYOUT)
    em = np.column_stack([np.tile((*FLOW, end), (N, 1)), rng.uniform(0.1, 1.0, (N, 3)), np.zeros(N)])
    family = SpatialTube(group("TUBE", x0, em=em, **kwargs))
    x = moved(rng, x0, LAYOUT)
    return family, x0, x, rates(rng, x, LAYOUT)


def test_tube_without_flow_is_a_beam() -> None:
    rng = np.random.default_rng(3)
    x0 = reference(rng, N, LAYOUT)
    kwargs: dict[str, Any] = {"geometry": rng.normal(size=(N, 4)), "estiff": rng.uniform(1, 2, (N, 6))}
    em = np.zeros((N, 9))
    em[:, [0, 5, 6, 7]], em[:, 1], em[:, 3] = rng.uniform(1, 2, (N, 4)), 0.5, 1.0
    tube = SpatialTube(group("TUBE", x0, em=em, **kwargs))
    beam_em = np.column_stack((em[:, 0] + em[:, 1], em[:, 5:9]))
    beam = SpatialBeam(group("BEAM", x0, em=beam_em, **kwargs))
    x = moved(rng, x0, LAYOUT)
    v, a = rng.normal(size=(2, *x.shape))
    (ct, et, Vt), (cb, eb, Vb) = evaluate(tube, x), evaluate(beam, x)
    np.testing.assert_array_equal(et, eb)
    np.testing.assert_array_equal(Vt, Vb)
    np.testing.assert_array_equal(tube.inertia_force(ct, v, a), beam.inertia_force(cb, v, a))
    np.testing.assert_array_equal(tube.stiffness()[0], beam.stiffness()[0])
    for (i, J), (j, K) in zip(tube.orientation_inertia(), beam.orientation_inertia(), strict=True):
        assert i == j
        np.testing.assert_array_equal(J, K)


@pytest.mark.parametrize("end", [0.0, 1.0, 2.0, 3.0])
def test_fluid_derivatives(end: float) -> None:
    family, _, x, v = tubes(end)
    rng = np.random.default_rng(4)
    check_inertia(family, x, v, rng.normal(size=x.shape), lagrange=False)
    check_gravity(family, x, G)


def centre_line(x: Any, l0: float, frame: Any) -> Any:
    """y (4, 3) of one tube with the same frame at both ends."""
    return np.stack([x[:3], l0 * rotation(x[3:7]) @ frame[:, 0], x[7:10], l0 * rotation(x[10:]) @ frame[:, 0]])


@pytest.mark.parametrize("end", [0, 1, 2, 3])
def test_fluid_momentum_balance(end: int) -> None:
    """Virtual power of the fluid forces by quadrature, with numerical derivatives of the centre line.

    Lagrange's derivative of the flow terms Q dr.r' + a Q^2 |r'|^2/(2 m_f) of the kinetic energy, and at a jet
    the momentum Q (dr + U r') that leaves (at q) or enters (at p). Five Gauss points integrate the cubics
    exactly.
    """
    family, x0, x, v = tubes(end)
    c = evaluate(family, x)[0]
    no_flow = tubes(end)[0]
    no_flow.line = no_flow.line._replace(D=None, A=None)
    got = family.inertia_force(c, v, None) - no_flow.inertia_force(evaluate(no_flow, x)[0], v, None)
    _, fluid, flow, shape = FLOW
    nodes, weights = np.polynomial.legendre.leggauss(5)
    xi, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    shapes = np.stack([1 - 3 * xi**2 + 2 * xi**3, xi - 2 * xi**2 + xi**3, 3 * xi**2 - 2 * xi**3, xi**3 - xi**2])
    slopes = np.stack([6 * xi**2 - 6 * xi, 1 - 4 * xi + 3 * xi**2, 6 * xi - 6 * xi**2, 3 * xi**2 - 2 * xi])
    for k in range(N):
        d0 = x0[7:10, k] - x0[:3, k]
        l0 = float(np.linalg.norm(d0))
        frame = chord_frame(d0, np.eye(3)[np.argmin(np.abs(d0))])
        J = np.zeros((4, 3, 14))
        for j in range(14):
            z = x[:, k].astype(complex)
            z[j] += 1e-30j
            J[:, :, j] = centre_line(z, l0, frame).imag / 1e-30
        y, dy = centre_line(x[:, k], l0, frame), J @ v[:, k]
        thrust = shape * flow**2 / (fluid * l0)
        mixed = np.einsum("ig,jg,g->ij", shapes, slopes, weights)
        stretch = np.einsum("ig,jg,g->ij", slopes, slopes, weights)
        w = flow * (mixed - mixed.T) @ dy - thrust * stretch @ y
        if end in (2, 3):
            w[2] += flow * dy[2] + thrust * y[3]
        if end in (1, 3):
            w[0] -= flow * dy[0] + thrust * y[1]
        np.testing.assert_allclose(got[:, k], np.einsum("aij,ai->j", J, w), rtol=1e-11, atol=1e-12)


def test_curved_tube_starts_undeformed_with_its_own_frames() -> None:
    rng = np.random.default_rng(5)
    x0 = reference(rng, N, LAYOUT)
    directions = []
    for k in range(N):
        d = x0[7:10, k] - x0[:3, k]
        small = 0.3 * np.linalg.norm(d) * rng.normal(size=(2, 3))
        directions.append((*(d + small[0]), *(d + small[1]), *rng.normal(size=3)))
    family = SpatialTube(
        group("TUBE", x0, geometry=rng.normal(size=(N, 3)), directions=directions, em=[(*FLOW, 2.0)] * N)
    )
    close(evaluate(family, x0)[1], np.zeros((6, N)), "start", 1e-15)
    for k in range(N):  # the frames by their definition
        p = chord_frame(np.array(directions[k][:3]), np.array(group_direction(family, k)))
        q = chord_frame(np.array(directions[k][3:6]), np.array(directions[k][6:]))
        np.testing.assert_allclose(np.reshape(family.frame_p[k], (3, 3)).T, p, atol=1e-13)  # type: ignore[index]
        np.testing.assert_allclose(np.reshape(family.frame_q[k], (3, 3)).T, q, atol=1e-13)  # type: ignore[index]
    x = moved(rng, x0, LAYOUT)
    # raw torsion by rotation matrices with the two frames
    linear = SpatialTube(
        group(
            "TUBE", x0, directions=directions, nonlinear=np.zeros(N, bool),
            geometry=[group_direction(family, k) for k in range(N)],
        )
    )  # fmt: skip
    _, raw, _ = evaluate(linear, x)
    for k in range(N):
        twist = []
        for state in (x, x0):
            P = rotation(state[3:7, k]) @ np.reshape(family.frame_p[k], (3, 3)).T  # type: ignore[index]
            Q = rotation(state[10:, k]) @ np.reshape(family.frame_q[k], (3, 3)).T  # type: ignore[index]
            twist.append(0.5 * family.length[k] * (P[:, 2] @ Q[:, 1] - P[:, 1] @ Q[:, 2]))
        assert raw[1, k] == pytest.approx(twist[0] - twist[1], abs=1e-13)
    check_strain(family, x, rng.normal(size=x.shape), rng.normal(size=(6, N)))
    check_inertia(family, x, rng.normal(size=x.shape), rng.normal(size=x.shape), lagrange=False)


def group_direction(family: SpatialTube, k: int) -> tuple[float, ...]:
    """A vector in the x'y' plane at p that gives the frame of element k again: its y'."""
    assert family.frame_p is not None
    return tuple(family.frame_p[k, 3:6])


@pytest.mark.parametrize(
    ("em", "directions", "words"),
    [
        ((1.0, 0, 2.0, 1, 0), None, "fluid mass"),
        ((1.0, 1, 2.0, 1, 4), None, "end condition"),
        ((1.0,), (1.0, 0, 0), "9 values"),
        ((1.0,), (1.0, 0, 0, 1, 0, 0, 1, 0, 0), "parallel"),
    ],
)
def test_impossible_tube(em: Any, directions: Any, words: str) -> None:
    x0 = reference(np.random.default_rng(0), 1, LAYOUT)
    with pytest.raises(GeometryError, match=words):
        SpatialTube(group("TUBE", x0, em=[em], directions=[directions]))


# WHEEL and TWHEEL: deformations and slips against definitions, derivatives, rolling, start geometry.
UP = np.array([0.0, 0.0, 1.0])
RHO = 0.08


def start(rng: Any, rho: float) -> tuple[Any, Any, Any]:
    """Leaning wheels on the ground: x0 (10, N), spin axes (N, 3), equatorial radii (N,)."""
    axes = np.column_stack((rng.normal(size=(N, 2)), 0.3 * rng.normal(size=N)))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    radius = rng.uniform(0.3, 0.5, N)
    x0 = np.zeros((10, N))
    for k in range(N):
        down = -UP + (UP @ axes[k]) * axes[k]
        r = (radius[k] - rho) * down / np.linalg.norm(down)  # from the centre to the tread circle, lowest point
        contact = np.array([*rng.normal(size=2), 0.0])
        x0[:, k] = np.concatenate((contact - (r - rho * UP), [1, 0, 0, 0], contact))
    return x0, axes, radius


def wheels(keyword: str, seed: int = 1) -> tuple[Family, Any, Any, Any]:
    """Family, start configuration, axes, tread circle radii."""
    rng = np.random.default_rng(seed)
    if keyword == "WHEEL":
        x0, axes, radius = start(rng, 0.0)
        return DiskWheel(group(keyword, x0, geometry=axes)), x0, axes, radius
    x0, axes, radius = start(rng, RHO)
    geometry = np.column_stack((radius, np.full(N, RHO), axes))
    return TorusWheel(group(keyword, x0, geometry=geometry)), x0, axes, radius - RHO


@pytest.mark.parametrize("keyword", ["WHEEL", "TWHEEL"])
def test_definition_and_derivatives(keyword: str) -> None:
    rng = np.random.default_rng(2)
    family, x0, axes, r0 = wheels(keyword)
    rho = 0.0 if keyword == "WHEEL" else RHO
    close(evaluate(family, x0)[1], np.zeros((6, N)), "start", 1e-15)
    x = moved(rng, x0, "xlx", shift=0.05)
    v = rng.normal(size=x.shape)
    _, e, V = evaluate(family, x)
    for k in range(N):
        lam, rate = x[3:7, k], v[3:7, k] - (v[3:7, k] @ x[3:7, k]) * x[3:7, k]
        R = rotation(lam)
        spin = (rotation(lam + 1e-30j * rate).imag / 1e-30) @ R.T  # dR/dt R^T, skew
        w = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        a, rc = R @ axes[k], x[7:, k] - x[:3, k]
        r = rc + rho * UP
        t = np.cross(r, a)
        s = np.cross(UP, t)
        truth = (np.linalg.norm(r) - r0[k], a @ r, x[9, k], r @ np.cross(a, UP), 0.0, 0.0)
        np.testing.assert_allclose(e[:, k], truth, atol=1e-14)
        u = np.concatenate((v[:3, k], rate, v[7:, k]))
        np.testing.assert_allclose(V[4, :, k] @ u, t @ (u[:3] + np.cross(w, rc)), atol=1e-13)
        np.testing.assert_allclose(V[5, :, k] @ u, s @ (u[7:] - rho * np.cross(w, UP)), atol=1e-13)
    # far off the ground and off the unit sphere, where no term vanishes
    far = x + 0.2 * rng.normal(size=x.shape)
    check_strain(family, far, v, rng.normal(size=(6, N)))


def test_contact_force() -> None:
    """Equilibrium of the contact node without lateral force: sigma4 = 0, the road pushes along the normal."""
    family, x0, _, _ = wheels("TWHEEL")
    _, _, V = evaluate(family, x0)
    for k in range(N):
        rows = V[[0, 1, 2, 3, 5], 7:, k]  # slip 5 does not act on the contact node
        given = np.array([2.0, 0.0])  # normal compression -sigma3 = 2, lateral sigma6 = 0
        sigma = np.linalg.solve(rows[[0, 1, 3]].T, given[0] * UP)
        assert sigma[2] == pytest.approx(0.0, abs=1e-14)
        road = sigma[0] * rows[0] + sigma[1] * rows[1]
        np.testing.assert_allclose(road, given[0] * UP, atol=1e-14)
        assert sigma[0] < 0.0  # compression of the wheel


@pytest.mark.parametrize(
    ("shift", "words"),
    [
        ((0, 0, 0.01), "above the ground"),
        ((0, 0.01, 0), "off the plane"),
        ((0.01, 0, 0), "beside the lowest"),
        ((0, 0, 1.0), "not below"),
    ],
)
def test_wrong_contact_point(shift: Any, words: str) -> None:
    x0 = np.array([[0.0, 0, 0.3, 1, 0, 0, 0, 0, 0, 0]]).T
    DiskWheel(group("WHEEL", x0, geometry=[(0.0, 1, 0)]))
    x0[7:, 0] += shift
    with pytest.raises(GeometryError, match=words):
        DiskWheel(group("WHEEL", x0, geometry=[(0.0, 1, 0)]))


def test_wrong_statement() -> None:
    x0 = np.array([[0.0, 0, 0.3, 1, 0, 0, 0, 0, 0, 0]]).T
    for geometry, words in (((), "spin axis"), ((0.0, 0, 1), "vertical"), ((0.0, 0, 0), "zero vector")):
        with pytest.raises(GeometryError, match=words):
            DiskWheel(group("WHEEL", x0, geometry=[geometry]))
    with pytest.raises(GeometryError, match="exceed the transverse"):
        TorusWheel(group("TWHEEL", x0, geometry=[(0.1, 0.2, 0.0, 1, 0)]))
    with pytest.raises(GeometryError, match="two radii"):
        TorusWheel(group("TWHEEL", x0, geometry=[(0.1, 0.0, 1, 0)]))


def test_troubles() -> None:
    family, x0, _, _ = wheels("WHEEL")
    c, e, _ = evaluate(family, x0)
    assert not family.troubles(c, e, e)
    x = x0.copy()
    x[9, 2] += 1e-5
    c, e, _ = evaluate(family, x)
    (trouble,) = family.troubles(c, e, e)
    assert (trouble.index, trouble.fatal) == (2, True)
    assert "leaves the ground plane" in trouble.text
