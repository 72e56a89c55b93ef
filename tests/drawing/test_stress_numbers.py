"""`Result.stress` and `spacar stress`: closed forms of bars, where the largest stress is, csv, json and npz.

A straight bar of 1 m along x with a section by BEAMSEC, loads so small that the deflection changes nothing: to 1e-6.
"""

import csv
import json

import numpy as np
import pytest
from scipy.integrate import simpson
from spacar_cli.main import main
from spacar_drawing import stress
from spacar_drawing.sections import warping_function, warping_shear
from spacar_drawing.settings import SectionShape
from spacar_drawing.stresses import QUANTITIES, Resultants, stress_field

import spacar
from spacar.errors import UsageError

W, T = 0.03, 0.012
BAR = """SECTION s {section}   {kind}   BEAMSEC 1 s steel {n}   X {q} 1. 0. 0.
DYNE 1   FIX 1   FIX 2   {more}   END HALT
{loads}   END END
"""


def bar(loads, section=f"RECT {W} {T}", kind="BEAM 1  1 2  4 5  0 1 0", q=4, n=1, more=""):
    """Mode 7 of a bar clamped at p."""
    text = BAR.format(section=section, kind=kind, q=q, n=n, loads=loads, more=more)
    return spacar.run(7, spacar.parse_deck(text, mode=7))


def test_tension():
    found = bar("XF 4 90.").stress()
    np.testing.assert_allclose(found["N"], 90.0, rtol=1e-9)
    for name in ("normal", "mises"):
        np.testing.assert_allclose(found[name], 90.0 / (W * T), rtol=1e-9)
    np.testing.assert_allclose(found["shear"], 0.0, atol=1e-6)


def test_bending():
    """A force F along z' at the end: M = F (1 - x), sigma = 6 M/(w t^2); shear 3 F/(2 w t) in the middle."""
    F = 1e-3
    found = bar(f"XF 4 0. 0. {F}").stress(points=5)
    np.testing.assert_allclose(np.abs(found["My"][0, 0]), F * (1 - found.xi), atol=1e-6 * F)
    np.testing.assert_allclose(found["Qz"], F, rtol=1e-6)
    np.testing.assert_allclose(np.abs(found["normal"][0, 0]), 6 * F * (1 - found.xi) / (W * T**2), atol=1e-5)
    np.testing.assert_allclose(found["shear"], 1.5 * F / (W * T), rtol=1e-6)
    largest = found.largest("mises")
    assert (largest.step, largest.element, largest.xi) == (1, 1, 0.0)
    assert abs(largest.z) == pytest.approx(T / 2)
    assert largest.value == pytest.approx(6 * F / (W * T**2), rel=1e-6)


@pytest.mark.parametrize(("ratio", "k"), [(1, 0.208), (2, 0.246), (5, 0.291), (10, 0.312)])
def test_torsion_of_a_rectangle(ratio, k):
    """tau max = T/(k w t^2), k of Timoshenko and Goodier, art. 109 (three digits), in the middle of the longer side."""
    found = bar("XF 5 1e-3 0. 0.", section=f"RECT {ratio * T} {T}").stress()
    np.testing.assert_allclose(found["T"], 1e-3, rtol=1e-6)
    assert found.largest("shear").value == pytest.approx(1e-3 / (k * ratio * T**3), rel=3e-3)
    if ratio > 1:
        assert abs(found.largest("shear").y) < 1e-12
    assert found.largest("mises").value == pytest.approx(np.sqrt(3) * found.largest("shear").value, rel=1e-9)


def test_a_tube_with_everything_at_once():
    """sigma = N/A + M r/I and tau = T r/J at the outside of the clamp: sqrt(sigma^2 + 3 tau^2)."""
    d, t = 0.04, 0.004
    found = bar("XF 4 50. 0. 2e-3\nXF 5 0.7 0. 0.", section=f"TUBE {d} {t}").stress()
    A, I = np.pi / 4 * (d**2 - (d - 2 * t) ** 2), np.pi / 64 * (d**4 - (d - 2 * t) ** 4)
    sigma, tau = 50 / A + 2e-3 * d / 2 / I, 0.7 * d / 2 / (2 * I)
    one = found.largest("mises")
    # Qz has no part in the outermost fibre; the mean over the walls, 2 Q/A, is added here: 4e-5 of tau
    assert one.value == pytest.approx(np.sqrt(sigma**2 + 3 * tau**2), rel=1e-4)
    assert (one.xi, np.hypot(one.y, one.z)) == (0.0, pytest.approx(d / 2))


