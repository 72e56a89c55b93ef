"""The numbers of a mechanism, or of several that differ in numbers only, as the solver in C reads them.

Every array has the cases on its last axis. Rows and columns of sparse entries are common to all cases.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from spacar.arrays import Array, Index
from spacar.compiled.library import engine
from spacar.dynamics.loaded_mechanism import Entries, LoadedMechanism, StressLaw, gravity_field, moment_entries
from spacar.elements.family import Family
from spacar.mechanism.layout import Batch
from spacar.mechanism.lumped_inertia import LumpedMass
from spacar.mechanism.mechanism import NO_ENTRIES, Drive, Mechanism, Polynomial


class Elements(NamedTuple):
    """A batch: kind, whether M depends on x, coordinates (n, nxe), deformations (n, nee), parameters (n, np, cases).

    `family`: the NumPy family where there is no form in C (kind FOREIGN).
    """

    kind: int
    moving: bool
    x: Index
    e: Index
    parameters: Array
    family: Family | None = None


class Numbers(NamedTuple):
    """Everything that may differ from case to case."""

    elements: tuple[Elements, ...]
    mass: Entries  # constant ones
    stiffness: Entries
    damping: Entries
    moments: Entries  # forces that are linear in x
    coupling: Entries  # M_e of MEE
    force: Array  # (nx, cases) constant nodal forces, gravity field at the coordinates, reference configuration
    field: Array
    x0: Array
    preload: Array  # (ne, cases)
    x_motion: Array  # (n, 3, cases) start, rate, acceleration; or what the motion is at a time
    e_motion: Array

    def arrays(self) -> list[Array]:
        """All that are not empty, in the order in which C reads them (`read_spec` of model.c)."""
        first = [getattr(self, name) for name in ARRAYS]
        of_elements = [batch.parameters.swapaxes(0, 1) for batch in self.elements]
        return [a for a in (*first, *(values for _, _, values in self.entries), *of_elements) if a.size]

    @property
    def entries(self) -> list[Entries]:
        """Those of all matrices, in the order of ENTRIES."""
        return [getattr(self, name) for name in ENTRIES]

    def each(self, make: Callable[..., Array], *others: Numbers) -> Numbers:
        """Every array is what `make` makes of it and of those of the others; rows and columns of entries stay."""
        everyone = self, *others
        parameters = zip(*[[batch.parameters for batch in one.elements] for one in everyone], strict=True)
        elements = [batch._replace(parameters=make(*p)) for batch, p in zip(self.elements, parameters, strict=True)]
        found: dict[str, Any] = {name: make(*[getattr(one, name) for one in everyone]) for name in ARRAYS}
        for name in ENTRIES:
            rows, columns, _ = getattr(self, name)
            found[name] = rows, columns, make(*[getattr(one, name)[2] for one in everyone])
        return Numbers(tuple(elements), **found)

    def take(self, cases: slice | Index) -> Numbers:
        """Those of some cases."""
        return self.each(lambda array: np.ascontiguousarray(array[..., cases]))


ENTRIES = "mass", "stiffness", "damping", "moments", "coupling"
ARRAYS = "x_motion", "e_motion", "force", "preload", "x0", "field"  # in the order in which C reads them


def of_one(model: LoadedMechanism) -> Numbers:
    """The numbers of a mechanism with its loads and its drive."""
    m, loads, law, drive = model.mechanism, model.loads, model.law, model.drive
    return Numbers(
        tuple([elements_of(batch, batch.family, 1) for batch in evaluated(m)]),
        _only(constant_mass(m)), _only(law.stiffness), _only(law.damping),
        _only(moment_entries(loads.moment_rows, loads.moment)), _only(m.deformation_inertia),
        loads.force[:, None], gravity_field(m, loads)[:, None], m.x0[:, None], law.preload[:, None],
        motion(drive, "x")[..., None], motion(drive, "e")[..., None],
    )  # fmt: skip


def of_copies(one: Mechanism, together: Mechanism, x_of: Index, e_of: Index) -> Numbers:
    """The numbers of the cases of `one` that stand side by side in `together`.

    `x_of` (cases, nx) and `e_of` (cases, ne) are the places of the coordinates and deformations of each case.
    """
    cases = len(x_of)
    law = StressLaw.of(together, together.loads)
    elements = []
    for b, all_ in zip(evaluated(one), evaluated(together), strict=True):
        # elements are in the order of their numbers
        assert np.array_equal(all_.x.reshape(len(b.x), cases, b.family.n), x_of[:, b.x].transpose(1, 0, 2))
        elements.append(elements_of(b, all_.family, cases))
    inputs, deformed = (c["input"] for c in (one.numbering.x_class, one.numbering.e_class))
    x_rows = x_of[:, inputs] - together.numbering.x_class["input"].start
    e_rows = e_of[:, deformed] - together.numbering.e_class["input"].start
    field = np.repeat(gravity_field(one, one.loads)[:, None], cases, axis=1)
    x_motion, e_motion = motion(together.drive, "x")[x_rows], motion(together.drive, "e")[e_rows]
    return Numbers(
        tuple(elements),
        _sorted(constant_mass(together), x_of), _sorted(law.stiffness, e_of), _sorted(law.damping, e_of),
        _sorted(moment_entries(together.loads.moment_rows, together.loads.moment), x_of),
        _sorted(together.deformation_inertia, e_of),
        together.loads.force[x_of].T, field, together.x0[x_of].T, law.preload[e_of].T,
        x_motion.transpose(1, 2, 0), e_motion.transpose(1, 2, 0),
    )  # fmt: skip


FOREIGN = -1  # kind of a batch that is evaluated by its NumPy family


def evaluated(mechanism: Mechanism) -> list[Batch]:
    """The batches that are evaluated with the state; the others are lumped masses, which are constant entries of M."""
    return [b for b in mechanism.batches if b.family.n_deformations or _moving(b.family)]


def without_form(mechanism: Mechanism) -> list[str]:
    """Keywords of the batches that have no functions in C."""
    return sorted({b.family.keyword for b in evaluated(mechanism) if form_of(b.family)[0] == FOREIGN})


def _moving(family: Family) -> bool:
    return family.has_mass and not family.constant_mass


def form_of(family: Family) -> tuple[int, Array]:
    """The kind in C and the parameters (n_parameters, n). A kind that the engine does not know as it is is FOREIGN."""
    kind, count = engine(1).kinds.get(family.definition, (FOREIGN, 0))
    parameters = family.parameters()
    return (kind, parameters) if count == len(parameters) else (FOREIGN, np.zeros((0, family.n)))


def elements_of(batch: Batch, family: Family, cases: int) -> Elements:
    """A batch; `family` has its elements of all cases, case after case."""
    kind, parameters = form_of(family)
    parameters = parameters.reshape(len(parameters), cases, batch.x.shape[1]).transpose(2, 0, 1)
    foreign = family if kind == FOREIGN else None
    return Elements(kind, _moving(family), batch.x.T, batch.e.T, parameters, foreign)


def _only(entries: Entries) -> Entries:
    return entries[0], entries[1], entries[2][:, None]


def motion(drive: Drive, what: str) -> Array:
    """Start, rate and acceleration of polynomial motions; room for the present values of others, (n, 3)."""
    if isinstance(drive, Polynomial):
        return np.asarray(getattr(drive, what))
    return np.zeros((len(getattr(drive.at(0.0), what)), 3))


def constant_mass(mechanism: Mechanism) -> Entries:
    """Rows, columns and values of the mass matrices that do not depend on the position."""
    parts = [NO_ENTRIES]
    for b in mechanism.batches:
        if isinstance(b.family, LumpedMass):
            parts.append((b.x[0], b.x[0], b.family.m))
        elif b.family.has_mass and b.family.constant_mass:
            M = np.zeros((len(b.x), *b.x.shape))
            b.family.mass(None, M)
            i, j, k = M.nonzero()
            parts.append((b.x[i, k], b.x[j, k], M[i, j, k]))
    rows, columns, values = map(np.concatenate, zip(*parts, strict=True))
    return rows, columns, values


def _sorted(entries: Entries, places: Index) -> Entries:
    """Entries of all copies by the rows and columns of one; what a case does not have is zero."""
    rows, columns, values = entries
    cases, n = places.shape
    case_of, index_of = np.zeros((2, places.max(initial=0) + 1), np.int64)
    case_of[places], index_of[places] = np.arange(cases)[:, None], np.arange(n)
    return summed(index_of[rows], index_of[columns], n, values, cases, case_of[rows])


def summed(
    rows: Index, columns: Index, n: int, values: Array, cases: int, case: Index | slice = slice(None)
) -> Entries:
    """Entries with columns below n, each place once: values (entries, cases), or (entries,) of a `case` each."""
    keys, inverse = np.unique(rows * n + columns, return_inverse=True)
    out = np.zeros((len(keys), cases))
    np.add.at(out, (inverse, case), values)  # type: ignore[arg-type]
    return keys // n, keys % n, out
