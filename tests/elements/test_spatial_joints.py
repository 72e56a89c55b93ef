"""HINGE, PINBODY, RBEAM and the normalization: definitions, derivatives, branches, start geometry."""

from typing import Any

import numpy as np
import pytest

from spacar.elements.family import GeometryError
from spacar.elements.spatial.hinge import SpatialHinge
from spacar.elements.spatial.node_inertia import Normalization
from spacar.elements.spatial.pinbody import SpatialPinbody

from .derivatives import check_gravity, check_inertia, check_strain, close, evaluate, group, mass_of
from .spatial_truth import G, chord_frame, moved, reference, rotation, turn

N = 6


def free(rng: Any, x: Any) -> Any:
    """A state off the unit sphere: the formulas are homogeneous and must hold there too."""
    return x + 0.1 * rng.normal(size=x.shape)


# -- HINGE -------------------------------------------------------------------------------------------------


def hinges(rng: Any, n: int = N) -> tuple[SpatialHinge, Any]:
    axes = rng.normal(size=(n, 3))
    return SpatialHinge(group("HINGE", reference(rng, n, "ll"), geometry=axes)), axes


def hinge_frame(axis: Any) -> Any:
    """Columns: axis, axis x pick(axis), third. Random axes have no equal components."""
    ex = axis / np.linalg.norm(axis)
    ey = np.cross(ex, np.eye(3)[np.argmin(np.abs(ex))])
    ey /= np.linalg.norm(ey)
    return np.column_stack((ex, ey, np.cross(ex, ey)))


def test_hinge_definition_and_derivatives() -> None:
    rng = np.random.default_rng(2)
    family, axes = hinges(rng)
    x = moved(rng, reference(rng, N, "ll"), "ll", angle=1.2)
    truth = []
    for k in range(N):
        frame = hinge_frame(axes[k])
        Rp, Rq = rotation(x[:4, k]) @ frame, rotation(x[4:, k]) @ frame
        sine, cosine = Rp[:, 2] @ Rq[:, 1] - Rp[:, 1] @ Rq[:, 2], Rp[:, 1] @ Rq[:, 1] + Rp[:, 2] @ Rq[:, 2]
        truth.append((np.arctan2(sine, cosine), -Rp[:, 2] @ Rq[:, 0], Rp[:, 1] @ Rq[:, 0]))
    close(evaluate(family, x)[1], np.transpose(truth), "e")
    check_strain(family, free(rng, x), rng.normal(size=x.shape), rng.normal(size=(3, N)))


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_hinge_counts_several_turns(direction: float) -> None:
    """Three turns in steps of 1 rad: the angle is exact to the rounding of a number near 20."""
    rng = np.random.default_rng(3)
    family, axes = hinges(rng, 2)
    base, near = turn((1.0, -2, 0.3), 0.7), np.zeros((3, 2))
    for angle in direction * np.arange(0.0, 20.0, 1.0):
        x = np.zeros((8, 2))
        for k in range(2):
            x[:4, k] = base
            R = rotation(base)
            a, b = turn(R @ axes[k], angle), base
            x[4:, k] = np.concatenate(
                ([a[0] * b[0] - a[1:] @ b[1:]], a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))
            )
        _, e, _ = evaluate(family, x, near)
        np.testing.assert_allclose(e, [[angle] * 2, [0] * 2, [0] * 2], atol=1e-13)
        _, opposite, _ = evaluate(family, np.concatenate((x[:4], -x[4:])), near)  # -lambda is the same rotation
        np.testing.assert_allclose(opposite, e, atol=1e-13)
        near = e


def test_hinge_stiffness_and_missing_axis() -> None:
    x0 = reference(np.random.default_rng(0), 1, "ll")
    family = SpatialHinge(group("HINGE", x0, geometry=[(0, 0, 2.0)], estiff=[(1.0, 2, 3)], edamp=[(4.0, 5, 6)]))
    S, S_d = family.stiffness()
    np.testing.assert_array_equal(S[:, :, 0], np.diag([1.0, 2, 3]))
    np.testing.assert_array_equal(S_d[:, :, 0], np.diag([4.0, 5, 6]))
    assert family.frame_p is not None
    np.testing.assert_array_equal(family.frame_p[0, :6], [0, 0, 1, -1, 0, 0])  # z x y = -x: of x, y the highest
    for axis, words in (((), "axis"), ((0.0, 0, 0), "zero vector")):
        with pytest.raises(GeometryError, match=words):
            SpatialHinge(group("HINGE", x0, geometry=[axis]))


# -- PINBODY, RBEAM ----------------------------------------------------------------------------------------


