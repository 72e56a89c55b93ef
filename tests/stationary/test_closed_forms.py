"""Steady motion with deformation inertia (MEE) and flow in tubes against closed forms."""

import numpy as np
import pytest

import spacar


def rotor(omega: float, mee: str) -> spacar.Result:
    """A mass of 2 kg on a radial spring of 500 N/m (1 m, along x) that turns with omega; a released truss measures its
    distance from the point (0.4, 0)."""
    text = f"""
PLBEAM 1 1 2 3 4   PLTRUSS 2 5 3   X 3 1. 0.   X 5 0.4 0.
FIX 1   FIX 5   INPUTX 2 1   DYNE 1 1   RLSE 2 1   END HALT
XM 3 2.   ESTIFF 1 500. 0.   {mee}   INPUTX 2 1 0. {omega!r}   ITERSTEP 20 4 1e-10   END END
"""
    return spacar.run(7, spacar.parse_deck(text, mode=7))


@pytest.mark.parametrize("omega", [0.0, 3.0, 8.0])
@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_inertia_of_a_calculable_deformation_in_steady_motion(omega: float, mu: float) -> None:
    """Distance l of the mass at r from (a, 0), at the angle 0: l'' = a r omega^2/(r - a), so that
    k (r - 1) = m r omega^2 - mu l'', a quadratic equation for r."""
    k, m, a = 500.0, 2.0, 0.4
    w = omega * omega
    # (k (r - 1) - m r w) (r - a) + mu a r w = 0
    roots = np.roots([k - m * w, -k - a * (k - m * w) + mu * a * w, a * k])
    r = float(roots[np.argmin(np.abs(roots - 1.0))]) if w else 1.0
    result = rotor(omega, f"MEE 2 1 {mu!r}")
    assert result.node(3, 1)[-1] == pytest.approx(r, rel=1e-12)
    assert result.element(2, 1, "edd")[-1] == pytest.approx(a * r * w / (r - a), rel=1e-10, abs=1e-12)


def test_inertia_of_a_degree_of_freedom_has_no_part_in_the_steady_state() -> None:
    """edd of a dynamic deformation is zero: MEE 1 1 shifts the frequency and not the place."""
    with_it, without = rotor(3.0, "MEE 1 1 1.5"), rotor(3.0, "")
    assert with_it.node(3, 1)[-1] == pytest.approx(without.node(3, 1)[-1], rel=1e-13)
    # (k - m w^2) / (m + mu), the radial stiffness in rotation; the angle is prescribed: no Coriolis coupling
    for result, mass in ((with_it, 3.5), (without, 2.0)):
        value = result["eigval"][-1]
        assert np.hypot(*value.T) == pytest.approx(np.sqrt((500.0 - 2.0 * 9.0) / mass), rel=1e-10)


def test_coupled_deformation_inertia_at_rest_does_nothing() -> None:
    """MEE between both elements: at rest no deformation accelerates."""
    result = rotor(0.0, "MEE 1 1 2 1 0.3")
    assert result.node(3, 1)[-1] == pytest.approx(1.0, abs=1e-15)
    assert np.abs(result["sig"][-1]).max() == pytest.approx(0.0, abs=1e-12)


def tube(n: int, share: float) -> float:
    """Deflection under 1 uN in the middle of a pinned tube (L = 1, EI = 1, ends held) over that without flow."""

    def middle(flow: float) -> float:
        lines = [f"PLTUBE {k} {2 * k - 1} {2 * k} {2 * k + 1} {2 * k + 2}" for k in range(1, n + 1)]
        lines += [f"X {2 * k + 1} {k / n!r} 0." for k in range(1, n + 1)]
        lines += ["FIX 1", f"FIX {2 * n + 1}", *(f"DYNX {k}" for k in range(2, 2 * n + 3) if k != 2 * n + 1)]
        lines += [f"RLSE {k} 1 2 3" for k in range(1, n + 1)]
        lines += ["END", "HALT"]
        lines += [f"EM {k} 1. 0.5 {flow!r}" for k in range(1, n + 1)]
        lines += [f"ESTIFF {k} 1e3 1." for k in range(1, n + 1)]
        lines += [f"XF {n + 1} 0. 1e-6", "ITERSTEP 20 5 1e-14", "END", "END", ""]
        return float(spacar.run(8, spacar.parse_deck("\n".join(lines), mode=8)).node(n + 1, 2)[-1])

    # G U = G^2/mu = share pi^2 EI/L^2 with mu = 0.5 kg/m
    return middle(float(np.sqrt(0.5 * share) * np.pi)) / middle(0.0)


@pytest.mark.parametrize("share", [0.2, 0.6, 0.9])
def test_flow_softens_a_tube_between_held_ends(share: float) -> None:
    """Momentum flux G U acts as a compressive force: 3 (tan u - u)/u^3, u = (L/2) sqrt(G U/EI) (Timoshenko)."""
    u = 0.5 * np.pi * np.sqrt(share)
    exact = 3.0 * (np.tan(u) - u) / u**3
    errors = [abs(tube(n, share) / exact - 1.0) for n in (4, 8)]
    assert errors[1] < 1e-3
    assert errors[0] > 8.0 * errors[1]  # cubic deflections: of order h^4
