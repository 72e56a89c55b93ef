"""Spatial beam, keyword BEAM (theory-spatial.md section 3).

Coordinates x_p (3), lambda_p (4), x_q (3), lambda_q (4) in m and 1; deformations elongation, torsion, bending
in the local x'z' plane at p, q and in the x'y' plane at p, q, all in m. The deformations are in
`beam_strain`, the translational inertia in `beam_inertia`; this module reads the input values and gives the
stiffness and the limits of the theory.
"""

from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import ElementGroup, Family, GeometryError, Trouble
from spacar.elements.planar.chord import short_troubles
from spacar.elements.rotations.local_frames import chord_frames, chords, rows, section_tensor
from spacar.elements.rotations.rotation import _CROSS, parameters_of_frame
from spacar.elements.spatial import beam_strain as strain_of
from spacar.elements.spatial.beam_inertia import (
    HERMITE_MASS,
    LineConstants,
    LineState,
    line_constants,
    line_force,
    line_gradient,
    line_mass,
    line_state,
)


def angle_of_error(error: float) -> float:
    """Angle a [rad] at which the sine measure has this relative error: with e = l0 sin a the couple is proportional to
    sin a cos a instead of a, so that 1 - sin(2a)/(2a) = error. Newton's iteration from the first term of the series.
    """
    y = (6.0 * error) ** 0.5
    for _ in range(8):
        y -= (np.sin(y) - (1.0 - error) * y) / (np.cos(y) - (1.0 - error))
    return float(y / 2.0)


LARGE_ANGLE = angle_of_error(0.1)  # bending or twist of one element: 22.5 degrees
LIMIT_ANGLE = np.radians(85.0)  # the sine measures have no equilibrium at and beyond 90 degrees
_UNIT = HERMITE_MASS.item(0, 0) / 156.0  # of the coefficients of the inertia: 1/420


class SpatialBeamConfiguration(NamedTuple):
    """Deformation state and, if the group has mass, the inertia state."""

    strain: Any
    line: Any


