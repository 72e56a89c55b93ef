"""Over- and under-constraints: singular value decomposition of the scaled difference matrix (theory-system.md 1.1).

The part of dD/dx with the rows fixed, input and dynamic and the columns calculable (and kinematic) must be square and
regular. Lengths and rotations are made comparable first: with L the size of the mechanism, a column of a position is
multiplied by L and a row of a deformation in metres divided by L. Singular values below sqrt(eps) s_1 count as zero.

Left null vectors are over-constraints: combinations of deformations that no motion can change independently, so that
the stresses along them are undetermined. Right null vectors are under-constraints: motions of the calculable
coordinates that no deformation feels. A large matrix stays sparse, and only its null spaces are computed
(`null_space`). Where there are several constraints of a kind, releases (or new degrees of freedom) are proposed one
after the other: the largest component in the null space, which is then projected on the rest. Releases are taken
from the deformations whose release keeps the physics as long as these can help, then from rigid ones that the others
hold as well, at last from those that put a hinge into the model (`advice`).
"""

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array, Index
from spacar.kinematics.advice import (
    ELASTIC,
    FLEXIBLE,
    FREE,
    HINGE,
    NAMED,
    NONE,
    PART,
    PRESCRIBED,
    REDUNDANT,
    SMALL,
    OverconstraintPart,
    effects,
    paste_lines,
)
from spacar.kinematics.constraint_matrices import ZERO, entries_of, scaled_difference_matrix
from spacar.kinematics.element_sweep import ElementSweep
from spacar.kinematics.null_space import LARGEST_DECOMPOSED, norm_estimate, null_space
from spacar.kinematics.self_stress import scaled_part
from spacar.mechanism.mechanism import Mechanism

WHOLE = 0.01  # smallest singular value of the null vectors in the rows of an element that is released as a whole
SHOWN = 1e-6  # smaller shares are not listed
TIE = 9  # decimals of the weights: of equal weights the lowest number comes first, whatever the rounding


@dataclass(frozen=True)
class Diagnosis:
    """Result of the constraint analysis; names are those of the numbering, weights sum to 1 over all entries.

    over, under        numbers of over- and under-constraints
    deformations       ranked (weight, name) of what takes part in the over-constraints
    coordinates        ranked (weight, name) of what moves in the under-constraints
    releases           deformations whose release removes the over-constraints, one for each where possible
    parts, advice      the same as `deformations` (flexible ones first) and `releases`, with numbers and effects
    paste              lines for the input file that carry out the releases
    freedoms           coordinates to be made degrees of freedom (or supported), one per under-constraint
    singular           (k,) singular values, descending (of a large matrix the largest, and the smallest beside the
                       null space)
    condition          s_1/s_n, infinite if not square and regular
    """

    n_rows: int
    n_columns: int
    over: int
    under: int
    deformations: tuple[tuple[float, str], ...]
    coordinates: tuple[tuple[float, str], ...]
    releases: tuple[str, ...]
    freedoms: tuple[str, ...]
    singular: Array
    condition: float
    parts: tuple[OverconstraintPart, ...] = ()
    advice: tuple[OverconstraintPart, ...] = ()
    paste: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """The report, a sentence or a table row each."""
        lines = [
            f"constraints {self.n_rows}, calculable coordinates {self.n_columns}, condition number {self.condition:.6g}"
        ]
        if not self.over and not self.under:
            return [*lines, "the mechanism is neither over- nor under-constrained"]
        if self.over:
            lines.append(f"over-constrained {self.over} time{'s' * (self.over > 1)}; deformations that take part:")
            shown = [p for p in self.parts if p.effect != PART]
            lines += [f"  {p.share:8.4f}  {p.name}{f': {p.text}' if p.text else ''}" for p in shown]
            if rest := sum(p.share for p in self.parts if p.effect == PART):
                lines.append(f"  {rest:8.4f}  the other parts of divided beams")
            lines += [f"  suggestion: release {p.name} (RLSE): {p.text}" for p in self.advice]
            lines += ["lines for the input file:"] * bool(self.paste) + [f"  {line}" for line in self.paste]
        if self.under:
            lines.append(f"under-constrained {self.under} time{'s' * (self.under > 1)}; coordinates that move:")
            lines += [f"  {weight:8.4f}  {name}" for weight, name in self.coordinates]
            lines += [
                f"  suggestion: make {name} a degree of freedom (DYNX, INPUTX) or support it (FIX)"
                for name in self.freedoms
            ]
        return lines


def diagnose(mechanism: Mechanism, x: Array | None = None) -> Diagnosis:
    """Analyse the constraints at the configuration x (None: that of reference)."""
    numbering = mechanism.numbering
    rows, columns = numbering.velocity_equations, numbering.velocity_unknowns
    null_rows, null_columns, s, condition = _decomposed(mechanism, ElementSweep.at(mechanism, x), rows, columns)
    over, under = null_rows.shape[1], null_columns.shape[1]
    regular = not over and not under
    allowed = ~np.isin(columns, numbering.euler[0])  # lambda0 is no degree of freedom: the normalization determines it
    parts, advice, paste = _advice(mechanism, rows, null_rows, x) if over else ((), (), ())
    return Diagnosis(
        n_rows=len(rows),
        n_columns=len(columns),
        over=over,
        under=under,
        deformations=tuple((p.share, p.name) for p in parts),
        coordinates=_ranked(null_columns, [numbering.x_name(int(i)) for i in columns] if under else []),
        releases=tuple(p.name for p in advice),
        freedoms=tuple(numbering.x_name(int(columns[i])) for i in pick(null_columns, allowed)),
        singular=s,
        condition=condition if regular else float("inf"),
        parts=parts,
        advice=advice,
        paste=paste,
    )


