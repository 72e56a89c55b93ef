"""BEAM: deformations against the definition with rotation matrices, derivatives, inertia, stiffness, limits.

Tolerances: 1e-12 relative (see `derivatives`) unless a test says otherwise.
"""

from typing import Any

import numpy as np
import pytest

import spacar
from spacar.elements.family import GeometryError
from spacar.elements.spatial.beam import SpatialBeam

from .derivatives import check_gravity, check_inertia, check_strain, close, evaluate, group, mass_of
from .spatial_truth import G, chord_frame, moved, rates, reference, rotation, turn

LAYOUT = "xlxl"
N = 7


def random_beams(seed: int, **kwargs: Any) -> tuple[SpatialBeam, Any, Any, Any]:
    """Beams, start configuration, moved configuration and rates."""
    rng = np.random.default_rng(seed)
    x0 = reference(rng, N, LAYOUT)
    geometry = [(*rng.normal(size=3), rng.uniform(-0.05, 0.05)) for _ in range(N)]
    beams = SpatialBeam(group("BEAM", x0, geometry=geometry, **kwargs))
    x = moved(rng, x0, LAYOUT)
    return beams, x0, x, rates(rng, x, LAYOUT)


def deformations(x0: Any, geometry: Any, x: Any, nonlinear: bool) -> Any:
    """e (6,) of one beam from theory-spatial.md section 3.1."""
    d0, d = x0[7:10] - x0[:3], x[7:10] - x[:3]
    l0, l = np.linalg.norm(d0), np.linalg.norm(d)
    frame = chord_frame(d0, np.array(geometry[:3]))
    Rp, Rq = rotation(x[3:7]) @ frame, rotation(x[10:14]) @ frame
    n, f1 = d / l, geometry[3]
    b1 = l - l0
    b2 = 0.5 * l0 * (Rp[:, 2] @ Rq[:, 1] - Rp[:, 1] @ Rq[:, 2])
    b3, b4 = -l0 * n @ Rp[:, 2], l0 * n @ Rq[:, 2]
    b5, b6 = l0 * n @ Rp[:, 1], -l0 * n @ Rq[:, 1]
    if not nonlinear:
        return np.array([b1, b2, b3, b4, b5, b6])
    bending = 2 * b3**2 + b3 * b4 + 2 * b4**2 + 2 * b5**2 + b5 * b6 + 2 * b6**2
    return np.array(
        [
            b1 + bending / (30 * l0) + f1 * b2**2 / (2 * l0**3),
            b2 + (b4 * b5 - b3 * b6) / l0,
            b3 + b2 * (b5 + b6) / (6 * l0),
            b4 - b2 * (b5 + b6) / (6 * l0),
            b5 - b2 * (b3 + b4) / (6 * l0),
            b6 + b2 * (b3 + b4) / (6 * l0),
        ]
    )


@pytest.mark.parametrize("linear", [(), (0, 3), range(N)])
def test_definition_and_derivatives(linear: Any) -> None:
    nonlinear = np.ones(N, bool)
    nonlinear[list(linear)] = False
    rng = np.random.default_rng(3)
    x0 = reference(rng, N, LAYOUT)
    geometry = [(*rng.normal(size=3), rng.uniform(-0.05, 0.05)) for _ in range(N)]
    beams = SpatialBeam(group("BEAM", x0, geometry=geometry, nonlinear=nonlinear))
    x = moved(rng, x0, LAYOUT)
    _, e, _ = evaluate(beams, x)
    truth = [deformations(x0[:, k], geometry[k], x[:, k], nonlinear[k]) for k in range(N)]
    close(e, np.transpose(truth), "e")
    close(evaluate(beams, x0)[1], np.zeros((6, N)), "undeformed")
    # the formulas hold off the unit sphere too
    check_strain(beams, x + 0.1 * rng.normal(size=x.shape), rng.normal(size=x.shape), rng.normal(size=(6, N)))


def test_small_rotations_have_the_stated_signs() -> None:
    """e2..6 = l0 (x_q - x_p, -y_p, y_q, -z_p, z_q) of small angles; error 1e-5^2 = 1e-10."""
    x0 = reference(np.random.default_rng(0), 1, LAYOUT)
    x0[:3, 0], x0[7:10, 0] = 0.0, (2.0, 0, 0)
    beam = SpatialBeam(group("BEAM", x0, geometry=[(0.0, 1, 0)]))
    small, expected = 1e-5, {("p", 0): (1, -1), ("q", 0): (1, 1), ("p", 1): (2, -1), ("q", 1): (3, 1)}
    expected |= {("p", 2): (4, -1), ("q", 2): (5, 1)}
    for (end, axis), (mode, sign) in expected.items():
        x = x0.copy()
        row = 3 if end == "p" else 10
        x[row : row + 4, 0] = turn(np.eye(3)[axis], small)
        truth = np.zeros((6, 1))
        truth[mode] = sign * 2.0 * small
        np.testing.assert_allclose(evaluate(beam, x)[1], truth, atol=1e-9)


