"""Rigid bodies and gyrostats at orientation nodes: energy, Euler's equations, derivatives, explicit rotor."""

import numpy as np

from spacar.elements.rotations.rotation import body_matrix, global_dual, global_matrix
from spacar.elements.spatial.node_inertia import GyrostatNode, RigidBodyNode, prescribed_rotor_tensor

from .derivatives import check_inertia, close, evaluate, gradient, mass_of
from .spatial_truth import rates, reference, rotation, turn

N = 5


def tensors(rng: np.random.Generator) -> np.ndarray:
    A = rng.normal(size=(N, 3, 3))
    return A @ A.swapaxes(1, 2)


def orientations(rng: np.random.Generator) -> np.ndarray:
    return np.column_stack([turn(rng.normal(size=3), rng.uniform(0.5, 3.0)) for _ in range(N)])


def test_rigid_body_derivatives_and_lagrange() -> None:
    """h is what Lagrange gives for the kinetic energy 2 dlam Lambda^T J Lambda dlam."""
    rng = np.random.default_rng(1)
    family = RigidBodyNode(np.arange(N), tensors(rng))
    x = rng.normal(size=(4, N))
    check_inertia(family, x, rng.normal(size=x.shape), rng.normal(size=x.shape))


def test_energy_and_euler_equations() -> None:
    """dlam.M.dlam = w'.J.w' and Lambda f/2 = J dw' + w' x J w' for motions that keep |lam| = 1."""
    rng = np.random.default_rng(2)
    J, x = tensors(rng), orientations(rng)
    family = RigidBodyNode(np.arange(N), J)
    v = rates(rng, x, "l")
    a = rates(rng, x, "l") - (v * v).sum(0) * x
    f = family.inertia_force(evaluate(family, x)[0], v, a)
    M = mass_of(family, x)
    L = body_matrix(x)
    w, dw = (2.0 * np.einsum("ain,in->an", L, y) for y in (v, a))
    close(np.einsum("in,ijn,jn->n", v, M, v), np.einsum("an,nab,bn->n", w, J, w), "energy")
    Jw = np.einsum("nab,bn->an", J, w)
    moment = np.einsum("nab,bn->an", J, dw) + np.cross(w.T, Jw.T).T
    close(0.5 * np.einsum("ain,in->an", L, f), moment, "Euler")


def test_body_and_global_rates() -> None:
    """R Lambda = Lambda-bar, d(R c)/dt = w x R c, and the force of a moment does the work M.w."""
    rng = np.random.default_rng(3)
    x, c, moment = orientations(rng), rng.normal(size=3), rng.normal(size=(3, N))
    v = rates(rng, x, "l")
    for k in range(N):
        w = 2.0 * global_matrix(x)[:, :, k] @ v[:, k]
        R = rotation(x[:, k])
        np.testing.assert_allclose(R @ body_matrix(x)[:, :, k], global_matrix(x)[:, :, k], atol=1e-14)
        rate = (rotation(x[:, k] + 1e-30j * v[:, k]) @ c).imag / 1e-30
        np.testing.assert_allclose(rate, np.cross(w, R @ c), atol=1e-13)
        force = 2.0 * global_dual(moment)[:, :, k] @ x[:, k]
        np.testing.assert_allclose(force @ v[:, k], moment[:, k] @ w, atol=1e-13)


def test_gyrostat_moment() -> None:
    """Lambda f/2 = w' x h', the rate of the constant body-fixed momentum h'; no work, no mass."""
    rng = np.random.default_rng(4)
    h, x = rng.normal(size=(N, 3)), orientations(rng)
    family = GyrostatNode(np.arange(N), h)
    v = rates(rng, x, "l")
    a = rng.normal(size=x.shape)
    c = evaluate(family, x)[0]
    f = family.inertia_force(c, v, None)
    L = body_matrix(x)
    w = 2.0 * np.einsum("ain,in->an", L, v)
    close(0.5 * np.einsum("ain,in->an", L, f), np.cross(w.T, h).T, "moment")
    close((f * v).sum(0), np.zeros(N), "work")
    check_inertia(family, x, v, a, lagrange=False)
    assert not mass_of(family, x).any()


def test_prescribed_rotor_equals_an_explicit_rotor() -> None:
    """A rotor with tensor J a a^T that spins at the constant relative rate Omega a: momentum J a (a.w +
    Omega).

    Its rate in body components is J a (a.dw) + w x J a (a.w + Omega); the node tensor and the gyrostat give
    the same.
    """
    rng = np.random.default_rng(5)
    omega, J, x = rng.normal(size=(N, 3)), rng.uniform(0.5, 2.0, N), orientations(rng)
    axis = omega / np.linalg.norm(omega, axis=1)[:, None]
    body = RigidBodyNode(np.arange(N), prescribed_rotor_tensor(omega, J))
    gyro = GyrostatNode(np.arange(N), J[:, None] * omega)
    v = rates(rng, x, "l")
    a = rates(rng, x, "l") - (v * v).sum(0) * x
    f = sum(family.inertia_force(evaluate(family, x)[0], v, a) for family in (body, gyro))
    L = body_matrix(x)
    w, dw = (2.0 * np.einsum("ain,in->na", L, y) for y in (v, a))
    along, rate = (axis * w).sum(1), (axis * dw).sum(1)
    spin = np.linalg.norm(omega, axis=1)
    truth = (J * rate)[:, None] * axis + np.cross(w, (J * (along + spin))[:, None] * axis)
    close(0.5 * np.einsum("ain,in->na", L, f), truth, "rotor")
    assert not prescribed_rotor_tensor(np.zeros((1, 3)), np.ones(1)).any()


def test_mass_has_no_stiffness_against_scaling() -> None:
    """M has rank 3: M lam = 0, which is why the normalization row is needed."""
    rng = np.random.default_rng(6)
    x = orientations(rng)
    family = RigidBodyNode(np.arange(N), tensors(rng))
    close((mass_of(family, x) * x).sum(1), np.zeros((4, N)), "M lam")
    assert gradient(lambda z: mass_of(family, z), reference(rng, N, "l")).any()
