"""Deformations of the spatial beam with warping in the angle measure by its sixteen coordinates, and derivatives.

The formulas are in `warping_angle_measure`; what belongs to the beam comes from `beam_angle_strain`. Coordinates
x_p (3), lambda_p (4), w_p, x_q (3), lambda_q (4), w_q.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements import beam_angle_strain as beam_of
from spacar.elements.angle_measure import AngleConstants, inner_rows
from spacar.elements.taylor import Taylor, composed, contracted
from spacar.elements.warping_angle_measure import deformations, gradient

BEAM = np.array([0, 1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13, 14])  # coordinates that a BEAM has too
RATES = np.array([7, 15])  # twist rates


class WarpingAngleState(NamedTuple):
    """What later calls at the same x reuse; `beam.E` (10, 8, n) holds the derivatives of all deformations."""

    beam: beam_of.AngleState
    w: Array  # (2, n)


def state(p: AngleConstants, x: Array) -> WarpingAngleState:
    """The state at x (16, n)."""
    w = x[RATES]
    return WarpingAngleState(beam_of.state(p, x[BEAM], partial(gradient, w=w)), w)


def values(c: WarpingAngleState) -> Array:
    """e (8, n)."""
    b = c.beam
    return np.asarray(deformations(b.p, b.inner.y, b.G[0], c.w))


def _put(c: WarpingAngleState, of_beam: Array, of_w: Array, out: Array) -> None:
    """Write rows by the local coordinates, (8, 11, n), and by w, (2, 8, n), as rows by x to out (8, 16, n)."""
    V = np.empty((8, 14, *of_beam.shape[2:]), of_beam.dtype)
    beam_of.rows(c.beam, of_beam, V)
    out[:, BEAM] = V
    out[:, RATES] = of_w.swapaxes(0, 1)


def first(c: WarpingAngleState, out: Array) -> None:
    """V (8, 16, n)."""
    E = c.beam.E
    _put(c, np.einsum("ye...,yj...->ej...", E[:8], inner_rows(c.beam.inner)), E[8:], out)


def _rates(c: WarpingAngleState, v: Array, terms: int) -> Any:
    """w as a series along v (16, n)."""
    return Taylor([c.w, v[RATES], *[np.zeros_like(c.w)] * (terms - 2)])


def second_rate(c: WarpingAngleState, v: Array) -> Array:
    """H(v, v) (8, n)."""
    along, G, _ = beam_of.along_line(c.beam, v[BEAM], 3)
    return np.asarray(2.0 * deformations(c.beam.p, along.y, G, _rates(c, v, 3)).c[2])


def derivative_of_rows(c: WarpingAngleState, v: Array, order: int, out: Array) -> None:
    """d^order V/ds^order along v, order 1 (H1) or 2 (T), (8, 16, n)."""
    along, G, G1 = beam_of.along_line(c.beam, v[BEAM], order + 1)
    E = gradient(c.beam.p, along.y, G, G1, _rates(c, v, order + 1))
    local = contracted("ye...,yj...->ej...", E[:8], inner_rows(along))
    _put(c, order * local.c[order], order * E.c[order][8:], out)


def hessian(c: WarpingAngleState, sigma: Array, out: Array) -> None:
    """sum_k sigma_k d2(e_k) (16, 16, n)."""
    b, tail = c.beam, sigma.shape[1:]
    directions = np.eye(10).reshape(10, 10, *(1,) * len(tail))
    y, w = Taylor([b.inner.y[:, None], directions[:8]]), Taylor([c.w[:, None], directions[8:]])
    G = b.G[:, None]
    rates = gradient(b.p, y, composed(y[0], *G[:2]), composed(y[0], *G[1:3]), w).c[1]
    curvature = np.einsum("yed...,e...->yd...", rates, sigma)
    force = np.einsum("ye...,e...->y...", b.E[:8], sigma)
    H = np.empty((14, 14, *tail), curvature.dtype)
    beam_of.write_hessian(b, curvature[:8, :8], force, H)
    out[np.ix_(BEAM, BEAM)] = H
    local = np.einsum("yd...,yj...->dj...", curvature[:8, 8:], inner_rows(b.inner))
    mixed = np.empty((2, 14, *tail), curvature.dtype)
    beam_of.rows(b, local, mixed)
    out[np.ix_(RATES, BEAM)] = mixed
    out[np.ix_(BEAM, RATES)] = mixed.swapaxes(0, 1)
    out[np.ix_(RATES, RATES)] = curvature[8:, 8:]
