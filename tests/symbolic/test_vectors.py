"""The held algebra: tables 1 to 11 and 14 of the paper, and its rules against components of SymPy's frames."""

import random

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from sympy.physics import vector as spv
from sympy.physics.vector import dynamicsymbols

from spacar.errors import UsageError
from spacar.symbolic import Dyad, ReferenceFrame, Vector, dvdt, omega, partial_velocity, set_omega
from spacar.symbolic.beam_shapes import X, field_function
from spacar.symbolic.collect import ZTable, gather_vectors, read_scalar
from spacar.symbolic.printing import latex, text, unicode
from spacar.symbolic.transform import DirectionCosines, from_sympy, to_sympy, transform
from spacar.symbolic.unit_vectors import TIME, UnevaluatedDot, Unit


@pytest.fixture
def nb():
    return ReferenceFrame("N", "n"), ReferenceFrame("B", "b")


def test_tables_1_to_3_unit_vectors_dyads_and_products(nb):
    N, B = nb
    assert text(B[1]) == "b1"
    assert text(B[1] | N[1]) == "b1 n1"
    assert text((B[1] | N[1]) ^ B[1]) == "b1 (n1 >< b1)"
    assert ((B[1] | N[1]) ^ B[1]) == (B[1] | (N[1] ^ B[1]))
    assert text(B[1] ^ N[1]) == "-n1 >< b1"  # canonical order, the sign in front
    # (b1 × n1)·b2 = (b2 × b1)·n1 = −b3·n1; with n1 = b3: (b1 × b3)·b2 = −b2·b2 = −1. The reference text has n1·b3.
    assert text((B[1] ^ N[1]) & B[2]) == "-n1.b3"


def test_tables_4_to_6_angular_velocity_position_and_velocity(nb):
    N, B = nb
    s = sp.symbols("s1:4")
    assert text(set_omega(N, B, s[0] * N[1] + s[1] * N[2] + s[2] * N[3])) == "s1 n1 + s2 n2 + s3 n3"
    L, (x, y, z) = sp.symbols("L1:4"), sp.symbols("x1 y1 z1")
    position = L[0] * N[1] + L[1] * N[2] + L[2] * N[3] + x * B[1] + y * B[2] + z * B[3]
    assert text(position) == "L1 n1 + L2 n2 + L3 n3 + x1 b1 + y1 b2 + z1 b3"
    velocity = dvdt(N, position)
    nine = [f"{r}*{w}" for w in s for r in (x, y, z)]
    assert sorted(text(c) for c in velocity.terms.values()) == sorted(
        text(sp.sympify(c, {"s1": s[0], "s2": s[1], "s3": s[2]})) for c in nine
    )
    expected = sum((r * w * (N[i] ^ B[j]) for i, w in enumerate(s, 1) for j, r in enumerate((x, y, z), 1)), Vector())
    assert velocity == expected


def _arm_kinematics():
    """Tables 7 to 9: q2' and q3' are functions of time, s2' and s3' their rates."""
    N, B1 = ReferenceFrame("N", "n"), ReferenceFrame("B1", "b1")
    s1, s4, sp2, q3 = (sp.Function(name)(TIME) for name in ("s1", "s4", "sp2", "qp3"))
    B2 = ReferenceFrame("B2", "b2")
    B1.directions[3] = B2.directions[3] = N.directions[3]
    set_omega(N, B1, s1 * B1[3])
    set_omega(N, B2, (s1 + sp2 + s4) * B2[3])
    return N, B1, B2, s1, s4, sp2, q3


def test_table_7_angular_velocities_and_accelerations():
    N, B1, B2, s1, *_ = _arm_kinematics()
    assert text(omega(N, B2)) == "(s1 + s4 + sp2) b23"
    assert text(partial_velocity(omega(N, B2), s1)) == "b23"
    assert text(dvdt(N, omega(N, B1))) == "s1_dot b13"
    assert text(dvdt(N, omega(N, B2))) == "(s1_dot + s4_dot + sp2_dot) b23"


def test_tables_8_and_9_velocity_of_the_mass_point_of_beam_2():
    N, _, B2, s1, s4, sp2, _ = _arm_kinematics()
    u = field_function("u")
    velocity = gather_vectors(dvdt(N, X * B2[1] + u * B2[2]))
    w = s1 + s4 + sp2
    assert sp.expand(velocity.coefficient(B2[1]) + u * w) == 0
    assert sp.expand(velocity.coefficient(B2[2]) - X * w - u.diff(TIME)) == 0
    assert set(map(str, velocity.terms)) == {"b21", "b22"}


