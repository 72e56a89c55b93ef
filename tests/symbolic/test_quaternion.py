"""Attitude by a quaternion: free tumbling against closed forms, conservation, and the same top by three angles."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turn
from scipy.special import ellipj

from spacar.errors import InputError, UsageError
from spacar.symbolic import MultibodySystem
from spacar.symbolic.model_reader import read_model

TIGHT = {"rtol": 1e-11, "atol": 1e-12, "integrator": "dop853"}


def tumbling():
    """A body that turns freely about its mass centre."""
    S = MultibodySystem()
    B = S.attitude("B", S.N, "e", "w")
    S.rigid_body("body", B, S.O, "m", ("J1", "J2", "J3"))
    return S


def simulated(J, w, e, t_end, steps=50, **options):
    program = tumbling().derive("recursive").program()
    start = dict(zip(("e0", "e1", "e2", "e3", "w1", "w2", "w3"), (*e, *w), strict=True))
    values = {"m": 1.0, **{f"J{i}": v for i, v in enumerate(J, 1)}}
    return program.simulate(values, start, t_end=t_end, steps=steps, **(TIGHT | options))


def quaternion(run):
    return np.column_stack([run[f"e{i}"] for i in range(4)])


def matrices(run):
    """(steps, 3, 3) by SciPy, whose quaternions have the scalar last."""
    return Turn.from_quat(np.roll(quaternion(run), -1, axis=1)).as_matrix()


def omega(run):
    return np.column_stack([run[f"w{i}"] for i in (1, 2, 3)])


def test_a_symmetric_body_precesses_about_its_angular_momentum():
    """R(t) = exp(t h/J1) R(0) exp(t w3 (J1 − J3)/J1 e3), h the angular momentum in space."""
    J, w = np.array([0.4, 0.4, 0.15]), np.array([0.7, -0.2, 9.0])
    e = np.array([0.3, -0.5, 0.2, 0.8])
    run = simulated(J, w, e, 4.0)
    R0 = Turn.from_quat(np.roll(e, -1)).as_matrix()
    h = R0 @ (J * w)
    for t, R in zip(run.time, matrices(run), strict=True):
        space = Turn.from_rotvec(t * h / J[0]).as_matrix()
        body = Turn.from_rotvec([0, 0, t * w[2] * (J[0] - J[2]) / J[0]]).as_matrix()
        assert pytest.approx(space @ R0 @ body, abs=1e-8) == R


def test_an_unsymmetric_body_follows_the_elliptic_functions_of_euler():
    """J1 < J2 < J3 about the third axis: w = (a cn, −b sn, c dn) of pt, by Euler's equations."""
    J1, J2, J3 = 1.0, 2.0, 3.5
    a, c = 1.1, 2.0
    b = a * np.sqrt(J1 * (J3 - J1) / (J2 * (J3 - J2)))
    p = c * np.sqrt((J3 - J1) * (J3 - J2) / (J1 * J2))
    m = a**2 * J1 * (J2 - J1) / (c**2 * J3 * (J3 - J2))
    run = simulated((J1, J2, J3), (a, 0.0, c), (1, 0, 0, 0), 20.0, steps=200)
    sn, cn, dn, _ = ellipj(p * run.time, m)
    assert omega(run) == pytest.approx(np.column_stack((a * cn, b * sn, c * dn)), abs=1e-8)
    h = np.einsum("tij,tj->ti", matrices(run), np.array([J1, J2, J3]) * omega(run))
    assert h == pytest.approx(np.broadcast_to([J1 * a, 0.0, J3 * c], h.shape), abs=1e-8)
    energy = omega(run) ** 2 @ [J1, J2, J3] / 2
    assert np.ptp(energy) < 1e-9 * energy[0]
    assert np.linalg.norm(quaternion(run), axis=1) == pytest.approx(np.ones(201), abs=4e-16)


def test_drift_of_the_length_moves_nothing():
    """With a quaternion of length 7 the right-hand side gives the same accelerations and 7 times its rates."""
    S = MultibodySystem(gravity=(0, 0, "-g"))
    B = S.attitude("B", S.N, "e", "w")
    P = S.point("P", S.O, S.expression("L") * B[1])
    S.rigid_body("body", B, P, "m", ("J1", "J2", "J3"))
    f = S.derive("recursive").program().function({"g": 9.8, "L": 0.4, "m": 2.0, "J1": 0.1, "J2": 0.2, "J3": 0.25})
    e, w = np.array([0.5, -0.1, 0.7, 0.5]), [0.3, -1.0, 2.0]
    e /= np.linalg.norm(e)
    one, seven = np.array(f(0.0, [*e, *w])), np.array(f(0.0, [*(7 * e), *w]))
    assert seven == pytest.approx(np.concatenate((7 * one[:4], one[4:])), rel=1e-13)


def test_a_start_is_scaled_and_a_zero_one_refused():
    run = simulated((1, 2, 3), (0.1, 0, 0), (3, 0, 4, 0), 0.1, steps=1)
    assert quaternion(run)[0] == pytest.approx([0.6, 0, 0.8, 0], abs=1e-16)
    assert "divided by their length 5" in run.notes[0]
    with pytest.raises(UsageError, match="the quaternion e0, e1, e2, e3 is zero"):
        simulated((1, 2, 3), (0.1, 0, 0), (0, 0, 0, 0), 0.1)


def test_a_quaternion_on_a_moving_parent():
    S = MultibodySystem(gravity=(0, "-g", 0))
    q, _ = S.coordinate("q", speed="s")
    A = S.frame("A", S.N, 3, q)
    arm = S.beam("arm", A, S.O, "L", "rho", EI="EI", field=2)
    B = S.attitude("B", arm.tip, "e", "w")
    S.rigid_body("body", B, S.point("P", arm.tip, S.expression("a") * B[2]), "m", ("J1", "J2", "J3"))
    for strategy in ("held", "recursive"):
        assert S.derive(strategy).check().error < 1e-25, strategy


TEXT = """
[parameters]
m = 1.0
J = 0.5
[[attitude]]
name = "B"
parent = "N"
quaternion = "e"
speed = "w"
start = [1, 0, 0, 0]
speed_start = [0, 0, 2.0]
[[body]]
name = "body"
frame = "B"
at = "O"
mass = "m"
inertia = ["J", "J", "2*J"]
"""


def test_model_file(tmp_path):
    path = tmp_path / "top.toml"
    path.write_text(TEXT)
    model = read_model(path)
    run = (
        model.system.derive("recursive")
        .program(model.outputs)
        .simulate(model.values, model.start, t_end=np.pi / 2, steps=4, **TIGHT)
    )
    assert quaternion(run)[-1] == pytest.approx([0, 0, 0, 1], abs=1e-9)  # half a turn about the third axis
    for old, new, text in (
        ("start = [1, 0, 0, 0]", "start = [1, 0, 0]", "key 'start' must be a list of 4 numbers"),
        ('"N"', '"M"', "refers to"),
        ('quaternion = "e"', 'quaternion = "w"', "the name 'w1' is already used"),
    ):
        path.write_text(TEXT.replace(old, new, 1))
        with pytest.raises(InputError, match=text):
            read_model(path)
