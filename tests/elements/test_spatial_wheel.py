"""WHEEL and TWHEEL: deformations and slips against definitions, derivatives, rolling, start geometry."""

from typing import Any

import numpy as np
import pytest

from spacar.elements.family import Family, GeometryError
from spacar.elements.spatial.wheel import DiskWheel, TorusWheel

from .derivatives import check_strain, close, evaluate, gradient, group, written
from .spatial_truth import moved, rotation, turn

N = 5
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


@pytest.mark.parametrize("keyword", ["WHEEL", "TWHEEL"])
def test_slips_are_not_integrable(keyword: str) -> None:
    """H1 and H2 of the slips differ (a rolling wheel has no position constraint); those of e1..e4 agree."""
    family, x0, _, _ = wheels(keyword)
    rng = np.random.default_rng(3)
    v = rng.normal(size=x0.shape)
    c = evaluate(family, x0)[0]
    H1, H2 = (written(m, (6, 10, N), float, c, v) for m in (family.gradient_rate, family.gradient_transport))
    close(H1[:4], H2[:4], "holonomic", 1e-15)
    assert (np.abs(H1[4:] - H2[4:]).max(axis=1) > 0.1).all()


@pytest.mark.parametrize("keyword", ["WHEEL", "TWHEEL"])
def test_no_slip_means_that_the_material_contact_point_is_at_rest(keyword: str) -> None:
    """For rates that keep e1..e4 and both slips zero, dx_p + w x d = 0; three such motions are free."""
    family, x0, _, _ = wheels(keyword)
    rng = np.random.default_rng(4)
    lam = turn(UP, 0.8)  # a turn about the vertical keeps the wheel on the ground
    x = x0.copy()
    for k in range(N):
        x[:3, k], x[7:, k] = rotation(lam) @ x0[:3, k], rotation(lam) @ x0[7:, k]
        x[3:7, k] = lam
    _, e, V = evaluate(family, x)
    close(e, np.zeros((6, N)), "on the ground", 1e-15)
    for k in range(N):
        rows = np.vstack((V[:, :, k], np.concatenate((np.zeros(3), x[3:7, k], np.zeros(3)))))
        free = np.linalg.svd(rows)[2][7:]
        assert len(free) == 3
        u = rng.normal(size=3) @ free
        spin = (rotation(x[3:7, k] + 1e-30j * u[3:7]).imag / 1e-30) @ rotation(x[3:7, k]).T
        contact = u[:3] + spin @ (x[7:, k] - x[:3, k])
        np.testing.assert_allclose(contact, np.zeros(3), atol=1e-14)
        assert np.linalg.norm(u[:3]) > 1e-3  # and it rolls


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


def test_slip_rates_are_the_transport_of_the_rows() -> None:
    """H(v,v) of a slip is d(W v)/dt at zero accelerations, a second way to the checker's contraction."""
    family, x0, _, _ = wheels("WHEEL")
    rng = np.random.default_rng(5)
    v = rng.normal(size=x0.shape)
    c = evaluate(family, x0)[0]
    slip = gradient(lambda z: (evaluate(family, z)[2] * v).sum(1), x0)
    close(written(family.convective_strain, (6, N), float, c, v), (slip * v).sum(1), "H(v,v)")


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