def test_tables_10_and_11_recurrence():
    N, B1, _, s1, _, _, q3 = _arm_kinematics()
    L1, sp3, s1d, sp3d = sp.Symbol("L1"), sp.Function("sp3")(TIME), sp.Symbol("s1d"), sp.Symbol("sp3d")
    rates = {q3.diff(TIME): sp3, s1.diff(TIME): s1d, sp3.diff(TIME): sp3d}
    velocity = dvdt(N, L1 * B1[1] + q3 * B1[2]).xreplace(rates)
    acceleration = gather_vectors(dvdt(N, velocity).xreplace(rates))
    table = ZTable(forbidden=[s1d, sp3d])
    short = acceleration.map(lambda c: read_scalar(c, table, [s1d, sp3d]))
    z1, z2 = table.definitions.values()
    assert sp.expand(z1 + s1 * (2 * sp3 + L1 * s1)) == 0
    assert sp.expand(z2 + q3 * s1**2) == 0
    assert text(short) == "(Z1 - s1d*qp3) b11 + (Z2 + L1*s1d + sp3d) b12"


def test_table_14_recurrence_on_a_held_cross():
    B1, B2 = ReferenceFrame("B1", "b1"), ReferenceFrame("B2", "b2")
    m, L, v, a = sp.symbols("m L v a")
    J = (m * L * a + m * v**2) * (B2[1] ^ B1[1])
    table = ZTable(forbidden=[a])
    short = J.map(lambda c: read_scalar(c, table, [a]))
    assert text(short) == "(Z1*a + Z2) b11 >< b21"  # b21 × b11 in canonical order: the signs are in Z1 and Z2
    assert sp.expand(table.expand(short).coefficient(B2[1] ^ B1[1]) - m * L * a - m * v**2) == 0
    assert list(table.definitions.values()) == [-L * m, -m * v**2]


# -- rules against components -----------------------------------------------------------------------------------


def _four_frames():
    q = dynamicsymbols("q1:4")
    N = ReferenceFrame("N")
    A = N.turned("A", 1, q[0])
    B = A.turned("B", 2, q[1])
    C = N.turned("C", 3, q[2])
    return [N, A, B, C], q


def _random_vector(chance, frames):
    total = Vector()
    for _ in range(2):
        u, v = (chance.choice(frames)[chance.randint(1, 3)] for _ in range(2))
        total += chance.randint(-5, 5) * u + chance.randint(-3, 3) * (u ^ v)
    return total


@settings(max_examples=8, deadline=None)
@given(st.integers(0, 10**6))
def test_products_equal_components(seed):
    """a·b, a×b, (a×b)·c, (a×b)·(c×d) of random combinations over four frames; 30 digits, so 1e-25 is rounding."""
    chance = random.Random(seed)
    frames, q = _four_frames()
    a, b, c, d = (_random_vector(chance, frames) for _ in range(4))
    angles = {s: sp.Float(chance.uniform(-3, 3), 40) for s in q}
    N, cosines = frames[0], DirectionCosines()
    turn = {f: cosines.matrix(N, f).xreplace(angles).evalf(35) for f in frames}

    def key(k):
        return turn[k.frame][:, k.index - 1] if isinstance(k, Unit) else key(k.a).cross(key(k.b))

    def components(v):
        return sum((number(c) * key(k) for k, c in v.terms.items()), sp.zeros(3, 1))

    def atom(held):
        first, second, *third = map(key, held.units)
        return first.cross(second).dot(third[0]) if third else first.dot(second)

    def number(scalar):
        return sp.sympify(scalar).xreplace({h: atom(h) for h in sp.sympify(scalar).atoms(UnevaluatedDot)}).evalf(30)

    A, B, C, D = map(components, (a, b, c, d))
    assert abs(number(a & b) - A.dot(B)) < 1e-25
    assert max(abs(e) for e in components(a ^ b) - A.cross(B)) < 1e-24
    assert abs(number((a ^ b) & c) - A.cross(B).dot(C)) < 1e-23
    assert abs(number((a ^ b) & (c ^ d)) - A.cross(B).dot(C.cross(D))) < 1e-21
    assert max(abs(e) for e in components((a ^ b) ^ c) - A.cross(B).cross(C)) < 1e-22
    dyad = a | b
    assert max(abs(e) for e in components(dyad & c) - A * B.dot(C)) < 1e-23
    assert max(abs(e) for e in components(c & dyad) - B * A.dot(C)) < 1e-23
    assert abs(number(c & (dyad ^ d) & a) - C.dot(A) * B.cross(D).dot(A)) < 1e-20
    assert abs(number(c & (d ^ dyad) & a) - C.dot(D.cross(A)) * B.dot(A)) < 1e-20
    assert abs(number(c & (dyad & (c | d)) & a) - C.dot(A) * B.dot(C) * D.dot(A)) < 1e-19


