"""Results of many decks that are followed together, as `spacar.run` gives those of one."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from spacar.deck import Deck
from spacar.errors import UsageError
from spacar.result import Result
from spacar.studies.ensemble import motions, why_not
from spacar.studies.side_by_side import Cases, alike, side_by_side


def ensemble(
    decks: Sequence[Deck], times: np.ndarray | None = None, *, threads: int = 1, **options: Any
) -> list[Result | None]:
    """Results of mode 1 of every deck at the same `times` [s] (default: TIMESTEP), as `spacar.run` gives them.

    A case that has to be run alone, as it or one beside it comes to a dead point or leaves the range of its theory, has
    the result None.

    threads   that integrate blocks of cases;  options   as for `spacar.run`

    Raises UsageError for decks that cannot be batched.
    """
    first = decks[0]
    reason = why_not(first, **options)
    if reason or not alike(first, *decks[1:]):
        raise UsageError(
            f"the cases cannot be run together: {reason or 'they differ in more than numbers'}", "study.batch"
        )
    return followed(side_by_side(decks, **options), times, threads=threads, **options)


def followed(cases: Cases, times: np.ndarray | None = None, *, threads: int = 1, **options: Any) -> list[Result | None]:
    """The same of cases that can be batched."""
    results: list[Result | None] = [None] * len(cases.start)

    for found in motions(cases, lambda motion: list(motion.results()), times, threads=threads, **options):
        for k, result in found:
            results[k] = result
    return results