def test_torsion_shortens_an_open_section() -> None:
    """Unloaded (e1 = 0): axial strain -f1 alpha^2/2; the sine law of eb2 changes it by 8e-4 at 0.05 rad."""
    f1, angle = 0.02, 0.05
    x0 = reference(np.random.default_rng(0), 1, LAYOUT)
    x0[:3, 0], x0[7:10, 0] = 0.0, (1.0, 0, 0)
    beam = SpatialBeam(group("BEAM", x0, geometry=[(f1,)]))
    x = x0.copy()
    x[10:14, 0] = turn((1, 0, 0), angle)
    assert evaluate(beam, x)[1][0, 0] == pytest.approx(0.5 * f1 * angle**2, rel=1e-3)


def test_inertia() -> None:
    beams, _, x, v = random_beams(6, em=np.random.default_rng(1).uniform(0.5, 2.0, (N, 1)))
    rng = np.random.default_rng(7)
    check_inertia(beams, x, v, rng.normal(size=x.shape))
    check_inertia(beams, x + 0.1 * rng.normal(size=x.shape), rng.normal(size=x.shape), rng.normal(size=x.shape))


def test_weight() -> None:
    """m l0 [g/2, (l0/12) B_p^T g, g/2, -(l0/12) B_q^T g]: B^T g is the gradient of x'.g."""
    rng = np.random.default_rng(8)
    x0 = reference(rng, N, LAYOUT)
    beams = SpatialBeam(group("BEAM", x0, em=np.full((N, 1), 1.7)))
    x = moved(rng, x0, LAYOUT)
    weight = check_gravity(beams, x, G)
    for k in range(N):
        d0 = x0[7:10, k] - x0[:3, k]
        l0, m = np.linalg.norm(d0), 1.7
        for row, sign in ((0, 1.0), (7, -1.0)):
            np.testing.assert_allclose(weight[row : row + 3, k], m * l0 * G / 2, rtol=1e-13)
            slope = np.zeros(4)
            for j in range(4):
                lam = x[row + 3 : row + 7, k].astype(complex)
                lam[j] += 1e-30j
                slope[j] = (G @ rotation(lam) @ (d0 / l0)).imag / 1e-30
            np.testing.assert_allclose(weight[row + 3 : row + 7, k], sign * m * l0**2 / 12 * slope, rtol=1e-11)


def test_rigid_beam_has_the_inertia_of_a_rod() -> None:
    """Kinetic energy of a straight beam in rigid motion = m l |v_c|^2/2 + (m l^3/12) |n x w|^2/2."""
    beams, x0, _, _ = random_beams(9, em=np.full((N, 1), 2.5))
    lam, w, origin = turn((1.0, 2.0, -0.5), 1.1), np.array([0.4, -1.3, 0.8]), np.array([0.2, 0.1, -0.6])
    R = rotation(lam)
    l0, l1, l2, l3 = lam
    bar = np.array([[-l1, l0, -l3, l2], [-l2, l3, l0, -l1], [-l3, -l2, l1, l0]])
    x, v = x0.copy(), np.zeros_like(x0)
    for row in (0, 7):
        x[row : row + 3] = R @ x0[row : row + 3]
        x[row + 3 : row + 7] = lam[:, None]
        v[row : row + 3] = np.cross(w, x[row : row + 3].T).T + origin[:, None]
        v[row + 3 : row + 7] = (0.5 * bar.T @ w)[:, None]
    energy = 0.5 * (mass_of(beams, x) * v * v[:, None]).sum((0, 1))
    d = x[7:10] - x[:3]
    l = np.linalg.norm(d, axis=0)
    centre = 0.5 * (v[:3] + v[7:10])
    spin = np.cross((d / l).T, w)
    truth = 0.5 * 2.5 * l * ((centre**2).sum(0) + l**2 / 12 * (spin**2).sum(1))
    np.testing.assert_allclose(energy, truth, rtol=1e-13)


def test_rotary_inertia_is_halved_and_turned() -> None:
    x0 = reference(np.random.default_rng(0), 1, LAYOUT)
    x0[:3, 0], x0[7:10, 0] = 0.0, (0, 0, 3.0)
    beam = SpatialBeam(group("BEAM", x0, geometry=[(1.0, 0, 0)], em=[(0.0, 1.0, 2.0, 3.0, 0.5)]))
    assert not beam.has_mass
    (p, Jp), (q, Jq) = beam.orientation_inertia()
    assert (p, q) == (3, 10)
    truth = 1.5 * np.array([[2.0, 0.5, 0], [0.5, 3.0, 0], [0, 0, 1.0]])  # x' = Z, y' = X, z' = Y
    np.testing.assert_allclose(Jp[0], truth, atol=1e-15)
    np.testing.assert_allclose(Jq, Jp)


