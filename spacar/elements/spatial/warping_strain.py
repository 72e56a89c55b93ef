"""Deformations of the spatial beam with warping and their derivatives (theory-warping.md section 3).

To the six raw deformations of the beam come two, with w the twist rate at the nodes [rad/m]:

    eb7 = eb2 - l0^2 w_p,   eb8 = l0^2 w_q - eb2

and the second order terms e = eb + 1/2 eb Q_k eb of all eight. Everything of eb1 ... eb6 is taken from
`beam_strain`; the second and third derivatives of eb7 are those of eb2, of eb8 the opposite, and none depends on w.

Rows W of first derivatives have the shape (8, 2, 8, n): modes, node p or q, (position, lambda, w). As in
`beam_strain` the columns of the position of p are written at the end, by `put`.
"""

from typing import NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.spatial import beam_strain

_einsum = np.einsum
RATES = np.array([7, 15])  # twist rates
BEAM = np.delete(np.arange(16), RATES)  # coordinates that a BEAM has too
WARPING_BENDING = True
"""Whether bending depends on warping (the terms with eb7, eb8 in e3 ... e6): the one place of this choice of
theory-warping.md section 11. With them buckling loads converge with order 4, without with order 2."""


class WarpingState(NamedTuple):
    """What later calls at the same x reuse."""

    beam: beam_strain.BeamState  # without its second order terms
    raw: Array  # (8, n) eb
    W: Array  # (8, 2, 8, n) gradient of eb
    Q: Array | None  # (8, 8, n) Q_k eb, None for LDEFORM beams only

    @property
    def p(self) -> beam_strain.BeamConstants:
        return self.beam.p


def correction_coefficients(shear: Array) -> Array:
    """Q (8, 8, 8, ...): l0 times the symmetric Q_k of section 3, without the torsion-elongation terms, for the factors
    1/(1 + Phi_z), 1/(1 + Phi_y) of the antisymmetric bending (2, ...)."""
    Q = np.zeros((8, 8, 8, *shear.shape[1:]), shear.dtype)
    Q[:6, :6, :6] = beam_strain.correction_coefficients(shear)
    Q[6], Q[7] = Q[1], -Q[1]
    if not WARPING_BENDING:
        return Q
    for k, i, j, value in (
        (2, 4, 6, -1 / 10), (2, 4, 7, -1 / 30), (2, 5, 7, -1 / 30),
        (3, 5, 7, -1 / 10), (3, 4, 6, -1 / 30), (3, 5, 6, -1 / 30),
        (4, 2, 6, 1 / 10), (4, 2, 7, 1 / 30), (4, 3, 7, 1 / 30),
        (5, 3, 7, 1 / 10), (5, 2, 6, 1 / 30), (5, 3, 6, 1 / 30),
    ):  # fmt: skip
        Q[k, i, j] += value
        Q[k, j, i] += value
    _, _, a, _, b = beam_strain.bending_forms(8)
    less, sign = (shear[1] - 1.0, 1.0 - shear[0]), (1.0, -1.0)
    for k, form, factor in ((2, b, less[0]), (4, a, less[1])):
        for end in (0, 1):
            w = np.zeros(8)
            w[6 + end] = sign[end] / 20.0
            Q[k + end] += beam_strain.times(factor, beam_strain.pair(form, w))
    return Q


# l0^3/f1 times the torsion-elongation part of Q_1: shortening 1/2 f1 (twist rate)^2 at every place of the beam
_SHORTENING = np.zeros((8, 8))
_SHORTENING[1, 1] = 1.0
_SHORTENING[6, 6] = _SHORTENING[7, 7] = 2.0 / 15.0
_SHORTENING[6, 7] = _SHORTENING[7, 6] = 1.0 / 30.0


def _eight(e: Array) -> Array:
    """Second rates (8, n) of the raw deformations from those of the beam (6, n)."""
    return np.concatenate((e, e[1:2], -e[1:2]))


def _extended(W: Array) -> Array:
    """Rows (8, 2, 8, n) from those of the beam (6, 2, 7, n), with nothing in the columns of w."""
    out = np.zeros((8, 2, 8, *W.shape[3:]), W.dtype)
    out[:6, :, :7] = W
    out[6, :, :7] = W[1]
    out[7, :, :7] = -W[1]
    return out


def state(p: beam_strain.BeamConstants, x: Array, second: bool) -> WarpingState:
    """Raw deformations and their gradient at x (16, n); `second`: some beam has second order terms."""
    beam = beam_strain.state(p, x[BEAM], False)
    square = p.l0**2
    raw = _eight(beam.raw)
    raw[6] -= square * x[7]
    raw[7] += square * x[15]
    W = _extended(beam.W)
    W[6, 0, 7] = -square
    W[7, 1, 7] = square
    return WarpingState(beam, raw, W, correction(p, raw) if second else None)


def correction(p: beam_strain.BeamConstants, e: Array) -> Array:
    """Q_k e (8, 8, n) of raw deformations (or their rates) e (8, n)."""
    Q = beam_strain.products(p.Q, p.g * e)
    Q[0] += p.f * _einsum("ij,j...->i...", _SHORTENING, e)
    return Q


class WarpingRates(NamedTuple):
    """Rates of the state with velocities v at zero accelerations."""

    beam: beam_strain.BeamRates
    raw2: Array  # (8, n)


def rates(c: WarpingState, v: Array) -> WarpingRates:
    """Rates for v (16, n)."""
    beam = beam_strain.rates(c.beam, v[BEAM])
    return WarpingRates(beam, _eight(beam.raw2))


def rate_rows(c: WarpingState, r: WarpingRates) -> Array:
    """[v, .] of the raw deformations, (8, 2, 8, n)."""
    return _extended(beam_strain.rate_rows(c.beam, r.beam))


def second_rate_rows(c: WarpingState, r: WarpingRates) -> Array:
    """Third derivative [v, v, .], (8, 2, 8, n)."""
    return _extended(beam_strain.second_rate_rows(c.beam, r.beam))


def hessian(c: WarpingState, sigma: Array, out: Array) -> None:
    """Write sum_k sigma_k d2(e_k) (16, 16, n)."""
    p, tail = c.beam.p, sigma.shape[1:]
    tau = sigma if c.Q is None else sigma + _einsum("kj...,k...->j...", c.Q, sigma)
    beam = np.array(tau[:6])
    beam[1] += tau[6] - tau[7]
    H = np.zeros((14, 14, *tail), np.result_type(c.W, sigma))
    beam_strain.hessian(c.beam, beam, H)
    out[...] = 0.0
    out[np.ix_(BEAM, BEAM)] = H
    if c.Q is not None:
        weights = beam_strain.products(p.Q.swapaxes(0, 2), p.g * sigma)
        weights += p.f * sigma[0] * _SHORTENING.reshape(8, 8, *(1,) * len(tail))
        V = np.empty((8, 16, *tail), c.W.dtype)
        beam_strain.put(c.W, V)
        out += _einsum("ji...,jk...->ik...", V, _einsum("jk...,ki...->ji...", weights, V))
