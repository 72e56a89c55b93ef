"""The derivatives of forces and stresses of the user (USERSIG), for all linearizations and static tangents.

    df/du = (f(u - 2h) - 8 f(u - h) + 8 f(u + h) - f(u + 2h))/(12 h),     h = eps^(1/4) times the size of u

for every deformation e, coordinate x and rate of both on which the function depends. Which these are is asked of
groups: a change of a whole group that leaves the answer as it is, to the last bit, shows that it depends on none of
them; any other group is halved. The error is about eps^(3/4) = 2e-12 of f over the size of u where the function is
smooth; at a corner the result is the mean of both sides.

A function may state diagonal entries itself (k, d: its fourth and fifth column). They stand for the difference where
they agree with it to its own error, and for all derivatives of their row where they contradict the differences (a
function with jumps, a digital controller); then `doubts` says so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from spacar.arrays import EPS, Array, Index
from spacar.linear_systems.linear_system import Matrix, matrix
from spacar.mechanism.mechanism import Mechanism, UserForces

STEP_SHARE = EPS**0.25
EXACT = 1e-10  # relative difference up to which a stated derivative is the difference without its error
AGREE = 1e-5  # relative difference above which a stated derivative is another one: users write some six digits


@dataclass(frozen=True)
class UserDerivatives:
    """Of the stresses sigma (ne,) and the forces f (nx,), one after the other, by e, x, ed, xd: rows, columns, values
    of the entries."""

    mechanism: Mechanism
    entries: tuple[Index, Index, Array]
    doubts: tuple[str, ...] = ()

    @cached_property
    def blocks(self) -> dict[str, Matrix]:
        """By "e", "x", "ed", "xd"; each (ne + nx, its size)."""
        ne, nx = self.mechanism.numbering.ne, self.mechanism.numbering.nx
        rows, columns, values = self.entries
        found, first = {}, 0
        for name, size in (("e", ne), ("x", nx), ("ed", ne), ("xd", nx)):
            here = (columns >= first) & (columns < first + size)
            found[name] = matrix(rows[here], columns[here] - first, values[here], (ne + nx, size))
            first += size
        return found

    def of(self, what: str, by: str) -> Matrix:
        """Derivatives of "sigma" or "f" by one of e, x, ed, xd."""
        ne = self.mechanism.numbering.ne
        return self.blocks[by][:ne] if what == "sigma" else self.blocks[by][ne:]

    def along(self, what: str, **changes: Any) -> Any:
        """Changes of "sigma" or "f" with changes of e, x, ed, xd (size, ...)."""
        parts = [self.of(what, by) @ change for by, change in changes.items()]
        return sum(parts[1:], parts[0])

    def scaled(self, part: float) -> UserDerivatives:
        """Of a part of the stresses and forces."""
        rows, columns, values = self.entries
        return UserDerivatives(self.mechanism, (rows, columns, part * values), self.doubts)

    def with_stated(self, user: UserForces, V: Matrix) -> UserDerivatives:
        """With the rows of k and d that the function states and that are not those of the differences; V (ne, nx)."""
        n, doubts = self.mechanism.numbering, []
        (rows, columns, values), size = self.entries, n.ne + n.nx
        law = getattr(self.mechanism.user_signal, "name", "USERSIG")
        for half, (k_sigma, k_force) in enumerate(((user.sigma_k, user.force_k), (user.sigma_d, user.force_d))):
            stated, first = np.concatenate((k_sigma, -k_force)), half * size
            for i in np.flatnonzero(stated):
                here = (rows == i) & (columns >= first) & (columns < first + size)
                row = np.bincount(columns[here] - first, values[here], size)
                own = np.zeros(size)
                own[i] = stated[i]
                together = [r[n.ne :] + r[: n.ne] @ V for r in (own, row)]
                if not _differ(EXACT, stated[i], row[i]):
                    values = np.where(here & (columns == first + i), stated[i], values)
                if not (_differ(AGREE, stated[i], row[i]) and _differ(AGREE, *together)):
                    continue
                sign, where = (1.0, n.e_name(int(i))) if i < n.ne else (-1.0, n.x_name(int(i) - n.ne))
                doubts.append(_doubt(law, where, "kd"[half], sign * stated[i], sign * row[i]))
                rows, columns = np.append(rows[~here], i), np.append(columns[~here], first + i)
                values = np.append(values[~here], stated[i])
        return UserDerivatives(self.mechanism, (rows, columns, values), tuple(doubts))


def user_derivatives(
    mechanism: Mechanism, t: float, e: Array, ed: Array, x: Array, xd: Array, active: Array
) -> UserDerivatives:
    """At a state; `active` (ne,): rows on which its stress acts. Raises AnalysisError where the function fails."""
    law, n, ne = mechanism.user_signal, mechanism.numbering, len(e)
    assert law is not None
    at = np.concatenate((e, x, ed, xd))
    ends = np.cumsum([ne, len(x), ne])
    size = np.concatenate(2 * (mechanism.deformation_scale, mechanism.scale))
    step = STEP_SHARE * np.maximum(np.abs(at), size)

    def answer(u: Array) -> Array:
        e, x, ed, xd = np.split(u, ends)
        found: UserForces = law(t, e, ed, x, xd)
        return np.concatenate((found.sigma * active, found.force))

    fixed = np.zeros(len(at), bool)
    for first, size_of_fixed in zip((0, *ends), 2 * (n.e_class["fixed"].stop, n.x_class["fixed"].stop), strict=True):
        fixed[first : first + size_of_fixed] = True
    entries = [(*np.zeros((2, 0), np.int64), np.zeros(0))]
    for k in _used(answer, at, step, np.flatnonzero(~fixed)):
        total: Array = np.zeros(ne + len(x))
        for steps, weight in ((-2, 1.0), (-1, -8.0), (1, 8.0), (2, -1.0)):
            u = at.copy()
            u[k] += steps * step[k]
            total += weight * answer(u)
        there = np.flatnonzero(total)
        entries.append((there, np.full(len(there), k), total[there] / (12.0 * step[k])))
    rows, columns, values = (np.concatenate(part) for part in zip(*entries, strict=True))
    return UserDerivatives(mechanism, (rows, columns, values))


def _used(answer: Callable[[Array], Array], at: Array, step: Array, columns: Index) -> list[int]:
    """Those of the columns that change the answer. No two of a group change alike: differences of them show too."""
    known, groups, used = answer(at), [columns], list[int]()
    irregular = step * (1.0 + np.modf(np.arange(len(at)) * 0.6180339887498949)[0])
    while groups:
        group = groups.pop()
        u = at.copy()
        u[group] += irregular[group]
        if not len(group) or np.array_equal(answer(u), known):
            continue
        if len(group) == 1:
            used.append(int(group[0]))
        else:
            groups += np.array_split(group, 2)
    return used


def _differ(within: float, a: Any, b: Any) -> bool:
    return bool(np.max(np.abs(a - b)) > within * max(np.max(np.abs(a)), np.max(np.abs(b))))


def _doubt(law: str, where: str, what: str, stated: float, found: float) -> str:
    return (
        f"warning: {law} states {what} = {stated:.6g} at {where}, differences of what it returns give {found:.6g}: the"
        " linearized equations have the stated one; leave the columns k and d out to have the differences"
    )
