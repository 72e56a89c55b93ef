"""The two roots of a position near a dead point, and the badly conditioned positions that have one."""

import numpy as np
import pytest

from spacar import Deck
from spacar.kinematics.constraint_matrices import ROUNDING
from spacar.kinematics.kinematics import Kinematics
from spacar.linear_systems.reciprocal_condition import smallest
from spacar.mechanism import build

R, L = 0.15, 0.35


def slider(angle: float, size: float = 1.0) -> Kinematics:
    """Crank R, rod L, driven by the slider; the crank is at the angle from its dead centre, reference configuration."""
    x, y = R * np.cos(angle), R * np.sin(angle)
    rows = [
        ("PLRBEAM", 1, 1, 2, 3), ("PLRBEAM", 2, 3, 4, 5), ("X", 3, x * size, y * size),
        ("X", 5, (x + np.sqrt(L**2 - y**2)) * size, 0.0), ("FIX", 1), ("FIX", 5, 2), ("INPUTX", 5, 1),
    ]  # fmt: skip
    k = Kinematics(build(Deck.build(rows, [])))
    k.move(k.mechanism.x0, np.zeros(k.numbering.ne))
    return k


def single(k: Kinematics, rounding: float) -> bool:
    D = k.sweep.gradient()[np.ix_(k.h, k.c)] * k.scale[k.c] / k.h_scale[:, None]
    assert k.norm(k.of_position) == pytest.approx(np.abs(D).sum(axis=0).max(), rel=1e-12)
    return k.is_single_root(k.of_position, rounding)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("angle", [1e-2, 1e-4])
def test_the_second_root_is_where_the_fold_says(angle: float, size: float) -> None:
    """Crank up and crank down have the same slider: the roots are 2 x angle apart, to angle^2."""
    k = slider(angle, size)
    s, u, w = smallest(k.position_system, 1.0 / k.h_scale, k.scale[k.c])
    v = np.zeros(k.numbering.nx)
    v[k.c] = w * k.scale[k.c]
    c = u @ (k.sweep.convective(v)[k.h] / k.h_scale)
    crank = k.numbering.x_index(2, 1)
    # the reference configuration is phi = 0 at the angle: down is -2 angle
    assert -2.0 * s / c * v[crank] == pytest.approx(-2.0 * angle, rel=3 * angle)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_roots_nearer_than_rounding_are_one(size: float) -> None:
    """The residual of the fold, angle^2 R (R + L)/(2 L) in model lengths: single when it exceeds rounding."""
    for angle in (1e-3, 1e-5, 1e-6):
        k = slider(angle, size)
        residual = angle**2 * R * (R + L) / (2 * L) / (R + L)
        assert single(k, 0.1 * residual)
        assert not single(k, 20.0 * residual)  # along u the residual is smaller than its largest component


@pytest.mark.parametrize("n", [10, 1000, pytest.param(10000, marks=pytest.mark.slow)])
def test_every_position_of_a_long_chain_is_single(n: int) -> None:
    """Smallest singular value about n^-2, down to 2.5e-9 of the norm."""
    rows: list[tuple] = [("PLBEAM", k + 1, 2 * k + 1, 2 * k + 2, 2 * k + 3, 2 * k + 4) for k in range(n)]
    rows += [("X", 2 * k + 1, k / n, 0.0) for k in range(1, n + 1)] + [("FIX", 1), ("INPUTX", 2, 1)]
    k = Kinematics(build(Deck.build(rows, [])))
    k.begin()
    s = smallest(k.position_system, 1.0 / k.h_scale, k.scale[k.c])[0]
    assert s < 1.0 / n**1.5
    assert k.is_single_root(k.of_position, ROUNDING)


def test_a_position_at_its_dead_centre_is_not_single() -> None:
    assert not single(slider(1e-9), ROUNDING)
    assert single(slider(1e-5), ROUNDING)
