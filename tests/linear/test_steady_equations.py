"""Rotors in coordinates of fixed directions: their equations are periodic in time unless they are symmetric."""

import numpy as np
import pytest

import spacar
from spacar.errors import AnalysisError


def planar_rotor(angles: list[float], k: list[float], omega: float, q: str, centre: float = 0.0) -> spacar.Result:
    """A mass of 2 kg at (centre, 0), held by springs k [N/m] from points of a turntable at these angles."""
    n = len(angles)
    lines = [f"PLRBEAM {i + 1} 1 2 {3 + i}" for i in range(n)]
    lines += [f"PLTRUSS {n + i + 1} {3 + i} 20" for i in range(n)]
    lines += [f"X {3 + i} {float(np.cos(a))!r} {float(np.sin(a))!r}" for i, a in enumerate(angles)]
    lines += [f"X 20 {centre!r} 0.", "FIX 1", "INPUTX 2", q]
    chosen = [int(row.split()[1]) for row in q.splitlines() if row.startswith("DYNE")]
    lines += [f"RLSE {n + i + 1} 1" for i in range(n) if n + i + 1 not in chosen]
    length = [float(np.hypot(np.cos(a) - centre, np.sin(a))) for a in angles]
    lines += ["END", "HALT", *(f"ESTIFF {n + i + 1} {k[i] * length[i]!r}" for i in range(n))]
    lines += ["XM 20 2.", f"INPUTX 2 1 0.3 {omega!r}", "END", "END", ""]
    return spacar.run(7, spacar.parse_deck("\n".join(lines), mode=7))


CROSS = [0.0, np.pi, np.pi / 2, -np.pi / 2]


@pytest.mark.parametrize("omega", [3.0, -50.0, 1e-3])
def test_an_unsymmetric_rotor_has_no_eigenvalues_in_fixed_directions(omega: float) -> None:
    with pytest.raises(AnalysisError, match=r"node 20 .*DYNX.*DYNE") as refused:
        planar_rotor(CROSS, [20.0, 20.0, 45.0, 45.0], omega, "DYNX 20 1 2")
    assert refused.value.code == "statics.not-steady"


def test_the_remedy_gives_those_of_the_rotating_frame() -> None:
    """m (x'' - 2 w y' - w^2 x) + kx x = 0 and its partner, kx = 40, ky = 90, m = 2, w = 5: a divergence."""
    w, kx, ky = 5.0, 20.0, 45.0
    s = np.roots([1.0, 0.0, kx - w * w + ky - w * w + 4 * w * w, 0.0, (kx - w * w) * (ky - w * w)])
    result = planar_rotor(CROSS, [20.0, 20.0, 45.0, 45.0], w, "DYNE 5 1\nDYNE 7 1")
    found = result["eigval"][-1] @ [1.0, 1.0j]
    for value in s:
        assert np.abs(found - value).min() < 1e-7
    assert not any("steady motion" in line for line in result.report)


@pytest.mark.parametrize("blades", [3, 4, 5, 7])
def test_a_symmetric_rotor_passes_in_fixed_directions(blades: float) -> None:
    """n >= 3 equal springs are isotropic: sqrt(n k/2 m), whatever the speed."""
    angles = [round(2 * np.pi * i / blades, 6) for i in range(int(blades))]
    result = planar_rotor(angles, [40.0] * int(blades), 7.0, "DYNX 20 1 2")
    expected = np.sqrt(0.5 * blades * 40.0 / 2.0)
    assert np.hypot(*result["eigval"][-1].T) == pytest.approx(expected, rel=1e-5)  # the angles have six digits


def test_a_mass_off_the_axis_stands_in_no_equilibrium() -> None:
    with pytest.raises(AnalysisError, match="DYNX"):
        planar_rotor(CROSS, [40.0] * 4, 3.0, "DYNX 20 1 2", centre=0.2)


SHAFT = """
HINGE 1 1 2 0. 0. 1.   RBEAM 2 3 2 4   TRUSS 3 4 5   TRUSS 4 6 5   RBEAM 5 3 2 6
X 3 0. 0. 0.   X 4 1. 0. 0.   X 5 0. 0. 0.   X 6 0. 1. 0.   {given}   FIX 3   FIX 5 3   {q}
END HALT
ESTIFF 3 20.   ESTIFF 4 {ky!r}   XM 5 2.   {rate}   END END
"""


@pytest.mark.parametrize(("given", "rate"), [
    ("FIX 1\nINPUTE 1 1", "INPUTE 1 1 0. 3."),
    ("FIX 1\nINPUTE 1 1", "INPUTE 1 1 0.2 -3."),
    ("RLSE 1 1 2 3\nINPUTX 2 4\nFIX 2 2 3\nFIX 1", "INPUTX 2 4 0. 1.5"),
])  # fmt: skip
def test_prescribed_rotations_in_space(given: str, rate: str) -> None:
    """A hinge with INPUTE, a node with INPUTX: one spring along, one across; in turning coordinates as it should."""

    def run(q: str, ky: float) -> spacar.Result:
        return spacar.run(7, spacar.parse_deck(SHAFT.format(given=given, rate=rate, q=q, ky=ky), mode=7))

    fixed, turning = "DYNX 5 1 2\nRLSE 3 1\nRLSE 4 1", "DYNE 3 1\nDYNE 4 1"
    with pytest.raises(AnalysisError, match="DYNX"):
        run(fixed, 45.0)
    same = np.hypot(*run(fixed, 20.0)["eigval"][-1].T)
    assert same == pytest.approx(np.sqrt(10.0), rel=1e-9)
    moving = run(turning, 45.0)
    assert not any("steady motion" in line for line in moving.report)
    s = np.roots([1.0, 0.0, 10.0 - 9.0 + 22.5 - 9.0 + 36.0, 0.0, 1.0 * 13.5])
    found = moving["eigval"][-1] @ [1.0, 1.0j]
    assert max(np.abs(found - v).min() for v in s) < 1e-7
    assert np.abs(run(turning, 20.0)["eigval"]).max() == pytest.approx(np.sqrt(10.0) + 3.0, rel=1e-9)


def test_a_crank_is_no_steady_motion() -> None:
    """The rod of a crank: deformations are no remedy. It is said, and the frozen equations are given."""
    result = spacar.run(7, "data/crankfl.dat")
    assert any("frozen" in line for line in result.report)