class SpatialBeam(Family):
    """All BEAM elements of a model. Raises GeometryError for zero length and impossible direction vectors."""

    definition = "beam"
    n_coordinates = 14
    frame_p: Array
    frame_q: Array
    data: Array
    n_deformations = 6
    position_rows = (0, 1, 2, 7, 8, 9)
    start: Array | None = None  # deformations of tubes at the start
    _position_index = np.array(position_rows)
    _of: ClassVar[Any] = strain_of  # the module of the deformations
    _of_beam: ClassVar[Any] = slice(None)  # coordinates that a BEAM has

    def __init__(self, group: ElementGroup) -> None:
        n = self._chords(group)
        direction, f1 = statement_values(group)
        frame = chord_frames(n, direction)
        self._build(group, frame, frame, f1)
        self._set_mass(group.em[:, 0], group.em[:, 1:5])

    def _chords(self, group: ElementGroup) -> Array:
        """Set the lengths; directions (3, n) from p to q."""
        positions = group.x0.take(self._position_index, 0)
        self.length, n = chords(positions[3:] - positions[:3], positions)
        return n

    def _build(self, group: ElementGroup, frame_p: Array, frame_q: Array, f1: Array) -> None:
        """Constants of the deformations for frames (3, 3, n) at both ends and couplings f1 (n,) [m^2]."""
        self.keyword, self.numbers = group.keyword, group.numbers
        self._frames = frame_p, frame_q
        self.frame_p = rows(frame_p)
        self.frame_q = self.frame_p if frame_q is frame_p else rows(frame_q)
        self.data = f1[:, None]
        self._nonlinear = group.nonlinear
        self._estiff, self._edamp = group.estiff, group.edamp

    def _set_mass(self, mass: Array, section: Array) -> None:
        """Mass (n,) and inertia of the section (n, 4) per length [kg/m, kg m]."""
        self._mass, self._section = mass, section
        self.has_mass = bool(np.count_nonzero(mass))

    # Of the functions below; the engine has its own, and a compiled run does not make them.
    @cached_property
    def _second(self) -> bool:
        return bool(self._nonlinear.any())

    @cached_property
    def constants(self) -> strain_of.BeamConstants:
        """Those of the deformations."""
        assert self.data is not None
        alike = not np.count_nonzero(self._estiff[:, 4:6])
        Q = self._of.correction_coefficients(np.ones((2, 1)) if alike else self.shear)
        return strain_of.beam_constants(*self._frames, self.length, self.data[:, 0], self._nonlinear, Q)

    @property
    def shear(self) -> Array:
        """(2, n) factors 1/(1 + Phi_z), 1/(1 + Phi_y) of the antisymmetric bending."""
        return np.asarray(1.0 / (1.0 + 12.0 * self._estiff[:, 4:6].T / self.length**2))

    @cached_property
    def line(self) -> LineConstants:
        """Those of the translational inertia."""
        axis_p, axis_q = (frame[:, 0] for frame in self._frames)
        return line_constants(axis_p, axis_q, self.length, self._mass)

    def parameters(self) -> Array:
        """Length, start frames at the ends, the turn between them, constants of strain, mass, shear; start values."""
        unit = _UNIT * (self._mass * self.length)
        rows = np.zeros((34, self.n), np.result_type(self.length, self.frame_p, self.data, unit, self.shear))
        rows[0], rows[1:10], rows[10:19], rows[19] = self.length, self.frame_p.T, self.frame_q.T, 1.0
        own = np.flatnonzero((self.frame_p != self.frame_q).any(1))  # curved tubes
        if own.size:
            frames = (of[own].reshape(-1, 3, 3) for of in (self.frame_q, self.frame_p))
            turned = parameters_of_frame(np.einsum("nai,naj->ijn", *frames))
            rows[19:23, own] = np.where(turned[0] < 0.0, -turned, turned)
        rows[23], rows[24], rows[25], rows[26:28] = self.data[:, 0], self._nonlinear, unit, self.shear
        if self.start is not None:
            rows[28:] = self.start
        return rows

    # -- deformations --------------------------------------------------------------------------------------
    def strain(self, x: Array, branch: Array, e: Array, V: Array) -> SpatialBeamConfiguration:
        c = self._of.state(self.constants, x, self._second)
        e[...] = c.raw if c.Q is None else c.raw + 0.5 * np.einsum("kj...,j...->k...", c.Q, c.raw)
        strain_of.put(strain_of.corrected(c.Q, c.W), V)
        return SpatialBeamConfiguration(c, self._line_state(x))

    def _line_state(self, x: Array) -> LineState | None:
        return line_state(self.line, x[self._of_beam]) if self.has_mass else None

    def convective_strain(self, c: SpatialBeamConfiguration, v: Array, out: Array) -> None:
        of, state = self._of, c.strain
        raw2 = of.rates(state, v).raw2
        out[...] = strain_of.second_order(state.Q, raw2)
        if state.Q is not None:
            raw1 = strain_of.raw_rate(state, v)
            out += np.einsum("kj...,j...->k...", of.correction(state.p, raw1), raw1)

    def gradient_rate(self, c: SpatialBeamConfiguration, v: Array, out: Array) -> None:
        of, state = self._of, c.strain
        W = strain_of.corrected(state.Q, of.rate_rows(state, of.rates(state, v)))
        if state.Q is not None:
            W = W + strain_of.times_rows(of.correction(state.p, strain_of.raw_rate(state, v)), state.W)
        strain_of.put(W, out)

    def rate_gradient(self, c: SpatialBeamConfiguration, v: Array, out: Array) -> None:
        of, state = self._of, c.strain
        rates = of.rates(state, v)
        W = strain_of.corrected(state.Q, of.second_rate_rows(state, rates))
        if state.Q is not None:
            W = W + strain_of.times_rows(of.correction(state.p, rates.raw2), state.W)
            Q1 = of.correction(state.p, strain_of.raw_rate(state, v))
            W = W + 2.0 * strain_of.times_rows(Q1, of.rate_rows(state, rates))
        strain_of.put(W, out)

    def geometric_stiffness(self, c: SpatialBeamConfiguration, sigma: Array, out: Array) -> None:
        self._of.hessian(c.strain, sigma, out)

    # -- stresses ------------------------------------------------------------------------------------------
    def stiffness(self) -> tuple[Array, Array]:
        """S [N/m] and S_d [N s/m] of section 3.5; the shear parameters act in both."""
        shear = 12.0 * self._estiff[:, 4:6] / self.length[:, None] ** 2
        return _beam_matrix(self._estiff, shear, self.length), _beam_matrix(self._edamp, shear, self.length)

    # -- inertia -------------------------------------------------------------------------------------------
    def mass(self, c: SpatialBeamConfiguration, out: Array) -> None:
        line_mass(c.line, out)

    def inertia_force(self, c: SpatialBeamConfiguration, v: Array, a: Array | None) -> Array:
        return line_force(c.line, v, a)

    def inertia_gradient(self, c: SpatialBeamConfiguration, v: Array, a: Array) -> tuple[Array, Array]:
        return line_gradient(c.line, v, a)

    def orientation_inertia(self) -> tuple[tuple[int, Array], ...]:
        if not np.count_nonzero(self._section):
            return ()
        half = 0.5 * self.length
        return tuple(
            (row, section_tensor(frame, self._section, half)) for row, frame in zip((3, 10), self._frames, strict=True)
        )

    # -- limits --------------------------------------------------------------------------------------------
    def troubles(self, c: SpatialBeamConfiguration, e: Array, sigma: Array) -> list[Trouble]:
        """Collapsed length; too large angles of bending (end tangent against chord) or twist."""
        state = c.strain
        found = short_troubles(state.l, self.length)
        for what, angle in _angles(state, self.length):
            for k in np.flatnonzero(angle > LARGE_ANGLE):
                fatal = bool(angle[k] > LIMIT_ANGLE)
                limit = (
                    "beyond what its deformation can measure" if fatal else "which one element cannot represent well"
                )
                text = f"{what} by {np.degrees(angle[k]):.0f} degrees, {limit}; use more elements"
                found.append(Trouble(int(k), text, fatal))
        return found