def test_a_flange_in_bending_and_torsion():
    """I section: M h/(2 Iy) in the flanges, T tf/It at the surface of the flanges (the thicker plates)."""
    b, h, tw, tf = 0.1, 0.2, 5.6e-3, 8.5e-3
    r = bar("XF 4 0. 0. 1e-3\nXF 5 1e-3 0. 0.", section=f"I {b} {h} {tw} {tf}")
    c = r.mechanism.deck.sections[0].constants
    found = r.stress()
    assert abs(found.largest("normal").value) == pytest.approx(1e-3 * h / 2 / c.Iy, rel=1e-6)
    assert found.largest("shear").value == pytest.approx(1e-3 * tf / c.It, rel=2e-2)  # and the web's mean of Qz


WARPED = {"kind": "BEAMW 1  1 2 3  4 5 6  0 1 0", "more": "FIX 3"}


def test_bimoment_and_warping_stress():
    """Torque M on a strip clamped at p, warping free at q: B = (M/k) tanh(kL) at the clamp, T all warping there;
    sigma = 36 B/(w^2 t^2) in the corners. The mesh: k l0 = 0.9, (k l0)^4/1000 or so."""
    w, t, M = 0.3, 3e-3, 1e-4
    r = bar(f"XF 5 {M} 0. 0.", section=f"RECT {w} {t}", n=16, **WARPED)
    c, m = r.mechanism.deck.sections[0].constants, r.mechanism.deck.sections[0].material
    k = np.sqrt(m.G * c.It / (m.E * c.Cw))
    found = r.stress(points=3)
    B = M / k * np.tanh(k)
    np.testing.assert_allclose(found["T"], M, rtol=1e-7)
    assert abs(found["B"][0, 0, 0]) == pytest.approx(B, rel=1e-3)
    one = found.largest("normal")
    assert abs(one.value) == pytest.approx(36 * B / (w * t) ** 2, rel=1e-3)
    assert (one.element, one.xi, abs(one.y), abs(one.z)) == (1, 0.0, w / 2, t / 2)
    # shear stress from GIt times the twist rate, zero at the clamp and T(1 - 1/cosh kL) at the free end; at the clamp
    # that of the warping torque, as in a plate: 3/2 times the shear force of a strip that turns about its middle line
    end = int(np.flatnonzero(found.elements == 16)[0])
    twist = M * (1 - 1 / np.cosh(k))
    plain = bar(f"XF 5 {twist} 0. 0.", section=f"RECT {w} {t}").stress().largest("shear").value
    assert found["shear"][0, end, -1] == pytest.approx(plain, rel=2e-3)
    assert found["shear"][0, 0, 0] == pytest.approx(9 * M / (w**2 * t), rel=2e-3)
    np.testing.assert_allclose(np.abs(found.places["shear"][0, 0, 0]), [w / 2, 0.0], atol=1e-12)


@pytest.mark.parametrize("dims", [(0.05, 5e-4), (5e-4, 0.05), (0.02, 0.01)])
def test_warping_shear_of_a_rectangle(dims):
    """It balances the change of the normal stress at every point, vanishes on the outline and has the torque T_w."""
    w, h = dims
    section, Cw = SectionShape("RECT", dims), (w * h) ** 3 / 144
    y, z = np.meshgrid(np.linspace(-0.5, 0.5, 101) * w, np.linspace(-0.5, 0.5, 101) * h, indexing="ij")
    ty, tz = warping_shear(section, y, z)
    change = -warping_function(section, y, z) / Cw  # dB/dx = -1
    divergence = np.gradient(ty, y[:, 0], axis=0) + np.gradient(tz, z[0], axis=1)
    np.testing.assert_allclose((change + divergence)[1:-1, 1:-1], 0.0, atol=1e-9 * np.abs(change).max())
    faces = np.concatenate((ty[0], ty[-1], tz[:, 0], tz[:, -1]))
    np.testing.assert_allclose(faces, 0.0, atol=1e-12 * np.hypot(ty, tz).max())
    torque = simpson(simpson(y * tz - z * ty, x=z[0]), x=y[:, 0])
    assert torque == pytest.approx(1.0, rel=1e-9)


