"""Many cases of one mechanism at once: forward dynamics of decks that differ in numbers only.

C evaluates and integrates as many cases at a time as a vector of the processor has lanes (`spacar.compiled.cases`): a
block. The cases of a block share the steps, whose error is the largest one of all cases in it, so that every case is at
least as accurate as alone. The numbers of all cases come from a mechanism of copies (`side_by_side`), or from a few
cases of which the others are combinations (`affine_cases`).

Every case has user functions of its own, loaded for it as for a run alone; Python calls them for the stresses and
prescribed motions of each lane, the rest stays in C. A case whose function fails leaves its block, which begins again.

Not for: modes other than 1, elements without functions in C (XGYRO), implicit methods, cases whose statements, settings
or GRAVITY differ, and installations without the compiled engine: these run one by one. Of a block in which a case
cannot be followed all cases have to be run alone.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np

from spacar.deck import Deck
from spacar.forward.driver import Times
from spacar.integrators import METHODS, EvenTimes
from spacar.mechanism import Mechanism, build
from spacar.studies.followers import Followers, GroupMotions
from spacar.studies.side_by_side import Cases

ROOM = 500_000  # variables of a group of cases, where these are so many: 4 MB
LARGEST = 64  # cases of a group
Used = TypeVar("Used")
WITHOUT_LANES = (220, 225)  # methods that want a state of positions first, then velocities


def why_not(deck: Deck, **options: Any) -> str:
    """Why the cases of a deck cannot be run together; empty when they can."""
    return why_not_of(build(deck, 1, **options))


def why_not_of(mechanism: Mechanism) -> str:
    """The same of a mechanism."""
    settings = mechanism.settings
    if settings.duration is None or settings.n_steps < 1:
        return "there is no TIMESTEP"
    if not mechanism.numbering.nddof:
        return "nothing is integrated"
    if not mechanism.numbering.is_square:
        return "constraints and unknowns differ in number"
    if METHODS[settings.integrator].needs_jacobian:
        return "implicit methods need a dense Jacobian"
    if settings.integrator in WITHOUT_LANES:
        return f"method {settings.integrator} runs alone"
    from spacar.compiled import why_general, why_not_in_lanes

    return why_general(mechanism) or why_not_in_lanes(mechanism) or ""


def motions(
    cases: Cases, use: Callable[[GroupMotions], Used], times: np.ndarray | None = None, *, threads: int = 1,
    **options: Any,
) -> Iterator[Used]:  # fmt: skip
    """What `use` makes of the motions that can be followed, group after group of cases, in the thread that has followed
    them. Their arrays are used again."""
    from spacar.compiled.cases import blocks

    settings = cases.single.settings
    at: Times = EvenTimes(0.0, settings.duration or 0.0, settings.n_steps) if times is None else times
    followers = Followers(cases, at, options)

    def answer(group: Sequence[Sequence[int]]) -> Used:
        with followers.one() as follower:
            return use(follower.follow(group))

    groups = _groups(list(blocks(len(cases.start))), len(at) * followers.width, threads)
    if threads == 1:
        yield from map(answer, groups)
    else:
        with ThreadPoolExecutor(threads) as pool:
            yield from pool.map(answer, groups)


def _groups(own: list[Sequence[int]], numbers: int, threads: int) -> Iterator[list[Sequence[int]]]:
    """Blocks that are followed one after the other, about as many in each group; `numbers`: variables of a case."""
    most = max(1, min(ROOM // numbers, LARGEST) // len(own[0]))
    count = -(-len(own) // most)
    count = min(-(-count // threads) * threads, len(own))
    for k in range(count):
        yield own[k * len(own) // count : (k + 1) * len(own) // count]
