"""Rigid chains against Pinocchio (`aba`), which shares nothing with the package; skipped where it is not installed."""

import numpy as np
import pytest

from spacar.symbolic import MultibodySystem

pin = pytest.importorskip("pinocchio")

AXES = (3, 2, 1, 3, 2)  # of the joints, one after the other
LENGTH, G = 0.7, 9.81


def body(k: int) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre in the frame of the link, central inertia tensor with products."""
    J = np.array([[0.03, 0.002, -0.001], [0.002, 0.05, 0.003], [-0.001, 0.003, 0.04]]) * (1.0 + 0.2 * k)
    return 1.5 + 0.3 * k, np.array([0.3, 0.05, -0.02 * k]), J


def symbolic_accelerations(strategy: str, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    S = MultibodySystem(gravity=(0, 0, -G))
    frame, point = S.N, S.O
    for k, axis in enumerate(AXES):
        angle, _ = S.coordinate(f"q{k}", speed=f"u{k}")
        frame = S.frame(f"B{k}", frame, axis, angle)
        mass, c, J = body(k)
        centre = S.point(f"C{k}", point, sum((float(c[i]) * frame[i + 1] for i in (1, 2)), float(c[0]) * frame[1]))
        inertia = (J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[1, 2], J[2, 0])
        S.rigid_body(f"link{k}", frame, centre, mass, tuple(float(j) for j in inertia))
        point = S.point(f"P{k}", point, LENGTH * frame[1])
    rates = S.derive(strategy).program().function({})(0.0, [*q, *v])
    return np.array(rates[len(AXES) :])


def aba(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    model = pin.Model()
    model.gravity.linear = np.array([0.0, 0.0, -G])
    joints = {1: pin.JointModelRX, 2: pin.JointModelRY, 3: pin.JointModelRZ}
    parent = 0
    for k, axis in enumerate(AXES):
        offset = np.array([LENGTH if k else 0.0, 0.0, 0.0])
        parent = model.addJoint(parent, joints[axis](), pin.SE3(np.eye(3), offset), f"q{k}")
        model.appendBodyToJoint(parent, pin.Inertia(*body(k)), pin.SE3.Identity())
    return np.array(pin.aba(model, model.createData(), q, v, np.zeros(len(AXES))))


@pytest.mark.parametrize("strategy", ["held", "recursive"])
def test_a_spatial_chain_of_five_links(strategy: str) -> None:
    rng = np.random.default_rng(5)
    q, v = rng.uniform(-2.0, 2.0, (2, len(AXES)))
    np.testing.assert_allclose(symbolic_accelerations(strategy, q, v), aba(q, v), rtol=1e-10)  # of some hundred terms
