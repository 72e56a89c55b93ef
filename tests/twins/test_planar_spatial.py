"""Planar mechanisms rebuilt with spatial elements: the same motion and the same forces.

The models share no element code. Integrated with 1e-11, compared at 1e-9 of the size of the quantity.
"""

import numpy as np
import pytest

import spacar
from tests.examples import DATA

TIGHT = ("ERROR", 1e-11, 1e-11)


def spatial(rows: list[tuple], dynamics: list[tuple]) -> tuple[list[tuple], list[tuple]]:
    """The same model with BEAM, RBEAM, HINGE, TRUSS in the plane z = 0; y' of all beams is the global z axis.

    PLBEAM modes 1, 2, 3 become BEAM modes 1, 3, 4 (bending in the x'z' plane); the others and all out-of-plane
    coordinates follow because every body keeps to the plane by its hinges and beams.
    """
    orientation = {n for r in rows if r[0] in ("PLBEAM", "PLRBEAM") for n in r[3:6:2] if r[0] == "PLBEAM" or n == r[3]}
    orientation |= {n for r in rows if r[0] == "PLTOR" for n in r[2:4]}
    kind = {r[1]: r[0] for r in rows if r[0].startswith("PL")}
    mode = {"PLBEAM": {1: 1, 2: 3, 3: 4}, "PLRBEAM": {1: 1, 2: 3}, "PLTOR": {1: 1}, "PLTRUSS": {1: 1}}
    out: list[tuple] = []
    for r in rows:
        if r[0] == "PLBEAM":
            out.append(("BEAM", *r[1:6], 0.0, 0.0, 1.0))
        elif r[0] == "PLRBEAM":
            out.append(("RBEAM", *r[1:5], 0.0, 0.0, 1.0))
        elif r[0] == "PLTOR":
            out.append(("HINGE", *r[1:4], 0.0, 0.0, 1.0))
        elif r[0] == "PLTRUSS":
            out.append(("TRUSS", *r[1:]))
        elif r[0] in ("FIX", "INPUTX", "DYNX") and r[1] in orientation:
            out.append((r[0], r[1], 4) if r[0] != "FIX" else ("FIX", r[1]))
        elif r[0] in ("DYNE", "INPUTE", "RLSE"):
            old = r[2:] or tuple(mode[kind[r[1]]])
            out.append((r[0], r[1], *[mode[kind[r[1]]][m] for m in old]))
        else:
            out.append(r)
    more: list[tuple] = []
    for r in dynamics:
        if r[0] == "XM" and r[1] in orientation:
            more.append(("XM", r[1], 1.0, 0.0, 0.0, 1.0, 0.0, r[2]))
        elif r[0] == "EM" and kind[r[1]] in ("PLBEAM", "PLRBEAM") and len(r) > 3:
            more.append(("EM", r[1], r[2], 0.1, r[3], 0.1))  # about y', the normal of the plane
        elif r[0] in ("ESTIFF", "EDAMP") and kind[r[1]] == "PLBEAM":
            more.append((r[0], r[1], r[2], 1.0, *r[3:4]))
        elif r[0] in ("STARTDE", "INPUTE"):
            more.append((r[0], r[1], mode[kind[r[1]]][r[2]], *r[3:]))
        elif r[0] == "XF" and r[1] in orientation:
            more.append(("XF", r[1], 0.0, 0.0, r[2]))
        else:
            more.append(r)
    return out, more


def compare(planar: spacar.Result, other: spacar.Result, nodes: list[int], tolerance: float = 1e-9) -> None:
    """Positions, velocities, accelerations and support forces of position nodes."""
    for variable in ("x", "xd", "xdd", "fxtot"):
        size = max(float(np.abs(planar.node(n, k, variable)).max()) for n in nodes for k in (1, 2))
        for n in nodes:
            for k in (1, 2):
                a, b = planar.node(n, k, variable), other.node(n, k, variable)
                np.testing.assert_allclose(b, a, atol=tolerance * size, rtol=0, err_msg=f"{variable} node {n} {k}")
            np.testing.assert_allclose(other.node(n, 3, variable), 0.0, atol=tolerance * size)


def both(
    rows: list[tuple], dynamics: list[tuple], extra: list[tuple] = (), drop: tuple = ()
) -> tuple[spacar.Result, ...]:
    a = spacar.run(1, spacar.Deck.build(rows, dynamics))
    r, d = spatial(rows, dynamics)
    b = spacar.run(1, spacar.Deck.build([*[x for x in r if x not in drop], *extra], d))
    return a, b


