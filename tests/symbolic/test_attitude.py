"""Attitude by named sequences, against `sympy.physics.vector` and the energy of a spinning body."""

import pytest
import sympy as sp
from sympy.physics.vector import ReferenceFrame

from spacar.errors import InputError, UsageError
from spacar.symbolic import MultibodySystem, omega, transform
from spacar.symbolic.model_reader import read_model
from spacar.symbolic.transform import DirectionCosines


def turned(axes):
    S = MultibodySystem()
    angles, speeds = zip(*(S.coordinate(f"q{i}", speed=f"s{i}") for i in (1, 2, 3)), strict=True)
    return S, S.frame("B", S.N, axes, angles), angles, speeds


@pytest.mark.parametrize(("axes", "numbers"), [("321", "321"), ("zyx", "321"), ("XYZ", "123"), ("313", "313")])
def test_a_sequence_turns_as_in_sympy(axes, numbers):
    S, B, angles, speeds = turned(axes)
    N, C = ReferenceFrame("N"), ReferenceFrame("C")
    C.orient_body_fixed(N, angles, numbers)
    assert sp.simplify(DirectionCosines().matrix(S.N, B) - N.dcm(C)) == sp.zeros(3, 3)
    rates = {q.diff(): s for q, s in zip(angles, speeds, strict=True)}
    mine = sp.Matrix([transform(omega(S.N, B) & B[i]) for i in (1, 2, 3)])
    theirs = C.ang_vel_in(N).to_matrix(C).xreplace(rates)
    assert sp.simplify(mine - theirs) == sp.zeros(3, 1)


@pytest.mark.parametrize(
    ("axes", "angles", "found"),
    [
        ("322", (0, 0, 0), "a sequence such as"), ("34", (0, 0), "a sequence such as"), ("", (), "a sequence such as"),
        ("321", (0, 0), "needs a list of 3 angles"), ("321", "q", "needs a list of 3 angles"), (4, 0, "1, 2 or 3"),
    ],
)  # fmt: skip
def test_wrong_sequences_are_refused(axes, angles, found):
    S = MultibodySystem()
    with pytest.raises(UsageError, match=found):
        S.frame("B", S.N, axes, angles)


def test_one_letter_is_an_axis():
    S = MultibodySystem()
    q, _ = S.coordinate("q", speed="s")
    B, C = S.frame("B", S.N, "z", "q"), S.frame("C", S.N, 3, q)
    assert B.rotation == C.rotation


MODEL = """
[coordinates]
yaw = { speed = "r" }
pitch = { speed = "q" }
roll = { speed = "p" }
[[frame]]
name = "B"
parent = "N"
axis = "321"
angle = ["yaw", "pitch", "roll"]
[[body]]
name = "ship"
at = "O"
frame = "B"
mass = 1
inertia = [1, 2, 3]
"""


def test_sequences_in_toml(tmp_path):
    path = tmp_path / "ship.toml"
    path.write_text(MODEL)
    eq = read_model(path).system.derive("recursive")
    M, _ = eq.explicit()
    assert M.xreplace(dict.fromkeys(eq.coordinates, sp.S.Zero)) == sp.diag(3, 2, 1)
    path.write_text(MODEL.replace(', "roll"]', "]"))
    with pytest.raises(InputError, match="needs a list of 3 angles"):
        read_model(path)