def test_warping_shear_of_an_i_section():
    """The flanges carry T_w/(h - tf) each, in opposite directions."""
    b, h, tw, tf = 0.1, 0.2, 5.6e-3, 8.5e-3
    y = np.linspace(-0.5, 0.5, 101) * b
    section = SectionShape("I", (b, h, tw, tf))
    forces = [simpson(warping_shear(section, y, np.full(101, side * 0.5 * (h - tf)))[0], x=y) * tf for side in (1, -1)]
    np.testing.assert_allclose(forces, [-1 / (h - tf), 1 / (h - tf)], rtol=1e-6)
    change = -warping_function(section, y, np.full(101, 0.5 * (h - tf))) / (tf * b**3 * (h - tf) ** 2 / 24)
    slope = np.gradient(warping_shear(section, y, np.full(101, 0.5 * (h - tf)))[0], y)
    np.testing.assert_allclose((change + slope)[1:-1], 0.0, atol=1e-9 * np.abs(change).max())


def test_planar_beams():
    """PLBEAM: force across at the end, sigma = 6 F (1 - x)/(t w^2), with w along y'."""
    text = BAR.format(section=f"RECT {W} {T}", kind="PLBEAM 1 1 2 4 5", q=4, n=2, loads="XF 4 0. 1e-3", more="")
    found = spacar.run(7, spacar.parse_deck(text, mode=7)).stress()
    assert abs(found.largest("normal").value) == pytest.approx(6e-3 / (T * W**2), rel=1e-6)


def test_what_is_refused():
    r = bar("XF 4 1.")
    for options, text in (
        ({"steps": [2]}, "step 2 does not exist"), ({"elements": [7]}, "element 7 is no beam or truss; these are 1"),
        ({"points": 1}, "at least 2"),
    ):  # fmt: skip
        with pytest.raises(UsageError, match=text):
            stress(r, **options)
    with pytest.raises(UsageError, match="there is no speed; quantities are N, Qy"):
        r.stress()["speed"]
    bare = spacar.run(7, spacar.parse_deck("BEAM 1 1 2 3 4\nX 3 1.\nFIX 1\nFIX 2\nDYNE 1\nEND HALT\n"
                                           "ESTIFF 1 1. 1. 1. 1.\nEM 1 1. 1. 1. 1.\nEND END\n"))  # fmt: skip
    with pytest.raises(UsageError, match="no element has a cross-section: give BEAMSEC with a shape"):
        bare.stress().largest()


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    loads = "XF 4 0. 0. 1\nXF 5 1. 0. 0."
    text = BAR.format(section="RECT 30 12", kind=WARPED["kind"], q=4, n=2, loads=loads, more="FIX 3")
    (tmp_path / "bar.dat").write_text(text.replace("SECTION", "UNITS mm\nSECTION", 1).replace("X 4 1.", "X 4 100."))
    assert main(["7", "bar"]) == 0
    assert main(["stress", "bar", "--points", "3", "--csv", "s.csv", "-o", "s.npz"]) == 0
    printed = capsys.readouterr().out
    assert "Largest of all" in printed
    assert "y (mm)" in printed
    assert "N/mm" in printed
    assert main(["stress", "bar", "--points", "3", "--json"]) == 0
    found = {one["quantity"]: one for one in json.loads(capsys.readouterr().out)}
    r = spacar.run(7, "bar.dat").stress(points=3)
    rows = list(csv.DictReader((tmp_path / "s.csv").open()))
    assert len(rows) == r["N"].size
    arrays = np.load(tmp_path / "s.npz")
    for name in QUANTITIES:
        np.testing.assert_array_equal([float(row[name]) for row in rows], r[name].ravel())
        np.testing.assert_array_equal(arrays[name], r[name])
    assert found["mises"]["value"] == r.largest("mises").value
    assert main(["stress", "bar", "--element", "9"]) == 2
    assert "element 9 is no beam or truss" in capsys.readouterr().err


@pytest.mark.parametrize("Qy", [1e160, 1e-170])
def test_shear_stresses_of_any_size(Qy):
    """3/2 Q/A in the middle of a rectangle; squares would over- and underflow."""
    zero = np.zeros(1)
    r = Resultants(zero, np.array([Qy]), zero, zero, zero, zero)
    assert stress_field(SectionShape("RECT", (1.0, 1.0)), r, (zero, zero))[1] == pytest.approx(1.5 * Qy, rel=1e-14)
