"""Vibration and buckling modes of a result: eigenvalue, vector of the degrees of freedom, and its motion in x.

Vibration: eigenvectors of the state matrix of (q, dq/dt), from the `.sbm` (eigval, eigvre, eigvim), or where the
analysis does not store them (3, 4, 9) from its matrices: with Q = C0 + D0 and K = K0 + N0 + G0

    d(q_k)/dt = Bk0 q_k + Ak0 u,   M0 du/dt = -Q u - K q_k              (reference/files.md section 5)

Both of a pair (conjugate, or plus and minus without damping) are one mode. Order: unstable modes first, the fastest
growing one as mode 1, then the others by the modulus of their eigenvalue, zero modes last.
Buckling: the order of lmult.
Motion: dx times the vector in the columns of the dynamic and kinematic degrees of freedom (files.md section 3).

Over- and under-constraints after mode 0, from the stored derivative of the deformations (theory-system.md 1.1).

The part of bigd with the rows fixed, input, dynamic and the columns calculable, kinematic is made dimensionless
(lengths by the size of the mechanism) and decomposed: left null vectors are stresses that no load explains, right
null vectors are motions that no deformation feels. Singular values below sqrt(eps) times the largest count as zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from spacar_formats.vibration import modes_of_sparse_system, modes_of_stored_matrices, shown_order

from spacar.arrays import EPS, Array
from spacar.deck import ELEMENT_TYPES
from spacar.errors import Report
from spacar.kinematics.null_space import norm_estimate, null_space
from spacar_drawing.picture_source import PictureSource, matrices_beside
from spacar_drawing.scene import Scene

if TYPE_CHECKING:
    from scipy.sparse import csr_array

ZERO = sqrt(EPS)


@dataclass(frozen=True)
class Redundancy:
    """over (over-constraints, elements): share of every element number (squares, sum 1 with the normalizations);
    under (under-constraints, nx): motions."""

    over: Array
    under: Array


def stored_gradient(source: PictureSource, step: int) -> Array | csr_array:
    """bigd (ne, nx) of a step, sparse where it is stored as `bigds`. UsageError when neither is there."""
    entries = source.read("bigds", step)
    if entries is None:
        return source.get("bigd", step)
    from scipy.sparse import coo_array

    rows, columns = entries[:, :2].T.astype(int) - 1
    size = int(source.scene.nep.sum()), int(source.scene.nxp.sum())
    return coo_array((entries[:, 2], (rows, columns)), size).tocsr()


def redundancy(scene: Scene, bigd: Array | csr_array, extent: float) -> Redundancy:
    """The constraint analysis of a configuration; bigd (ne, nx), dense or sparse, extent: size of the mechanism [m]."""
    nx, ne = int(scene.nxp.sum()), int(scene.nep.sum())
    column_scale, row_scale = np.ones(nx), np.ones(ne)
    column_scale[scene.place_columns] = extent
    owner = np.full(ne, -1)
    for e in scene.elements:
        for mode, (_, unit) in enumerate(ELEMENT_TYPES[e.keyword].modes, 1):
            i = scene.le[e.number - 1, mode - 1] - 1
            owner[i] = e.number - 1
            if unit == "m":
                row_scale[i] = extent
    rows = int(scene.nep[0] + scene.nep[2] + scene.nep[3])
    fixed = int(scene.nxp[0])
    columns = np.r_[fixed : fixed + scene.nxp[1], nx - scene.nxp[4] : nx]
    if not rows or not len(columns):
        return Redundancy(np.zeros((0, len(scene.keywords))), np.zeros((0, nx)))
    if isinstance(bigd, np.ndarray):
        D = (bigd * column_scale / row_scale[:, None])[:rows][:, columns]
        left, s, right = np.linalg.svd(D)
        rank = int(np.sum(s > ZERO * s[0]))
        stresses, motions = left[:, rank:], right[rank:].T
    else:
        part = bigd.multiply(column_scale).multiply(1.0 / row_scale[:, None]).tocsr()[:rows][:, columns]
        size = norm_estimate(part)
        stresses, motions = null_space(part.T.tocsr(), size, ZERO)[0], null_space(part, size, ZERO)[0]
    over, mine = np.zeros((stresses.shape[1], len(scene.keywords))), owner[:rows] >= 0
    np.add.at(over.T, owner[:rows][mine], stresses[mine] ** 2)
    under = np.zeros((motions.shape[1], nx))
    under[:, columns] = motions.T * column_scale[columns]
    return Redundancy(over, under)


SHARE, MOST_TURN = 0.12, 0.6  # of a motion that is drawn: displacement over the extent; rotation [rad]
SAME = 1e-6  # eigenvalues that differ less, relative to the largest, belong to one pair


@dataclass(frozen=True)
class ModeShape:
    """One mode. `vector` (n degrees of freedom,) complex, norm 1, largest entry real; `motion` (nx,) = dx vector."""

    number: int
    kind: str  # "vibration" or "buckling"
    value: complex  # eigenvalue [1/s], or load multiplier
    vector: NDArray[np.complex128]
    motion: NDArray[np.complex128]

    @property
    def is_complex(self) -> bool:
        """The points do not all move in phase."""
        size = np.max(np.abs(self.motion), initial=0.0)
        return bool(np.max(np.abs(self.motion.imag), initial=0.0) > 1e-6 * size)

    @property
    def oscillates(self) -> bool:
        return self.kind == "buckling" or abs(self.value.imag) > 1e-9 * abs(self.value)

    @property
    def label(self) -> str:
        name = f"{self.kind} mode {self.number}"
        if self.kind == "buckling":
            return f"{name}   load multiplier {self.value.real:.6g}".replace("-", "\N{MINUS SIGN}")
        size, real = abs(self.value), self.value.real
        if not self.oscillates:
            word = "unstable" if real > 0 else "decaying"
            rate = f"\N{GREEK SMALL LETTER LAMDA} = {real:.5g} 1/s ({word})"
            return f"{name}   {rate if size else 'frequency zero'}"
        omega = abs(self.value.imag)
        text = f"{name}   f = {omega / (2 * np.pi):.5g} Hz, \N{GREEK SMALL LETTER OMEGA} = {omega:.5g} rad/s"
        if abs(real) > 1e-9 * size:
            text += f", damping ratio {-real / size:.3g}" + (" (unstable)" if real > 0 else "")
        return text


def dynamic_columns(header: Any) -> NDArray[np.int64]:
    """Columns of dx that are free to move: dynamic x, dynamic e, kinematic; in mode 3 the prescribed ones instead."""
    nxp, nep = np.ravel(header["NXP"]).astype(int), np.ravel(header["NEP"]).astype(int)
    xi, xd, ei, ed = nxp[2], nxp[3], nep[2], nep[3]
    ndof, nk = xi + xd + ei + ed, nxp[4] + nep[4]
    if not xd + ed:
        return np.arange(ndof + nk)
    return np.r_[xi : xi + xd, xi + xd + ei : ndof, ndof : ndof + nk]


def modes_of(source: PictureSource, kind: str, step: int) -> list[ModeShape]:
    """The "vibration" or "buckling" modes of a step. Raises UsageError."""
    with matrices_beside(source.name, source.header) as matrices:
        return (vibration_modes if kind == "vibration" else buckling_modes)(source, matrices, step)


def vibration_modes(source: PictureSource, matrices: Any, step: int) -> list[ModeShape]:
    """All vibration modes of a step, in the order of the module. Raises UsageError when dx is missing."""

    def get(name: str) -> Array:
        return np.atleast_2d(np.asarray(matrices.get(name, step), float))

    shapes, n = None, 0
    if matrices.has("eigvre"):
        values = get("eigval") @ np.array([1.0, 1.0j])
        vectors = get("eigvre") + 1j * get("eigvim")
        if matrices.has("eigxre"):  # of a large model without dx
            shapes, n = get("eigxre") + 1j * get("eigxim"), len(vectors) // 2
    else:
        if matrices.has("m0"):
            found = modes_of_stored_matrices(matrices, step, Report())
        else:
            found = modes_of_sparse_system(matrices, step, Report(), nx=int(np.ravel(source.header["NX"])[0]))
        values, vectors, shapes, n = found.values, found.vectors, found.motions, found.n_positions
    if shapes is None:
        motion = source.get("dx", step)[:, dynamic_columns(source.header)]
        n = motion.shape[1]
        shapes = motion @ vectors[:n]
    modes: list[ModeShape] = []
    seen: list[tuple[complex, NDArray[np.complex128]]] = []
    largest = np.max(np.abs(values), initial=0.0) or 1.0
    for i in shown_order(values):
        vector = vectors[:n, i].astype(complex)
        size = np.linalg.norm(vector)
        if size < 1e-9 * max(float(np.linalg.norm(vectors[:, i])), 1e-300) or not np.isfinite(shapes[:, i]).all():
            continue  # only a velocity: the other vector of a double zero eigenvalue; or a motion that is not known
        pivot = vector[np.argmax(np.abs(vector))]
        factor = np.abs(pivot) / pivot / size
        vector, shape = vector * factor, shapes[:, i] * factor
        if any(_pair(values[i], v, largest) and abs(abs(np.vdot(w, vector)) - 1) < 1e-6 for v, w in seen):
            continue
        value = values[i] if abs(values[i]) > SAME * largest else 0.0
        seen.append((complex(values[i]), vector))
        if value.imag < 0:
            value, vector, shape = np.conj(value), np.conj(vector), np.conj(shape)
        modes.append(ModeShape(len(modes) + 1, "vibration", complex(value), vector, shape))
    return modes


def _pair(a: complex, b: complex, largest: float) -> bool:
    if abs(a) < SAME * largest and abs(b) < SAME * largest:
        return True
    apart = min(abs(a - b), abs(a - np.conj(b)), abs(a + b), abs(a + np.conj(b)))
    return apart < 1e-3 * SAME * largest + SAME * abs(a)


def buckling_modes(source: PictureSource, matrices: Any, step: int) -> list[ModeShape]:
    """All buckling modes of a step with a finite load multiplier."""
    multipliers = np.ravel(matrices.get("lmult", step)).astype(float)
    vectors = np.asarray(matrices.get("bmode", step), float).reshape(-1, len(multipliers))
    if matrices.has("bmodex"):  # of a large model without dx
        shapes = np.asarray(matrices.get("bmodex", step), float).reshape(-1, len(multipliers))
    else:
        shapes = source.get("dx", step)[:, dynamic_columns(source.header)][:, : len(vectors)] @ vectors
    modes = []
    for i, multiplier in enumerate(multipliers):
        vector = vectors[:, i]
        size = np.linalg.norm(vector)
        if np.isfinite(multiplier) and np.isfinite(size) and size > 0 and np.isfinite(shapes[:, i]).all():
            unit = (vector / size).astype(complex)
            modes.append(ModeShape(i + 1, "buckling", complex(multiplier), unit, (shapes[:, i] / size).astype(complex)))
    return modes


def suitable_factor(scene: Scene, motion: NDArray, extent: float) -> float:
    """The factor at which a motion (nx,) moves at most SHARE of the extent [m] and no rotation exceeds MOST_TURN."""
    amplitude = np.abs(motion)
    moves = np.max(amplitude[scene.place_columns], initial=0.0)
    places = scene.lnp[scene.orientation_nodes - 1, : 1 if scene.planar else 4] - 1
    turns = np.max(amplitude[places], initial=0.0) * (1.0 if scene.planar else 2.0)
    bounds = [SHARE * extent / moves] if moves > 1e-12 * max(turns * extent, moves) and moves else []
    bounds += [MOST_TURN / turns] if turns else []
    return min(bounds, default=1.0)
