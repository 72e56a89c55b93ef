"""What the statements of the dynamics block become: loads, inertia, preloads, start values, settings."""

import numpy as np
import pytest

import spacar
from spacar import Deck
from spacar.dynamics import Dynamics
from spacar.mechanism import Mechanism, build

G = 9.81
BAR = (("PLRBEAM", 1, 1, 2, 3), ("X", 3, 2.0, 0.0))
BODY = (("RBEAM", 1, 1, 2, 3, 0.0, 1.0, 0.0), ("X", 3, 2.0, 0.0, 0.0))
SLIDER = (("PLTRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("FIX", 2, 2))


def mechanism(rows: tuple, dynamics: tuple = ()) -> Mechanism:
    return build(Deck.build(rows, dynamics))


def initial(rows: tuple, dynamics: tuple = (), mode: int = 1) -> spacar.Result:
    return spacar.run(mode, Deck.build(rows, dynamics, mode=mode))


# -- geometry ------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("fixed", "projections", "node_2", "node_3"),
    [
        ((("FIX", 1), ("FIX", 2)), (3.0, 1.0), 0.0, (3.0, 1.0)),  # although X says (2, 0)
        # The bar must point 2 rad away from X; one Newton iteration from there does not get home.
        ((("FIX", 1), ("FIX", 3, 2)), (2 * np.cos(2.0), 2 * np.sin(2.0)), -2.0, (2.0, 0.0)),
    ],
    ids=["near", "far"],
)
def test_drpinbod_gives_the_undeformed_projections(fixed, projections, node_2, node_3) -> None:
    rows = (("PLPINBOD", 1, 1, 2, 3), ("X", 3, 2.0, 0.0), *fixed, ("DRPINBOD", 1, *projections))
    r = initial(rows)
    assert r.node(2, 1)[0] == pytest.approx(node_2, abs=1e-13)
    assert [r.node(3, 1)[0], r.node(3, 2)[0]] == pytest.approx(node_3, abs=1e-14 if node_2 == 0 else 1e-13)


def test_orpinbod_turns_the_measuring_directions() -> None:
    """With directions at 45 degrees a release of mode 1 lets node 3 move along (1, 1)."""
    rows = (*BAR, ("ORPINBOD", 1, 1.0, 1.0), ("FIX", 1), ("FIX", 2), ("INPUTE", 1, 1))
    r = initial(rows, (("INPUTE", 1, 1, 0.5),))
    moved = np.array([r.node(3, 1)[0] - 2.0, r.node(3, 2)[0]])
    np.testing.assert_allclose(moved, 0.5 / np.sqrt(2), rtol=1e-14)


def test_orpinbod_with_nine_numbers_is_taken_as_given() -> None:
    """Skew directions d_k, not normalized: e_k = d_k . (x_q - x_p) - start, so M (x - x0) = (0.3, 0, 0)."""
    directions = np.array([[2.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 3.0]])
    rows = (*BODY, ("ORPINBOD", 1, *directions.ravel()), ("FIX", 1), ("FIX", 2), ("INPUTE", 1, 1))
    r = initial(rows, (("INPUTE", 1, 1, 0.3),))
    x = np.array([r.node(3, k)[0] for k in (1, 2, 3)]) - [2.0, 0.0, 0.0]
    np.testing.assert_allclose(directions @ x, [0.3, 0.0, 0.0], atol=1e-14)


# -- forces --------------------------------------------------------------------------------------------------------
def test_three_numbers_on_a_spatial_orientation_node_are_a_moment() -> None:
    """M = (1, 2, 3) on a body with J = diag(2, 3, 4) at rest: angular acceleration M / J."""
    rows = (("RBEAM", 1, 1, 2, 3, 0.0, 1.0, 0.0), ("X", 3, 1.0), ("FIX", 1), ("DYNX", 2))
    dynamics = (("XM", 2, 2.0, 0.0, 0.0, 3.0, 0.0, 4.0), ("XF", 2, 1.0, 2.0, 3.0))
    r = initial(rows, dynamics)
    lam_dd = np.array([r.node(2, k, "xdd")[0] for k in (2, 3, 4)])
    np.testing.assert_allclose(2 * lam_dd, [0.5, 2 / 3, 0.75], rtol=1e-14)
    four = (("XM", 2, 2.0, 0.0, 0.0, 3.0, 0.0, 4.0), ("XF", 2, 0.0, 2.0, 4.0, 6.0))
    np.testing.assert_allclose(initial(rows, four)["xdd"], r["xdd"], rtol=1e-14)
    np.testing.assert_allclose(r["fx"][0][r.lnp[1] - 1], [0.0, 2.0, 4.0, 6.0], rtol=1e-14)


def test_gravity_on_lumped_and_distributed_mass() -> None:
    """Cantilever bar, 3 kg at the tip and 2 kg/m: support force and moment from statics."""
    rows = (*BAR, ("FIX", 1), ("FIX", 2))
    r = initial(rows, (("XM", 3, 3.0), ("EM", 1, 2.0), ("GRAVITY", 0.0, -G)))
    weight = (3.0 + 2.0 * 2.0) * G
    support = r["fxtot"][0] - r["fx"][0] - r["fxgrav"][0]
    assert r["fxgrav"][0][r.lnp[:3, 1][[0, 2]] - 1].sum() == pytest.approx(-weight, rel=1e-14)
    assert support[r.lnp[0, 1] - 1] == pytest.approx(weight, rel=1e-14)
    assert support[r.lnp[1, 0] - 1] == pytest.approx((3.0 * 2.0 + 2.0 * 2.0 * 1.0) * G, rel=1e-14)


def test_forces_on_one_node_of_a_spatial_body_fall_with_g() -> None:
    """A free body falls with g wherever its mass is."""
    rows = (*BODY, ("DYNX", 1), ("DYNX", 2))
    dynamics = (("EM", 1, 1.5, 0.1, 0.2, 0.3), ("XM", 1, 4.0), ("XM", 2, 0.2, 0.0, 0.0, 0.3, 0.05, 0.4), ("XM", 3, 0.7),
                ("GRAVITY", 1.0, 2.0, 3.0))  # fmt: skip
    r = initial(rows, dynamics)
    for node in (1, 3):
        np.testing.assert_allclose([r.node(node, k, "xdd")[0] for k in (1, 2, 3)], [1.0, 2.0, 3.0], rtol=1e-13)


@pytest.mark.parametrize(
    ("freedom", "dynamics", "acceleration", "stress"),
    [
        # ESIG 7 N in a released truss on a mass of 2 kg: the mass accelerates with -3.5 m/s^2.
        ("DYNE", (("XM", 2, 2.0), ("ESIG", 1, 7.0)), -3.5, 7.0),
        (None, (("XF", 2, 5.0, 0.0), ("ESIG", 1, 7.0)), 0.0, 5.0),  # no effect on a fixed deformation
        ("DYNE", (("XM", 2, 2.0), ("MEE", 1, 1, 3.0), ("XF", 2, 10.0)), 2.0, 0.0),  # (2 + 3) a = F
        # force on the mass: -sigma = m a + M_e a, so sigma = -(2 + 3) 4
        ("INPUTE", (("XM", 2, 2.0), ("MEE", 1, 1, 3.0), ("INPUTE", 1, 1, 0.0, 0.0, 4.0)), 4.0, -20.0),
        ("DYNE", (("XM", 2, 2.0), ("ESTIFF", 1, 8.0), ("STARTDE", 1, 1, 0.5, 0.0)), -2.0, 4.0),
    ],
    ids=["preload of a spring", "preload of a fixed deformation", "inertia of a deformation",
         "inertia of a prescribed deformation", "spring"],
)  # fmt: skip
def test_a_mass_on_a_truss(freedom, dynamics, acceleration, stress) -> None:
    """Without TIMESTEP there is only the initial state."""
    r = initial((*SLIDER, (freedom, 1)) if freedom else SLIDER, dynamics)
    assert r.t.tolist() == [0.0]
    assert r.node(2, 1, "xdd")[0] == pytest.approx(acceleration, rel=1e-14)
    assert r.element(1, 1, "sig")[0] == pytest.approx(stress, rel=1e-14)


# -- inertia -------------------------------------------------------------------------------------------------------
def test_mee_couples_two_deformations_symmetrically() -> None:
    """Two parallel sliders: [2 1; 1 3] a = f, dynamic coordinates and dynamic deformations alike."""
    rows = (
        ("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 3, 4), ("X", 2, 1.0), ("X", 3, 0.0, 1.0), ("X", 4, 1.0, 1.0),
        ("FIX", 1), ("FIX", 3), ("FIX", 2, 2), ("FIX", 4, 2),
    )  # fmt: skip
    dynamics = (("XM", 2, 2.0), ("XM", 4, 3.0), ("MEE", 1, 1, 2, 1, 1.0), ("XF", 2, 1.0), ("XF", 4, 5.0))
    expected = np.linalg.solve([[2.0, 1.0], [1.0, 3.0]], [1.0, 5.0])
    for freedoms in (
        (("DYNE", 1), ("DYNE", 2)),
        (("DYNX", 2, 1), ("DYNX", 4, 1), ("RLSE", 1), ("RLSE", 2)),
        (("DYNX", 2, 1), ("DYNE", 2), ("RLSE", 1)),
    ):
        r = initial(rows + freedoms, dynamics)
        np.testing.assert_allclose([r.node(2, 1, "xdd")[0], r.node(4, 1, "xdd")[0]], expected, rtol=1e-13)


def test_tensors_of_one_node_add_up() -> None:
    """XM plus the distributed rotary inertia of a rigid rod: l J per length on the orientation node."""
    m = mechanism(
        (*BODY, ("FIX", 1), ("DYNX", 2)),
        (("XM", 2, 1.0, 0.1, 0.2, 2.0, 0.3, 3.0), ("EM", 1, 0.0, 0.5, 0.25, 0.125, 0.0625)),
    )
    d = Dynamics(m)
    y = d.start()
    rate = np.array([0.1, -0.3, 0.2])
    y[3:] = rate
    d.place(0.0, y)
    d.sweep.mass()
    lam_d = d.xd[m.numbering.lnp[1] - 1]
    kinetic = 0.5 * lam_d @ d.sweep.mass_times(d.xd)[m.numbering.lnp[1] - 1]
    omega = 2 * rate
    J = np.array([[1.0, 0.1, 0.2], [0.1, 2.0, 0.3], [0.2, 0.3, 3.0]]) + 2.0 * np.array(
        [[0.5, 0, 0], [0, 0.25, 0.0625], [0, 0.0625, 0.125]]
    )
    assert kinetic == pytest.approx(0.5 * omega @ J @ omega, rel=1e-14)


# -- motion and settings -------------------------------------------------------------------------------------------
def test_start_values_and_rates() -> None:
    rows = (("PLTRUSS", 1, 1, 2), ("X", 2, 1.0), ("FIX", 1), ("DYNX", 2, 2), ("DYNE", 1))
    m = mechanism(rows, (("XM", 2, 1.0), ("STARTDX", 2, 2, 0.25, 3.0), ("STARTDE", 1, 1, 0.5, -1.0)))
    y = Dynamics(m).start()
    assert y.tolist() == [0.25, 0.5, 3.0, -1.0]
    m = mechanism((("PLTRUSS", 1, 1, 2), ("X", 2, 1.0, 0.5), ("FIX", 1), ("DYNX", 2, 2)), (("XM", 2, 1.0),))
    assert m.start.x_value.tolist() == [0.5]  # of a position: its place


def test_polynomial_drive() -> None:
    r = spacar.run(1, Deck.build((*SLIDER, ("INPUTE", 1)), (("INPUTE", 1, 1, 0.1, 2.0, -6.0), ("TIMESTEP", 1.0, 10))))
    t = np.linspace(0, 1, 11)
    np.testing.assert_allclose(r.element(1, 1), 0.1 + 2 * t - 3 * t**2, atol=1e-15)
    np.testing.assert_allclose(r.element(1, 1, "ed"), 2 - 6 * t, atol=1e-14)
    np.testing.assert_allclose(r.element(1, 1, "edd"), -6.0, atol=1e-13)


def test_settings_have_the_defaults_of_the_manual() -> None:
    s = mechanism(BAR).settings
    found = (s.atol, s.rtol, s.integrator, s.max_iterations, s.load_steps, s.tolerance)
    assert found == (1e-5, 1e-4, -1, 10, 4, 5e-7)  # -1 is ours: the method chooses itself
    s = mechanism(BAR, (("ERROR", 1e-8), ("INTEGRAT", 255), ("ITERSTEP", 20, 3))).settings
    assert (s.atol, s.rtol, s.integrator, s.max_iterations, s.load_steps) == (1e-8, 1e-4, 225, 20, 3)


# -- gyrostats -----------------------------------------------------------------------------------------------------
def carrier(dynamics: tuple, rate: np.ndarray, rotor: bool = False) -> np.ndarray:
    """Angular acceleration of a body on a fixed point with body rates `rate`, with XGYRO or an explicit rotor."""
    rows: tuple = (("RBEAM", 1, 1, 2, 3, 0.0, 1.0, 0.0), ("X", 3, 1.0), ("FIX", 1), ("DYNX", 2))
    if rotor:
        rows += (("HINGE", 2, 2, 4, *AXIS), ("DYNE", 2, 1))
    starts = tuple(("STARTDX", 2, k, 0.0, float(rate[k - 2] / 2)) for k in (2, 3, 4))
    r = initial(rows, dynamics + starts)
    return 2 * np.array([r.node(2, k, "xdd")[0] for k in (2, 3, 4)])


AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
J = np.array([[5.0, 0.2, -0.1], [0.2, 6.0, 0.3], [-0.1, 0.3, 7.0]])  # carrier, with the rotor's transverse inertia
AXIAL = 0.8
SIX = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
RATE = np.array([0.4, -0.7, 0.3])


def tensor(J: np.ndarray) -> tuple[float, ...]:
    return tuple(float(J[i]) for i in SIX)


@pytest.mark.parametrize("prescribed", [0, 1])
def test_gyrostat(prescribed: int) -> None:
    """J dw/dt + w x (J w + h) = 0 with h = J_axial Omega_absolute; the axial rate of a free rotor is constant.

    A prescribed rotor turns with a constant relative rate: its axial inertia moves with the carrier.
    """
    spin, axial = 30.0, AXIAL * np.outer(AXIS, AXIS)
    found = carrier((("XM", 2, *tensor(J)), ("XGYRO", 2, *(spin * AXIS), AXIAL, prescribed)), RATE)
    whole = J + prescribed * axial
    expected = np.linalg.solve(whole, -np.cross(RATE, whole @ RATE + AXIAL * spin * AXIS))
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    if not prescribed:  # The explicit rotor with axial inertia only turns with the same absolute axial rate.
        start = ("STARTDE", 2, 1, 0.0, float(spin - AXIS @ RATE))
        explicit = carrier((("XM", 2, *tensor(J)), ("XM", 4, *tensor(axial)), start), RATE, rotor=True)
        np.testing.assert_allclose(explicit, expected, rtol=1e-12)


# Numbering and classification against tables that were written by hand from files.md section 3.
PLANAR = (
    ("PLBEAM", 3, 1, 2, 5, 6), ("PLTOR", 7, 6, 9), ("PLTRUSS", 1, 5, 4), ("X", 5, 1.0, 0.0), ("X", 4, 1.0, 1.0),
    ("DYNX", 4, 2), ("INPUTX", 4, 1), ("FIX", 2), ("FIX", 1), ("RLSE", 3, 1), ("INPUTE", 7, 1), ("DYNE", 3, 3),
)  # fmt: skip
SPATIAL = (
    ("BEAM", 5, 1, 3, 6, 8, 0.0, 1.0, 0.0), ("HINGE", 2, 4, 3, 0.0, 0.0, 1.0), ("X", 6, 1.0, 0.0, 0.0), ("FIX", 1),
    ("FIX", 4), ("INPUTE", 2, 1), ("DYNE", 5, 3, 5), ("RLSE", 5, 2),
)  # fmt: skip
ROLLING = (
    ("RBEAM", 1, 1, 2, 3, 1.0, 0.0, 0.0), ("HINGE", 2, 2, 4, 0.0, 1.0, 0.0), ("WHEEL", 3, 3, 4, 5, 0.0, 1.0, 0.0),
    ("X", 1, 0.0, 0.0, 0.3), ("X", 3, 0.0, 0.5, 0.3), ("X", 5, 0.0, 0.5, 0.0), ("DYNX", 1, 1), ("KINX", 1, 2),
    ("KINE", 2, 1),
)  # fmt: skip


def nonzero(table: np.ndarray) -> dict[int, list[int]]:
    """Rows of a 1-based table that are not empty, by number."""
    return {i: row[row != 0].tolist() for i, row in enumerate(table, 1) if row.any()}


def test_planar_tables() -> None:
    n = mechanism(PLANAR).numbering
    # fixed 1x 1y 2phi | calculable 5x 5y 6phi 9phi | input 4x | dynamic 4y
    assert nonzero(n.lnp) == {1: [1, 2], 2: [3], 4: [8, 9], 5: [4, 5], 6: [6], 9: [7]}
    assert n.lnp.shape == (9, 4)
    # fixed 1:e1 3:e2 | input 7:e1 | dynamic 3:e3 | calculable 3:e1
    assert nonzero(n.le) == {1: [1], 3: [5, 2, 4], 7: [3]}
    assert n.le.shape == (7, 6)
    assert nonzero(n.ln) == {1: [5, 4], 3: [1, 2, 5, 6], 7: [6, 9]}
    assert n.ln.shape == (7, 4)
    assert n.it.tolist() == [7, 0, 5, 0, 0, 0, 6]
    assert n.nxp.tolist() == [3, 4, 1, 1, 0]
    assert n.nep.tolist() == [2, 1, 1, 1, 0]
    assert (n.nx, n.ne, n.ndof, n.nddof, n.nkdof, n.nkddof) == (9, 5, 4, 2, 4, 2)
    assert n.q_names == ["node 4 x", "node 4 y", "element 7 (PLTOR) e1 relative rotation", n.e_name(3)]
    assert n.dynamic.tolist() == [1, 3]
    assert n.rheonomic.tolist() == [0, 2]


def test_spatial_tables_put_the_normalizations_last_among_the_fixed() -> None:
    n = mechanism(SPATIAL).numbering
    # fixed 1xyz, 4: lambda1..3 | calculable 3: 4, 4: lambda0, 6xyz, 8: 4
    assert nonzero(n.lnp) == {
        1: [1, 2, 3], 3: [7, 8, 9, 10], 4: [11, 4, 5, 6], 6: [12, 13, 14], 8: [15, 16, 17, 18],
    }  # fmt: skip
    # fixed 2:e2 e3, 5:e1 e4 e6, normalizations of 3, 4, 8 | input 2:e1 | dynamic 5:e3 e5 | calculable 5:e2
    assert nonzero(n.le) == {2: [9, 1, 2], 5: [3, 12, 10, 4, 11, 5]}
    assert n.normalization.tolist() == [[3, 5], [4, 6], [8, 7]]
    assert n.nxp.tolist() == [6, 12, 0, 0, 0]
    assert n.nep.tolist() == [8, 1, 1, 2, 0]
    assert n.e_name(6) == "normalization of node 4"
    assert nonzero(n.ln) == {2: [4, 3], 5: [1, 3, 6, 8]}
    assert n.it.tolist() == [0, 3, 0, 0, 1]


def test_kinematic_classes_come_between_dynamic_and_calculable_deformations() -> None:
    n = mechanism(ROLLING).numbering
    assert n.nxp.tolist() == [0, 3 + 3 + 3 + 4 + 4 - 2, 0, 1, 1]
    assert n.x_index(1, 1) == n.nx - 2
    assert n.x_index(1, 2) == n.nx - 1
    # fixed: RBEAM 3, HINGE 2, WHEEL 6, normalizations 2; then kinematic
    assert n.nep.tolist() == [13, 0, 0, 0, 1]
    assert n.e_index(2, 1) == n.ne - 1
    assert n.e_class["kinematic"] == slice(13, 14)
    assert n.slips.nonzero()[0].tolist() == [n.e_index(3, 5), n.e_index(3, 6)]
    assert (n.ndof, n.nddof, n.nkdof, n.nkddof) == (1, 1, 3, 3)
    assert n.k_names == ["node 1 y", n.e_name(13)]


def test_the_order_of_statements_does_not_matter() -> None:
    rng = np.random.default_rng(0)
    n = mechanism(SPATIAL).numbering
    for _ in range(5):
        other = mechanism(tuple(SPATIAL[i] for i in rng.permutation(len(SPATIAL)))).numbering
        for name in ("lnp", "le", "ln", "it", "nxp", "nep"):
            np.testing.assert_array_equal(getattr(other, name), getattr(n, name))


@pytest.mark.parametrize(
    ("keyword", "node", "expected"),
    [
        ("FIX", 1, {(1, 1), (1, 2), (1, 3)}),  # all independent coordinates of a position node
        ("FIX", 3, {(3, 2), (3, 3), (3, 4)}),  # lambda1..3; lambda0 follows from the normalization
        ("DYNX", 3, {(3, 2), (3, 3), (3, 4)}),
        ("INPUTX", 6, {(6, 1), (6, 2), (6, 3)}),
    ],
)
def test_default_coordinates_of_a_class(keyword: str, node: int, expected: set[tuple[int, int]]) -> None:
    n = mechanism((("BEAM", 5, 1, 3, 6, 8, 0.0, 1.0, 0.0), ("X", 6, 1.0), (keyword, node))).numbering
    name = {"FIX": "fixed", "DYNX": "dynamic", "INPUTX": "input"}[keyword]
    place = n.x_class[name]
    assert {n.x_owner(i) for i in range(place.start, place.stop)} == expected


def test_default_modes_of_a_class_and_a_planar_orientation() -> None:
    for keyword, name in (("RLSE", "calculable"), ("DYNE", "dynamic"), ("INPUTE", "input")):
        n = mechanism((("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0), (keyword, 1))).numbering
        place = n.e_class[name]
        assert [n.e_owner(i) for i in range(place.start, place.stop)] == [(1, 1), (1, 2), (1, 3)]
    n = mechanism((("PLBEAM", 1, 1, 2, 3, 4), ("X", 3, 1.0), ("FIX", 2), ("FIX", 1))).numbering
    assert n.nxp.tolist() == [3, 3, 0, 0, 0]  # it has one coordinate


def test_reference_configuration() -> None:
    m = mechanism(SPATIAL)
    n = m.numbering
    assert m.x0[n.lnp[5, :3] - 1].tolist() == [1.0, 0.0, 0.0]
    for node in (3, 4, 8):
        assert m.x0[n.lnp[node - 1] - 1].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert m.length == pytest.approx(1.0)