def test_gravity_pendulum() -> None:
    """A rigid compound pendulum on a hinge, large angles (the hinge angle is the degree of freedom in both)."""
    rows = [("PLTOR", 1, 1, 2), ("PLRBEAM", 2, 3, 2, 4), ("X", 4, 0.8, 0.3), ("FIX", 1), ("FIX", 3), ("DYNE", 1)]
    dynamics = [
        ("XM", 4, 2.0),
        ("XM", 2, 0.05),
        ("EM", 2, 0.7, 0.02),
        ("GRAVITY", 0.0, -9.81),
        ("TIMESTEP", 5.0, 50),
        TIGHT,
    ]
    a, b = both(rows, dynamics)
    compare(a, b, [3, 4])
    np.testing.assert_allclose(b.element(1, 1), a.element(1, 1), atol=1e-9)
    assert np.abs(a.element(1, 1)).max() > 2.0


def test_rigid_slider_crank() -> None:
    """Prescribed crank over three turns; gravity and masses: positions and all support forces."""
    rows = [
        ("PLTOR", 1, 1, 2), ("PLRBEAM", 2, 3, 2, 4), ("PLTOR", 3, 2, 5), ("PLRBEAM", 4, 4, 5, 6),
        ("X", 4, 0.15, 0.0), ("X", 6, 0.5, 0.0), ("FIX", 1), ("FIX", 3), ("FIX", 6, 2), ("INPUTE", 1), ("RLSE", 3),
    ]  # fmt: skip
    dynamics = [
        ("XM", 6, 0.5), ("XM", 5, 0.01), ("EM", 4, 0.4), ("GRAVITY", 0.0, -9.81), ("INPUTE", 1, 1, 0.0, 10.0, 2.0),
        ("TIMESTEP", 2.0, 40),
    ]  # fmt: skip
    a, b = both(rows, dynamics)
    compare(a, b, [3, 4, 6], 1e-10)
    np.testing.assert_allclose(b.element(1, 1, "sig"), a.element(1, 1, "sig"), atol=1e-10 * np.abs(a["sig"]).max())


def test_flexible_slider_crank() -> None:
    """crankfl with the crank on a hinge: bending of both rod halves at 150 rad/s."""
    rows = [
        ("PLTOR", 4, 11, 2), ("PLBEAM", 1, 1, 2, 3, 4), ("PLTOR", 5, 4, 5), ("PLBEAM", 2, 3, 5, 6, 7), ("PLBEAM", 3, 6, 7, 8, 9),  # noqa: E501
        ("X", 3, 0.15, 0.0), ("X", 6, 0.3, 0.0), ("X", 8, 0.45, 0.0), ("FIX", 11), ("FIX", 1), ("FIX", 8, 2),
        ("INPUTE", 4), ("RLSE", 5), ("DYNE", 2, 2, 3), ("DYNE", 3, 2, 3),
    ]  # fmt: skip
    dynamics = [
        ("XM", 8, 0.033375), ("EM", 2, 0.2225), ("EM", 3, 0.2225), ("ESTIFF", 2, 0.0, 13.359623), ("ESTIFF", 3, 0.0, 13.359623),  # noqa: E501
        ("INPUTE", 4, 1, 0.0, 150.0, 0.0), ("TIMESTEP", 0.0015, 4), ("ERROR", 1e-10, 1e-10),
    ]  # fmt: skip
    a, b = both(rows, dynamics)
    compare(a, b, [1, 3, 6, 8])
    for element, planar, solid in ((2, 2, 3), (2, 3, 4), (3, 2, 3), (3, 3, 4)):
        # opposite signs: rotations about y' = z against the slope in the x'z' plane
        x, y = a.element(element, planar), b.element(element, solid)
        np.testing.assert_allclose(np.abs(y), np.abs(x), atol=1e-9 * np.abs(x).max())


def test_fourbar() -> None:
    """data/fourbar: a moving state with a released bending mode, stresses included."""
    rows = [
        ("PLTRUSS", 1, 1, 2), ("PLTRUSS", 2, 2, 3), ("PLTRUSS", 3, 3, 4), ("PLTRUSS", 4, 1, 3),
        ("X", 2, 0.0, 1.0), ("X", 3, 1.0, 1.0), ("X", 4, 1.0, 0.0), ("FIX", 1), ("FIX", 4), ("DYNE", 4),
    ]  # fmt: skip
    dynamics = [("XM", 2, 1.0), ("XM", 3, 2.0), ("EM", 3, 0.5), ("ESTIFF", 4, 1.0), ("STARTDE", 4, 1, 0.1, 1.0),
                ("GRAVITY", 0.3, -1.0), ("TIMESTEP", 0.5, 20), TIGHT]  # fmt: skip
    a, b = both(rows, dynamics, extra=[("FIX", 2, 3), ("FIX", 3, 3)])
    compare(a, b, [1, 2, 3, 4])
    np.testing.assert_allclose(b["sig"], a["sig"], atol=1e-9 * np.abs(a["sig"]).max())