def test_derivatives_of_held_scalars_and_dyads_equal_components():
    """d(a·b)/dt and d[a b c]/dt by the held rule and by differentiating the cosines; the same from every observer."""
    frames, q = _four_frames()
    N, A, B, C = frames
    values = {s.diff(TIME): sp.Float(r, 30) for s, r in zip(q, (0.3, -1.1, 0.7), strict=True)}
    values |= {s: sp.Float(r, 30) for s, r in zip(q, (0.4, 1.9, -0.8), strict=True)}
    for scalar in (A[2] & C[1], B[3] & C[2], (A[2] ^ B[1]) & C[1], (A[2] ^ C[1]) & B[3]):
        held = transform(scalar.diff(TIME)).xreplace(values)
        direct = transform(scalar).diff(TIME).xreplace(values)
        assert abs((held - direct).evalf(25)) < 1e-24
    for observer in frames:
        moved = dvdt(observer, A[2]) & C[1]
        total = moved + (A[2] & dvdt(observer, C[1]))
        assert abs(transform(total - (A[2] & C[1]).diff(TIME)).xreplace(values).evalf(25)) < 1e-24
    dyad = (A[1] | C[2]) * q[0]
    v = B[2]
    rate = (dvdt(N, dyad) & v) + (dyad & dvdt(N, v))
    difference = rate - dvdt(N, dyad & v)
    assert (
        max(abs(transform(c).xreplace(values).evalf(25)) for c in DirectionCosines().components(difference, N)) < 1e-23
    )


def test_angular_velocities_add_along_a_path_and_change_sign():
    frames, _q = _four_frames()
    N, A, B, C = frames
    assert omega(C, B) == omega(N, B) - omega(N, C)
    assert omega(B, N) == -omega(N, B)
    assert omega(A, A) == Vector()
    with pytest.raises(UsageError, match="no angular velocity is known between frames N and Q"):
        omega(N, ReferenceFrame("Q"))
    with pytest.raises(UsageError, match="no angular velocity is known between frames N and Q"):
        dvdt(N, ReferenceFrame("Q")[1])


def test_conversion_to_and_from_sympy():
    frames, q = _four_frames()
    made = {frames[0]: spv.ReferenceFrame(frames[0].name)}
    for frame in frames[1:]:
        parent = made[frame.rotation.parent]
        axis = (parent.x, parent.y, parent.z)[frame.rotation.axis - 1]
        made[frame] = parent.orientnew(frame.name, "Axis", (frame.rotation.angle, axis))
    N, A, B, C = frames
    v = 2 * A[1] + q[0] * (B[2] ^ C[1])
    there = to_sympy(v, made)
    assert sp.simplify((there & made[N].z) - DirectionCosines().components(v, N)[2]) == 0
    back = from_sympy(there, {r: f for f, r in made.items()})
    assert sp.simplify((DirectionCosines().components(back - v, N)).norm()) == 0
    assert isinstance(there, spv.Vector)


def test_wrong_sums_and_products_are_type_errors(nb):
    N, B = nb
    with pytest.raises(TypeError, match="cannot add"):
        N[1] + 1
    with pytest.raises(TypeError, match="dot"):
        N[1] * B[1]
    with pytest.raises(TypeError):
        N[1] & 3
    with pytest.raises(TypeError):
        Dyad() ^ Dyad()
    with pytest.raises(ValueError, match="1, 2 and 3"):
        N[4]


def test_three_ways_of_printing():
    N, B1 = ReferenceFrame("N", "n"), ReferenceFrame("B1", "b1")
    q = dynamicsymbols("q1")
    v = q.diff() * N[2] - (N[1] ^ B1[2])
    assert text(v) == "q1_dot n2 - n1 >< b12"
    assert unicode(v) == "q\u03071 n\u0302₂ - n\u0302₁ × b\u0302₁₂"
    assert latex(v) == r"\dot{q_{1}} \hat{n}_{2} - \hat{n}_{1} \times \hat{b}_{12}"
    assert latex((N[1] & B1[1]) ** 2) == r"(\hat{n}_{1} \cdot \hat{b}_{11})^{2}"
    assert unicode(N[1] & B1[1]) == "n\u0302₁·b\u0302₁₁"


def test_a_memory_read_is_not_differentiated(nb):
    N, _ = nb
    table = ZTable()
    z = table.read(dynamicsymbols("q") ** 2 + 1)
    with pytest.raises(TypeError, match="memory read"):
        dvdt(N, z * N[1])
    assert dvdt(N, table.expand(z) * N[1])