def measured(frame: Any, r: Any, x: Any) -> Any:
    return (rotation(x[3:7]) @ frame).T @ (x[7:] - x[:3]) - r


def test_pinbody_definition_and_derivatives() -> None:
    """The frames: none, direction vector, 6 and 9 ORPINBOD values, DRPINBOD."""
    rng = np.random.default_rng(4)
    x0 = reference(rng, 5, "xlx")
    g, six, nine = rng.normal(size=3), rng.normal(size=6), rng.normal(size=9)
    family = SpatialPinbody(
        group(
            "PINBODY", x0,
            geometry=[(), g, (), (), g],
            directions=[None, None, tuple(six), tuple(nine), None],
            projections=[None, None, None, None, (0.1, -0.2, 0.3)],
        )
    )  # fmt: skip
    x, d0 = moved(rng, x0, "xlx", angle=2.0), x0[7:] - x0[:3]
    frames = [np.eye(3), chord_frame(d0[:, 1], g), chord_frame(six[:3], six[3:]), nine.reshape(3, 3).T]
    frames.append(chord_frame(d0[:, 4], g))
    r = [frames[k].T @ d0[:, k] for k in range(4)] + [np.array([0.1, -0.2, 0.3])]
    truth = np.transpose([measured(frames[k], r[k], x[:, k]) for k in range(5)])
    close(evaluate(family, x)[1], truth, "e")
    assert family.data is not None
    assert family.frame_p is not None
    np.testing.assert_allclose(family.data, r, atol=1e-15)
    np.testing.assert_allclose(family.frame_p, [f.T.ravel() for f in frames], atol=1e-15)
    check_strain(family, free(rng, x), rng.normal(size=x.shape), rng.normal(size=(3, 5)))


def test_rigid_beam_inertia_is_that_of_a_rod() -> None:
    rng = np.random.default_rng(5)
    x0 = reference(rng, N, "xlx")
    family = SpatialPinbody(group("RBEAM", x0, em=[(2.0, 0.5, 0.2, 0.3, 0.1)] * N))
    x = moved(rng, x0, "xlx")
    check_inertia(family, x, rng.normal(size=x.shape), rng.normal(size=x.shape))
    check_gravity(family, x, G)
    M, l = mass_of(family, x), family.length
    np.testing.assert_allclose(M[0, 0], 2.0 * l / 3)
    np.testing.assert_allclose(M[0, 7], 2.0 * l / 6)
    assert not M[3:7].any()
    ((row, J),) = family.orientation_inertia()
    assert row == 3
    for k in range(N):
        n = (x0[7:, k] - x0[:3, k]) / l[k]
        np.testing.assert_allclose(J[k] @ n, 0.5 * l[k] * n, atol=1e-14)  # Jx'x' about the rod
        np.testing.assert_allclose(np.linalg.eigvalsh(J[k])[:2], l[k] * (0.25 + np.sqrt(0.0125) * np.array([-1, 1])))


@pytest.mark.parametrize(
    ("keyword", "geometry", "directions", "words"),
    [
        ("PINBODY", (1.0, 0, 0), None, "parallel"),
        ("PINBODY", (1.0, 0), None, "3 components"),
        ("PINBODY", (), (1.0, 0, 0, 2, 0, 0), "parallel"),
        ("PINBODY", (), (1.0, 0, 0, 0, 1, 0, 1, 1, 0), "dependent"),
        ("PINBODY", (), (1.0, 0, 0, 0), "6 or 9"),
    ],
)
def test_impossible_pinbody(keyword: str, geometry: Any, directions: Any, words: str) -> None:
    x0 = reference(np.random.default_rng(0), 1, "xlx")
    x0[:3, 0], x0[7:, 0] = 0.0, (1.0, 0, 0)
    with pytest.raises(GeometryError, match=words):
        SpatialPinbody(group(keyword, x0, geometry=[geometry], directions=[directions]))


def test_coincident_nodes() -> None:
    """A PINBODY may join two nodes at one place; an RBEAM is a rod and may not."""
    x0 = np.zeros((10, 1))
    x0[3] = 1.0
    SpatialPinbody(group("PINBODY", x0))
    with pytest.raises(GeometryError, match="length"):
        SpatialPinbody(group("RBEAM", x0))


# -- normalization -----------------------------------------------------------------------------------------


def test_normalization() -> None:
    rng = np.random.default_rng(6)
    x = rng.normal(size=(4, N))
    family = Normalization(np.arange(N))
    np.testing.assert_allclose(evaluate(family, x)[1][0], (x**2).sum(0) - 1)
    check_strain(family, x, rng.normal(size=x.shape), rng.normal(size=(1, N)))