def test_flexible_pendulum_with_elongation_and_rotary_inertia() -> None:
    """Two beams, all planar modes flexible, rotary inertia per length, damping, tip moment."""
    rows = [
        ("PLTOR", 1, 1, 2), ("PLBEAM", 2, 3, 2, 4, 5), ("PLBEAM", 3, 4, 5, 6, 7), ("X", 4, 0.5, 0.0), ("X", 6, 1.0, 0.2),  # noqa: E501
        ("FIX", 1), ("FIX", 3), ("DYNE", 1), ("DYNE", 2), ("DYNE", 3),
    ]  # fmt: skip
    dynamics = [
        ("EM", 2, 1.0, 0.01), ("EM", 3, 0.8, 0.02), ("ESTIFF", 2, 500.0, 3.0), ("ESTIFF", 3, 400.0, 2.0),
        ("EDAMP", 2, 1.0, 0.01), ("EDAMP", 3, 1.0, 0.02), ("XM", 6, 0.3), ("GRAVITY", 0.0, -9.81), ("XF", 7, 0.2),
        ("STARTDE", 1, 1, 0.0, 2.0), ("TIMESTEP", 0.2, 8), TIGHT,
    ]  # fmt: skip
    a, b = both(rows, dynamics)
    compare(a, b, [3, 4, 6])


@pytest.mark.parametrize("duration", [1.0])
def test_tricycle(duration: float) -> None:
    """trike2 (planar) and trike3v (spatial, same steer angle): motion to 1e-6."""
    options = {"atol": 1e-10, "rtol": 1e-10, "duration": duration, "n_steps": 20}
    a = spacar.run(1, DATA / "trike2.dat", **options)
    b = spacar.run(1, DATA / "trike3v.dat", **options)
    for k in (1, 2):
        np.testing.assert_allclose(b.node(1, k), a.node(1, k), atol=1e-6)
        np.testing.assert_allclose(b.node(1, k, "xdd"), a.node(1, k, "xdd"), atol=1e-6 * 30)
    np.testing.assert_allclose(b.element(12, 1), a.node(2, 1), atol=1e-6)  # yaw
    np.testing.assert_allclose(b.element(8, 1), a.element(6, 1), atol=1e-6)  # steer
    np.testing.assert_allclose(b.element(2, 1), a.node(4, 1), atol=1e-6)  # rotation of the left wheel
    np.testing.assert_allclose(b.element(5, 1), a.node(6, 1), atol=1e-6)
    np.testing.assert_allclose(b.element(10, 1), a.node(10, 1), atol=1e-6)
    normal = sum(b.element(w, 3, "sig") for w in (3, 6, 11))
    np.testing.assert_allclose(normal, -9.81 * (80 + 2 + 2 + 1.5), rtol=1e-10)


def test_tricycle_against_published_numbers() -> None:
    """theory-spatial.md section 14: x, y, yaw, steer and rate of wheel 1 after 1 s."""
    r = spacar.run(1, DATA / "trike3v.dat", atol=1e-10, rtol=1e-10)
    found = [r.node(1, 1)[-1], r.node(1, 2)[-1], r.element(12, 1)[-1], r.element(8, 1)[-1], r.element(2, 1, "ed")[-1]]
    np.testing.assert_allclose(found, [2.7761162, -0.7113584, -0.3045697, -0.0045997, 8.6174554], atol=1e-6)
    forces = [r.element(w, 3, "sig")[-1] for w in (3, 6, 11)]
    np.testing.assert_allclose(forces, [-295.4587, -293.1418, -250.1545], atol=2e-4)


def test_inclined_tricycle_against_published_numbers() -> None:
    r = spacar.run(1, DATA / "trike3i.dat", atol=1e-10, rtol=1e-10)
    x, y = r.node(1, 1)[-1], r.node(1, 2)[-1]
    np.testing.assert_allclose([x, y], [2.6830252, -0.9857472], atol=1e-6)
