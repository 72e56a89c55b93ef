"""Which loads act at which step (ITERSTEP, input-language.md d15).

A load level is a pair (initial, additional) of fractions. Types 0 and 1 apply the initial loading (sections 5.2 to
5.4 of the input language) in equal increments and store the last solution; types 2 and 3 apply it first, store it, then
add the additional loading (DEL...) in equal increments, of which every n-th and the last are stored.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from spacar.deck import ELEMENT_TYPES
from spacar.mechanism.mechanism import WITH_ADDITIONAL, Batch, DriveState, Loads, Mechanism, SolverSettings

WITHOUT_N0 = (1, 3)  # ITERSTEP types whose Newton iteration leaves N0 out


class LoadLevel(NamedTuple):
    """Fractions of the initial and of the additional loading; `store` says whether the solution is a result.

    `step` of `steps` is what messages call it; a level inside a cut step has the number of the whole step.
    """

    initial: float
    additional: float
    store: bool = False
    step: int = 0
    steps: int = 0

    @property
    def path(self) -> float:
        """Place on the way: 0 to 1 along the initial loading, 1 to 2 along the additional loading."""
        return self.initial + self.additional

    def towards(self, other: LoadLevel, fraction: float) -> LoadLevel:
        """The level between this and the other one."""
        a = self.initial + fraction * (other.initial - self.initial)
        b = self.additional + fraction * (other.additional - self.additional)
        return other._replace(initial=a, additional=b, store=False)

    def __str__(self) -> str:
        extra = f" + {self.additional:.6g} x additional" if self.additional else ""
        return f"load step {self.step} of {self.steps} ({self.initial:.6g} x initial{extra} loading)"


@dataclass(frozen=True)
class LoadProgram:
    """All levels in order; those with `store` become frames. It may be run through more than once."""

    settings: SolverSettings

    def __iter__(self) -> Iterator[LoadLevel]:
        settings = self.settings
        n0, n1 = settings.initial_steps, max(settings.load_steps, 1)
        if settings.stationary_type in WITH_ADDITIONAL:
            n0 = max(n0, 1)
        else:
            n0, n1 = n0 if n0 > 0 else n1, 0
        for k in range(1, n0 + 1):
            yield LoadLevel(k / n0, 0.0, k == n0, k, n0 + n1)
        every = max(settings.store_every, 1)
        for k in range(1, n1 + 1):
            yield LoadLevel(1.0, k / n1, k % every == 0 or k == n1, n0 + k, n0 + n1)


def loads_at(mechanism: Mechanism, level: LoadLevel) -> Loads:
    loads = mechanism.loads if level.initial == 1.0 else mechanism.loads.scaled(level.initial)
    if level.additional and mechanism.additional is not None:
        loads = loads.plus(mechanism.additional.scaled(level.additional))
    return loads


def loads_grow(mechanism: Mechanism, level: LoadLevel) -> bool:
    """Do loads grow on the way to a level, those of a user function too, or only prescribed displacements?"""
    if level.additional:
        return mechanism.additional is not None and mechanism.additional.present
    return mechanism.loads.present or mechanism.user_signal is not None


def is_tube(b: Batch) -> bool:
    """May a fluid flow through the elements, whose momentum loads them?"""
    kind = ELEMENT_TYPES.get(b.family.keyword)
    return kind is not None and kind.carries_flow


def with_flow(mechanism: Mechanism, loads: Loads) -> Mechanism:
    """The mechanism with the mass flow of these loads in its tubes; itself when there are none."""
    if not loads.flow:
        return mechanism
    batches = []
    for batch in mechanism.batches:
        if is_tube(batch):
            flow = np.array([loads.flow.get(int(n), 0.0) for n in batch.family.numbers])
            batch = batch._replace(family=batch.family.with_flow(flow))  # type: ignore[attr-defined]
        batches.append(batch)
    return replace(mechanism, batches=tuple(batches))


@dataclass(frozen=True)
class SteadyDrive:
    """Prescribed values of a load level: constant rates, no accelerations, the same at all times."""

    state: DriveState
    breaks: tuple[float, ...] = ()

    @classmethod
    def at_level(cls, mechanism: Mechanism, level: LoadLevel) -> SteadyDrive:
        """Values measured from the reference configuration and rates, both scaled with the level."""
        n = mechanism.numbering
        if n.ndof == n.nddof:
            return cls(DriveState(*6 * (np.zeros(0),)))
        start = mechanism.drive.at(0.0)
        x_reference = mechanism.x0[n.x_class["input"]]
        x = x_reference + level.initial * (start.x - x_reference)
        e = level.initial * start.e
        if level.additional and mechanism.additional_drive is not None:
            x = x + level.additional * mechanism.additional_drive.x
            e = e + level.additional * mechanism.additional_drive.e
        zero_x, zero_e = np.zeros_like(x), np.zeros_like(e)
        return cls(DriveState(x, level.initial * start.xd, zero_x, e, level.initial * start.ed, zero_e))

    @property
    def moving(self) -> bool:
        """Does anything prescribed move?"""
        return bool(self.state.xd.any() or self.state.ed.any())

    def shift(self, mechanism: Mechanism) -> bool:
        """Is anything prescribed away from the reference configuration?"""
        x = mechanism.x0[mechanism.numbering.x_class["input"]]
        return bool((self.state.x != x).any() or self.state.e.any())

    def at(self, t: float) -> DriveState:
        """The same at all times."""
        return self.state
