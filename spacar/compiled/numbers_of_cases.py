"""Numbers of cases whose lengths differ: the elements of all cases at once, everything else as combinations.

What a statement gives enters the arrays that the constructors of the element families take (reference coordinates, EM,
ESTIFF, EDAMP), the loads, the motions and the start values, and all of these are linear in it. So they are combined,
case by case, from those of a few decks, and one family of the elements of all cases makes of them
what is not linear in lengths: parameters, stiffnesses, masses. A case is as exact as alone: its elements see the same
numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.compiled.numbers import ENTRIES, FOREIGN, Elements, Numbers, elements_of, of_one, summed
from spacar.dynamics.loaded_mechanism import Entries, LoadedMechanism, active_entries
from spacar.elements import Family, GeometryError
from spacar.mechanism.element_batches import PlacedGroup, element_groups
from spacar.mechanism.layout import Batch
from spacar.mechanism.lumped_inertia import LumpedMass, lumped
from spacar.mechanism.mechanism import Mechanism

NONE = np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 1))
ROUNDING = 64.0 * EPS  # of the largest number of an array: constants of elements are some dozen sums


def combined(corners: Sequence[Numbers], weights: Array) -> Numbers | None:
    """The first corner and, in case k, `weights[i - 1, k]` times the difference to every other corner i: numbers that
    do not differ stay what they are. None where the corners have other entries.
    """
    first, *others = corners
    if not all(_alike(first, other) for other in others):
        return None
    return first.each(lambda *arrays: affine(arrays, weights), *others)


def _alike(a: Numbers, b: Numbers) -> bool:
    """Whether the arrays have the same sizes, and entries the same places."""
    one, other = ([array.shape for array in of.arrays()] for of in (a, b))
    pairs = zip(a.entries, b.entries, strict=True)
    return one == other and all(np.array_equal(x[k], y[k]) for x, y in pairs for k in (0, 1))


def same(a: Numbers, b: Numbers) -> bool:
    """Whether the numbers of one case are those of another one to rounding; zeros need not be entries."""
    kinds = [[(e.kind, e.moving) for e in of.elements] for of in (a, b)]
    if kinds[0] != kinds[1] or not all(map(_same_entries, a.entries, b.entries)):
        return False
    a, b = (of._replace(**{name: NONE for name in ENTRIES}) for of in (a, b))  # type: ignore[arg-type]
    return _alike(a, b) and all(map(_close, a.arrays(), b.arrays()))


def _close(one: Array, other: Array) -> bool:
    return bool(np.abs(one - other).max(initial=0.0) <= ROUNDING * np.abs(one).max(initial=0.0))


def _same_entries(a: Entries, b: Entries) -> bool:
    parts = [(of[0], of[1], of[2] * side) for of, side in ((a, (1.0, 0.0)), (b, (0.0, 1.0)))]
    return _close(*_merged(parts, 2)[2].T)


def affine(arrays: Sequence[Array], weights: Array) -> Array:
    """The same of one array, (..., 1) of each corner; (..., cases)."""
    first, *others = arrays
    total = np.repeat(first, weights.shape[1], axis=-1)
    for other, weight in zip(others, weights, strict=True):
        total += (other - first) * weight
    return total


class ImpossibleCase(Exception):
    """The geometry of the elements of a case is impossible: its own deck says why."""

    def __init__(self, case: int) -> None:
        super().__init__(case)
        self.case = case


@dataclass(frozen=True)
class Corner:
    """One of the decks that are combined.

    rest     its numbers without elements; the masses are those of XM
    tensors  of XM, (3, 3, nodes), at the spatial orientation `nodes`
    """

    mechanism: Mechanism
    groups: tuple[PlacedGroup, ...]
    rest: Numbers
    nodes: Index
    tensors: Array


def corner_of(mechanism: Mechanism) -> Corner:
    """What enters of a mechanism."""
    m = mechanism
    groups = tuple(element_groups(m.deck, m.numbering, m.x0, m.settings.beams))
    mass, nodes, tensors = NONE, np.zeros(0, np.int64), np.zeros((3, 3, 0))
    for family, x in lumped(m.deck, m.numbering, []):
        if isinstance(family, LumpedMass):
            mass = x[0], x[0], family.m[:, None]
        else:  # a rigid body; rotors (XGYRO) have no form in C
            nodes, tensors = family.numbers, family.J  # type: ignore[attr-defined]
    loaded = of_one(LoadedMechanism.of(m))._replace(elements=(), mass=mass, stiffness=NONE, damping=NONE)
    return Corner(m, groups, loaded, nodes, tensors)


def numbers_of_cases(corners: Sequence[Corner], weights: Array) -> Numbers | None:
    """Of case k, which is the first corner and `weights[i - 1, k]` times the difference to every other corner i.

    None where the corners have other entries, or an element has no form in C. Raises ImpossibleCase.
    """
    first, cases = corners[0], weights.shape[1]
    m = first.mechanism
    rest = combined([c.rest for c in corners], weights)
    if rest is None or any(not np.array_equal(c.nodes, first.nodes) for c in corners):
        return None
    families = [_family(corners, k, rest.x0, weights) for k in range(len(first.groups))]
    made = [Batch(family, g.x, g.e) for family, g in zip(families, first.groups, strict=True)]
    tensors = affine([c.tensors[..., None] for c in corners], weights)
    elements: list[Elements] = []
    for k, batch in enumerate(m.batches):
        if k < len(made):
            own = elements_of(made[k], made[k].family, cases)
        elif batch.family.n_deformations:
            own = elements_of(batch, batch.family, 1)
            own = own._replace(parameters=np.repeat(own.parameters, cases, axis=-1))
        elif batch.family.has_mass and not batch.family.constant_mass:
            own = elements_of(batch, _bodies(batch, made, m, first.nodes, tensors), cases)
        else:
            continue
        if own.kind == FOREIGN:
            return None
        elements.append(own)
    active = m.numbering.e_class["input"].stop
    laws = [[_entries(S, b.e, b.e, cases) for S in b.family.stiffness()] for b in made]
    stiffness, damping = (_merged(parts, cases) for parts in zip(*laws, strict=True))
    masses = [rest.mass, *(entries for b in made for entries in _masses(b, cases))]
    return rest._replace(
        elements=tuple(elements), mass=_merged(masses, cases),
        stiffness=active_entries(stiffness, active), damping=active_entries(damping, active),
    )  # fmt: skip


def _family(corners: Sequence[Corner], k: int, x0: Array, weights: Array) -> Family:
    """The elements of group k of all cases, case after case. Raises ImpossibleCase."""
    group, cases = corners[0].groups[k], weights.shape[1]
    elements = group.elements

    def rows(name: str) -> Array:
        table = affine([getattr(c.groups[k].elements, name)[..., None] for c in corners], weights)
        return table.transpose(2, 0, 1).reshape(-1, table.shape[1])

    x = x0[group.x]
    together = elements._replace(
        numbers=np.tile(elements.numbers, cases), x0=x.transpose(0, 2, 1).reshape(len(x), -1),
        geometry=elements.geometry * cases, nonlinear=np.tile(elements.nonlinear, cases),
        directions=elements.directions * cases, projections=elements.projections * cases,
        elastic=None if elements.elastic is None else np.tile(elements.elastic, (1, cases)),
        em=rows("em"), estiff=rows("estiff"), edamp=rows("edamp"),
    )  # fmt: skip
    try:
        return group.family(together)  # type: ignore[call-arg]
    except GeometryError as error:
        raise ImpossibleCase(error.index // elements.n) from None


def _by_case(values: Array, cases: int) -> Array:
    """(..., cases, n) of what a family has of the elements of all cases, (..., cases * n)."""
    return values.reshape(*values.shape[:-1], cases, values.shape[-1] // cases)


def _entries(values: Array, rows: Index, columns: Index, cases: int) -> Entries:
    """Where element matrices (a, b, cases * n) are not zero in every case; rows (a, n), columns (b, n)."""
    each = _by_case(values, cases)
    i, j, k = np.nonzero(each.any(axis=2))
    return rows[i, k], columns[j, k], each[i, j, :, k]


def _masses(batch: Batch, cases: int) -> Iterator[Entries]:
    """Constant entries of M, those on single coordinates of nodes too."""
    family, size = batch.family, len(batch.x)
    if family.has_mass and family.constant_mass:
        M = np.zeros((size, size, family.n))
        family.mass(None, M)
        yield _entries(M, batch.x, batch.x, cases)
    for row, J in family.lumped_inertia():
        places = batch.x[row]
        yield places, places, _by_case(J, cases).T


def _bodies(body: Batch, made: Sequence[Batch], m: Mechanism, nodes: Index, tensors: Array) -> Family:
    """The rigid bodies of all cases, case after case: tensors (3, 3, nodes, cases) of XM and those of elements."""
    from spacar.elements.spatial.node_inertia import RigidBodyNode

    own, cases = body.family.numbers, tensors.shape[-1]
    J = np.zeros((cases, len(own), 3, 3))
    J[:, np.searchsorted(own, nodes)] = tensors.transpose(3, 2, 0, 1)
    for batch in made:
        for row, of_elements in batch.family.orientation_inertia():
            owners = [m.numbering.x_owner(int(i))[0] for i in batch.x[row]]
            each = of_elements.reshape(cases, -1, 3, 3)
            for k, place in enumerate(np.searchsorted(own, owners)):
                J[:, place] += each[:, k]
    return RigidBodyNode(np.tile(own, cases), J.reshape(-1, 3, 3))


def _merged(parts: Sequence[Entries], cases: int) -> Entries:
    """All entries, each place once."""
    rows, columns = (np.concatenate([np.zeros(0, np.int64), *(p[i] for p in parts)]) for i in (0, 1))
    values = np.concatenate([np.zeros((0, cases)), *(p[2] for p in parts)])
    return summed(rows, columns, int(columns.max(initial=0)) + 1, values, cases)
