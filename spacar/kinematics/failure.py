"""Failures of the position problem, said so that a user can act: what, where, how far, what to try."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES
from spacar.errors import AnalysisError
from spacar.kinematics.advice import KEEPS
from spacar.kinematics.constraint_matrices import ZERO, ConstraintMatrices, entries_of, scaled_difference_matrix
from spacar.kinematics.diagnosis import Diagnosis, diagnose
from spacar.kinematics.element_sweep import ElementSweep
from spacar.linear_systems import SingularMatrixError
from spacar.mechanism.mechanism import Mechanism

SHORT = 1e-6  # length over the undeformed one from which an element counts as collapsed
# Smallest over largest singular value at the last iterate: one that was zero (below ZERO of `diagnosis`) at the
# reference configuration has grown by no more than the square root of that limit.
NEARLY = ZERO**0.5
HELD = 1e-6  # largest part of stresses that hold each other on what moves: half of the digits, as positions have
POOR = 1e-3  # least part of the stress of a row that is proposed for release
LARGEST_DIAGNOSED = 1000  # unknowns; a singular value decomposition of more would take longer than the analysis


def count_failure(kinematics: ConstraintMatrices) -> AnalysisError:
    diagnosis = diagnose(kinematics.mechanism)
    rows, columns = diagnosis.n_rows, diagnosis.n_columns
    if rows == columns:
        rows, columns = len(kinematics.h), len(kinematics.c)
    kind = (
        "over-constrained: release deformations (RLSE)"
        if rows > columns
        else "under-constrained: declare more degrees of freedom"
    )
    solved = ", with --release solves it" if any(p.effect in KEEPS for p in diagnosis.advice) else ""
    text = (
        f"ill-defined mechanism: {rows} fixed, prescribed and dynamic deformations for {columns} calculable coordinates"
        f" (difference {rows - columns:+d}), {kind}; {_candidates(diagnosis)}; `spacar 0` lists all{solved}"
    )
    return AnalysisError(text, "mechanism.count", diagnosis=diagnosis)


def explained(kinematics: ConstraintMatrices, x: Array, *about: Any) -> AnalysisError:
    return (position_failure if about[1:] else singular_failure)(kinematics, x, *about)


def singular_failure(kinematics: ConstraintMatrices, x: Array, error: SingularMatrixError) -> AnalysisError:
    diagnosis = diagnose(kinematics.mechanism, x)
    text = (
        f"the position cannot be determined: {error}; {_candidates(diagnosis)};"
        " choose other degrees of freedom, or the mechanism is in a singular position"
    )
    return AnalysisError(text, "position.singular", diagnosis=diagnosis)


def position_failure(
    kinematics: ConstraintMatrices, x: Array, residual: Array, history: list[float], iteration: int
) -> AnalysisError:
    """Newton's iteration did not converge. residual (h,) belongs to x, or to the last trial after `history`.

    What is printed is scaled like the history: a deformation that is a length is divided by the size of the mechanism.
    """
    numbering, failure = kinematics.numbering, partial(AnalysisError, iterations=iteration, history=history)
    collapsed = collapse(kinematics)
    if collapsed:
        return failure(collapsed, "element.range")
    values = np.where(np.isfinite(residual), np.abs(residual), np.inf) / kinematics.h_scale
    norm = float(values.max(initial=0.0))
    worst = int(kinematics.h[int(np.argmax(values))]) if len(values) else 0
    where, smallest, largest, D = "", np.nan, np.nan, np.zeros((0, 0))
    if len(kinematics.c) <= LARGEST_DIAGNOSED:
        entries = entries_of(kinematics.sweep)
        D = scaled_difference_matrix(kinematics.mechanism, entries, kinematics.h, kinematics.c)
    if np.isfinite(D).all() and D.size:
        _, s, right = np.linalg.svd(D)
        smallest, largest = float(s[-1]), float(s[0])
        hardest = int(kinematics.c[int(np.argmax(np.abs(right[-1])))])
        where = f", motion that is hardest to determine: {numbering.x_name(hardest)}"
    # An iterate that met the constraints to rounding r and was left had a correction r/s that bends them by more than
    # r: the root is not a single one (kinematics/constraint_matrices.py).
    given = kinematics.target[kinematics.h]
    left = min(history, default=np.inf) <= kinematics.rounding(kinematics.x, given)  # iterates may be far from there
    if left or norm <= kinematics.rounding(x, given):
        text = (
            "singular position: the constraints are met to rounding, but the coordinates are not determined (smallest"
            f" singular value {smallest:.3g}{where}); a dead point: choose other degrees of freedom"
        )
        return failure(text, "position.singular")
    if smallest < NEARLY * largest:
        found = _singular_choice(kinematics.mechanism)
        if found:
            return failure(found, "position.singular")
    text = (
        f"no convergence of the position after {iteration} iterations: scaled residual {norm:.2g}"
        f" (history {_shown(history if history and history[-1] == norm else [*history, norm])}),"
        f" worst deformation {numbering.e_name(worst)}, smallest singular value {smallest:.3g}{where};"
        " try a smaller step, other degrees of freedom, or start values that can be reached"
    )
    return failure(text, "position.no-convergence")


def _singular_choice(mechanism: Mechanism) -> str:
    """The cause in words, when the choice of degrees of freedom is singular at the reference configuration already;
    otherwise "".
    """
    diagnosis = diagnose(mechanism)
    if not (diagnosis.over or diagnosis.under):
        return ""
    return (
        "singular choice of degrees of freedom: at the reference configuration the fixed, prescribed and dynamic"
        f" deformations and the given coordinates leave {diagnosis.under} motion{'s' * (diagnosis.under != 1)} free and"
        f" constrain {diagnosis.over} twice; {_candidates(diagnosis)}; choose other degrees of freedom"
        " (DYNE, DYNX, INPUTX, RLSE); `spacar 0` lists all"
    )


def _shown(history: list[float]) -> str:
    """The residuals of the iteration up to the last one; of a long history the beginning and the end."""
    words = [f"{r:.2g}" for r in history]
    return " ".join(words if len(words) <= 6 else [*words[:3], "...", *words[-3:]])


def collapse(kinematics: ConstraintMatrices) -> str:
    """Which element has no length left, in words: one that is asked for a length of nearly zero or less, or whose
    deformations are no numbers at the last iterate. Empty when there is none."""
    sweep = kinematics.sweep
    for batch in sweep.strained:
        family = batch.family
        kind = ELEMENT_TYPES.get(family.keyword)
        if kind is None:  # normalizations
            continue
        if kind.axial:
            wanted = kinematics.target[batch.e[0]] + family.length
            asked = np.isin(batch.e[0], kinematics.h) & (wanted <= SHORT * family.length)
            for k in np.flatnonzero(asked):
                return (
                    f"element {family.numbers[k]} ({family.keyword}) has collapsed: its length would have to be"
                    f" {wanted[k]:.3g} m, undeformed {family.length[k]:.3g} m; limit the motion of its ends or its"
                    " prescribed elongation"
                )
        for k in np.flatnonzero(~np.isfinite(sweep.e[batch.e]).all(axis=0)):
            return (
                f"element {family.numbers[k]} ({family.keyword}) has collapsed: its end nodes have met and its"
                " deformations are undefined; limit the motion, or release the element (RLSE)"
            )
    return ""


def _candidates(diagnosis: Diagnosis) -> str:
    parts = []
    if diagnosis.releases:
        parts.append("candidates to release: " + ", ".join(f"{p.name} ({p.text})" for p in diagnosis.advice))
    if diagnosis.freedoms:
        parts.append("free motions at: " + ", ".join(diagnosis.freedoms))
    if not parts and len(diagnosis.singular):
        parts.append(f"smallest singular value {diagnosis.singular[-1]:.3g} of {diagnosis.singular[0]:.3g}")
    return "; ".join(parts) or "no candidates"


def other_release(mechanism: Mechanism, x: Array) -> str:
    """Advice where a motion stopped near x (nx,) because a release became singular; empty where that is not the cause.

    A mechanism that is over-constrained and moves all the same (Bricard's) has a release that does not move: it and the
    given rows hold each other with stresses u, u^T V = 0 in every position. The release determines the motion while its
    own u is not zero; so does that of any fixed row in its place. Proposed is the fixed row whose u, relative to the
    largest one, is farthest from zero both at the start and here.
    """
    n = mechanism.numbering
    rows, columns, first = n.velocity_equations, n.velocity_unknowns, n.x_class["fixed"].stop
    if len(rows) > LARGEST_DIAGNOSED:
        return ""
    gradients = [
        ElementSweep.at(mechanism, at).gradient() * mechanism.scale / mechanism.deformation_scale[:, None]
        for at in (mechanism.x0, x)
    ]
    fixed = np.arange(n.e_class["fixed"].start, n.normalized.start)
    best = POOR, -1, -1
    for r in range(n.e_class["dynamic"].stop, n.ne):
        held = []
        for V in gradients:
            chosen = np.append(rows, r)
            u = np.zeros(n.ne)
            u[chosen] = np.linalg.svd(V[np.ix_(chosen, columns)])[0][:, -1]
            u /= np.abs(u).max()
            moved = np.abs(u[n.q_e]).max(initial=0.0), np.abs(u @ V)[first:].max(initial=0.0)
            held.append(np.abs(u) if max(moved) < HELD else np.zeros(n.ne))
        both = np.minimum(*held)
        if held[1][r] < 0.5 * held[0][r] and len(fixed) and both[fixed].max() > max(best[0], held[1][r]):
            best = float(both[fixed].max()), r, int(fixed[np.argmax(both[fixed])])
    if best[1] < 0:
        return ""
    old, new = (" ".join(map(str, ("RLSE", *n.e_owner(row)))) for row in best[1:])
    return f"; the release {old} becomes singular here: give {new} in its place"