def _decomposed(
    mechanism: Mechanism, sweep: ElementSweep, rows: Index, columns: Index
) -> tuple[Array, Array, Array, float]:
    """Left and right null space of the scaled matrix, singular values (see Diagnosis), condition if regular."""
    if max(len(rows), len(columns)) > LARGEST_DECOMPOSED:
        D = scaled_part(mechanism, sweep, rows, columns)
        size = norm_estimate(D)
        left, others = null_space(D.T.tocsr(), size, ZERO)
        right = null_space(D, size, ZERO)[0]
        return left, right, np.array([size, others[0]]), size / float(others[0])
    D = scaled_difference_matrix(mechanism, entries_of(sweep), rows, columns)
    if not D.size:
        return np.eye(len(rows)), np.eye(len(columns)), np.zeros(0), 1.0
    left, s, right = np.linalg.svd(D)
    rank = int(np.sum(s > ZERO * s[0]))
    return left[:, rank:], right[rank:].T, s, float(s[0] / s[-1]) if s[-1] > 0.0 else float("inf")


def _advice(
    mechanism: Mechanism, rows: Index, null: Array, x: Array | None
) -> tuple[tuple[OverconstraintPart, ...], tuple[OverconstraintPart, ...], tuple[str, ...]]:
    """What takes part in the over-constraints, what to release, and the lines for it."""
    numbering = mechanism.numbering
    effect, held = effects(mechanism, rows, x)
    shares = _shares(null)
    rank = np.where(effect == NONE, HINGE, effect)  # normalizations stand among the rigid ones, by their share
    order = np.lexsort((-shares, rank))

    beams = {parts[-1]: beam for beam, parts in mechanism.deck.divided.items()}

    def part(k: int) -> OverconstraintPart:
        i = int(rows[k])
        (element, mode), name = numbering.e_owner(i), numbering.e_name(i)
        if element in beams:
            name = f"{name.replace(str(element), str(beams[element]), 1)} (of its last part)"
        return OverconstraintPart(beams.get(element, element), mode, float(shares[k]), int(effect[k]), name)

    owner = np.array([numbering.e_owner(int(i))[0] for i in rows])
    chosen = _whole_elements(null, effect, np.where(rows < numbering.e_class["dynamic"].start, 0, owner))
    rest = null
    for k in chosen:
        rest = _without(rest, k)
    for kinds in ((FLEXIBLE,), (FREE,), (NAMED,), (REDUNDANT,), (ELASTIC, HINGE), (PRESCRIBED,)):
        # of the redundant ones those that the other rigid ones hold
        for k in pick(held if REDUNDANT in kinds else rest, np.isin(effect, kinds)):
            chosen.append(k)
            rest = _without(rest, k)
    advice = tuple(part(k) for k in chosen)
    lines = tuple(paste_lines(mechanism.deck, list(advice)))
    return tuple(part(k) for k in order if shares[k] > SHOWN), advice, lines


def _whole_elements(null: Array, effect: Index, owner: Index) -> list[int]:
    """Rows of elements all of whose dynamic deformations may be released and are determined by the null space: one
    after the other the element with the largest smallest singular value. owner (n,): 0 of rows that are not dynamic."""
    groups = {n: np.flatnonzero(owner == n) for n in np.unique(owner[effect == FLEXIBLE])}
    groups = {n: rows for n, rows in groups.items() if np.all(effect[rows] == FLEXIBLE)}
    rest, chosen = null, list[int]()
    while True:
        smallest = {
            n: round(float(np.linalg.svd(rest[rows], compute_uv=False)[-1]), TIE)
            for n, rows in groups.items()
            if 1 < len(rows) <= rest.shape[1]
        }
        best = max(smallest, key=smallest.__getitem__, default=0)
        if not smallest or smallest[best] < WHOLE:
            return chosen
        for k in groups.pop(best).tolist():
            chosen.append(k)
            rest = _without(rest, k)


def pick(null: Array, allowed: Array) -> list[int]:
    """One row per null vector: the largest allowed component, after which the null space is projected on the rest.

    Of components that are equal up to rounding the first is taken.
    """
    rest = null
    chosen: list[int] = []
    while rest.shape[1]:
        weight = np.where(allowed, np.sum(rest**2, axis=1), 0.0)
        largest = float(weight.max(initial=0.0))
        if largest < SMALL**2:
            break
        best = int(np.argmax(weight >= (1.0 - 10.0**-TIE) * largest))
        chosen.append(best)
        rest = _without(rest, best)
    return chosen


def _without(null: Array, row: int) -> Array:
    """The combinations of null vectors that vanish in a row: the null space when that row is released."""
    size = float(np.linalg.norm(null[row]))
    if not null.shape[1] or size < SMALL:
        return null
    return null @ np.linalg.svd(null[row][None, :] / size)[2][1:].T


def _ranked(null: Array, names: list[str]) -> tuple[tuple[float, str], ...]:
    if not null.shape[1]:
        return ()
    weight = _shares(null)
    order = np.argsort(-weight, kind="stable")
    return tuple((float(weight[i]), names[i]) for i in order if weight[i] > SHOWN)


def _shares(null: Array) -> Array:
    """Share of every row in a null space, sum 1."""
    return np.asarray((np.sum(null**2, axis=1) / null.shape[1]).round(TIE))