def test_stiffness_with_shear() -> None:
    x0 = reference(np.random.default_rng(0), 1, LAYOUT)
    x0[:3, 0], x0[7:10, 0] = 0.0, (2.0, 0, 0)
    beam = SpatialBeam(group("BEAM", x0, estiff=[(4.0, 8, 16, 32, 0.5, 0.25)], edamp=[(1.0, 2, 3, 4)]))
    S, S_d = beam.stiffness()
    phi_z, phi_y = 12 * 0.5 / 4, 12 * 0.25 / 4
    assert S[0, 0, 0] == 2.0
    assert S[1, 1, 0] == 1.0
    bending = np.array([[4 + phi_z, -2 + phi_z], [-2 + phi_z, 4 + phi_z]]) * 16 / (8 * (1 + phi_z))
    np.testing.assert_allclose(S[2:4, 2:4, 0], bending)
    np.testing.assert_allclose(
        S_d[4:, 4:, 0], np.array([[4 + phi_y, phi_y - 2], [phi_y - 2, 4 + phi_y]]) * 0.5 / (1 + phi_y)
    )


def test_default_direction_is_the_highest_index_of_equals() -> None:
    x0 = reference(np.random.default_rng(0), 2, LAYOUT)
    x0[:3], x0[7:10] = 0.0, np.array([(1.0, 0, 0), (0, 1.0, 1e-14)]).T
    beams = SpatialBeam(group("BEAM", x0))
    assert beams.frame_p is not None
    np.testing.assert_allclose(beams.frame_p[0], [1, 0, 0, 0, 0, 1, 0, -1, 0], atol=1e-15)
    np.testing.assert_allclose(beams.frame_p[1], [0, 1, 0, 0, 0, 1, 1, 0, 0], atol=1e-13)


@pytest.mark.parametrize(
    ("geometry", "end", "words"),
    [
        ((2.0, 0, 0), (1.0, 0, 0), "parallel"),
        ((0.0, 0, 0), (1.0, 0, 0), "zero vector"),
        ((0.0, 1, 0), (0.0, 0, 0), "length"),
        ((0.0, 1), (1.0, 0, 0), "2 values"),
    ],
)
def test_impossible_geometry(geometry: Any, end: Any, words: str) -> None:
    x0 = reference(np.random.default_rng(0), 2, LAYOUT)
    x0[:3, 1], x0[7:10, 1] = 0.0, end
    with pytest.raises(GeometryError, match=words) as error:
        SpatialBeam(group("BEAM", x0, geometry=[(), geometry]))
    assert error.value.index == 1


@pytest.mark.parametrize(("degrees", "count", "fatal"), [(22.0, 0, False), (23.0, 1, False), (86.0, 1, True)])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_large_angles_are_reported(degrees: float, count: int, fatal: bool, axis: int) -> None:
    x0 = reference(np.random.default_rng(0), 1, LAYOUT)
    x0[:3, 0], x0[7:10, 0] = 0.0, (1.0, 0, 0)
    beam = SpatialBeam(group("BEAM", x0))
    x = x0.copy()
    x[10:14, 0] = turn(np.eye(3)[axis], np.radians(degrees))
    c, e, _ = evaluate(beam, x)
    found = beam.troubles(c, e, np.zeros_like(e))
    assert len(found) == count
    assert all(t.fatal == fatal and "more elements" in t.text for t in found)
    if not count:
        x[7:10] = 1e-8 * x0[7:10]
        c, e, _ = evaluate(beam, x)
        assert any(t.fatal and "collapsed" in t.text for t in beam.troubles(c, e, np.zeros_like(e)))


TWISTED = """HINGE 2 9 4 1 0 0\nBEAM 1 1 2 3 4 0 1 0\nX 3 1 0 0\nFIX 1\nFIX 2\nFIX 9\nFIX 3 2 3\nINPUTE 2 1
RLSE 1 2 3 4 5 6\nEND\nHALT\nESTIFF 1 0 1 1 1\nEM 1 1 0.01\nDELINPE 2 1 {angle}\nITERSTEP 20 4 1e-9 10 2\nEND\nEND\n"""


@pytest.mark.parametrize("compiled", [True, False])
@pytest.mark.parametrize("angle", [0.3, 0.38, 0.4, 0.7])
def test_warning_follows_from_the_error_of_the_measure(angle, compiled):
    """Torsion of a beam with GIt/l0 = 1: the torque is the angle; a warning where it is wrong by more than 10 %."""
    result = spacar.run(7, spacar.parse_deck(TWISTED.format(angle=angle), mode=7), compiled=compiled)
    e, sig = result["e"][-1], result["sig"][-1]
    k = int(np.argmin(np.abs(e - np.sin(angle))))  # of the torsion; l0 = 1
    wrong = abs(1.0 - sig[k] * np.cos(angle) / angle)
    assert wrong == pytest.approx(1.0 - np.sin(2 * angle) / (2 * angle), rel=1e-6)
    assert any("is twisted" in line for line in result.report) is bool(wrong > 0.1)