def statement_values(group: ElementGroup) -> tuple[list[tuple[float, ...] | None], Array]:
    """Direction vectors (or None) and torsion-elongation parameters f1 (n,) [m^2] of the statements."""
    counts = set(map(len, group.geometry))
    if not counts <= {0, 1, 3, 4}:
        k, count = next((k, len(v)) for k, v in enumerate(group.geometry) if len(v) not in (0, 1, 3, 4))
        raise GeometryError(k, f"{count} values behind the nodes: give a direction (3), a coupling (1) or both")
    directions = [values[:3] if len(values) >= 3 else None for values in group.geometry]
    f1 = np.zeros(group.n, group.x0.dtype)
    if 1 in counts or 4 in counts:
        f1[:] = [values[-1] if len(values) in (1, 4) else 0.0 for values in group.geometry]
    return directions, f1


def _beam_matrix(rigidity: Array, shear: Array, l0: Array) -> Array:
    """(6, 6, n) from EA, GIt, EIy, EIz (n, >=4) and the shear numbers Phi_z, Phi_y (n, 2)."""
    S = np.zeros((6, 6, len(l0)), rigidity.dtype)
    if not np.count_nonzero(rigidity):  # rigid beams, or no damping
        return S
    S[0, 0] = rigidity[:, 0] / l0
    S[1, 1] = rigidity[:, 1] / l0**3
    for j in range(2):
        phi, first = shear[:, j], 2 + 2 * j
        k = rigidity[:, 2 + j] / ((1.0 + phi) * l0**3)
        S[first, first] = S[first + 1, first + 1] = (4.0 + phi) * k
        S[first, first + 1] = S[first + 1, first] = (-2.0 + phi) * k
    return S


def _angles(state: strain_of.BeamState, l0: Array) -> list[tuple[str, Array]]:
    """Angles [rad] (n,) between the end tangents and the chord, and of the twist, with a verb each.

    Of unit Euler parameters, as solved positions have them, U_s = -+ l0 z', +- l0 y' at the ends s, so that
    x'_s.n = n.(U_0s x U_1s)/l0^2. With the relative Euler parameters mu, the cosine of the twist is
    mu0^2 - mu_x^2 and its sine 2 mu0 mu_x, both times a number below one.
    """
    bent = np.einsum("ijk,i...,sj...,sk...->s...", _CROSS, state.n, *state.U) / l0**2
    chord = np.arccos(np.clip(bent, -1.0, 1.0))
    mu0, mu_x = state.twist[0], state.twist[1] / (2.0 * l0)
    twist = np.abs(np.arctan2(2.0 * mu0 * mu_x, mu0**2 - mu_x**2))
    return [("is bent at p", chord[0]), ("is bent at q", chord[1]), ("is twisted", twist)]
