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

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.deck import Deck
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.mass_check import largest_mass
from spacar.errors import AnalysisError, UsageError
from spacar.forward.displaced import displaced
from spacar.forward.driver import WORK, Tolerances, integrated
from spacar.frame import E_FIELDS, X_FIELDS, StoredFrames
from spacar.integrators import METHODS
from spacar.mechanism import Mechanism, build
from spacar.mechanism.inputs import settings as settings_of
from spacar.mechanism.inputs import user_signal
from spacar.mechanism.mechanism import Drive, Polynomial
from spacar.result import Result
from spacar.studies.side_by_side import Cases, alike, side_by_side

if TYPE_CHECKING:
    from spacar.compiled.cases import InLanes
    from spacar.compiled.numbers import Numbers

E_INDEX = {name: k for k, name in enumerate(E_FIELDS)}
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
    if METHODS[settings.integrator].needs_jacobian:
        return "implicit methods need a dense Jacobian"
    if settings.integrator in WITHOUT_LANES:
        return f"method {settings.integrator} runs alone"
    from spacar.compiled import why_general, why_not_in_lanes

    return why_general(mechanism) or why_not_in_lanes(mechanism) or ""


@dataclass(frozen=True)
class BlockMotions:
    """The motions of a block of cases; variables have the cases last, (steps, nx or ne, cases).

    own         places of the cases
    x, e        (steps, 6, nx, lanes), (steps, 4, ne, lanes): X_FIELDS, E_FIELDS; lanes behind the cases fill up
    statistics  of every step, said of every case
    """

    mechanism: Mechanism
    own: tuple[int, ...]
    t: Array
    x: Array
    e: Array
    statistics: dict[str, Array]
    said: list[tuple[str, ...]]

    @property
    def lnp(self) -> NDArray[np.int64]:
        return self.mechanism.numbering.lnp

    @property
    def le(self) -> NDArray[np.int64]:
        return self.mechanism.numbering.le

    def __getitem__(self, name: str) -> Array:
        """t, one of X_FIELDS or E_FIELDS. Raises KeyError for what only a result has."""
        if name == "t":
            return self.t
        values, k = (self.x, X_FIELDS.index(name)) if name in X_FIELDS else (self.e, E_INDEX[name])
        return values[:, k, :, : len(self.own)]

    def result(self, lane: int) -> Result:
        """Everything of one case."""
        own = {name: self.x[:, k, :, lane] for k, name in enumerate(X_FIELDS)}
        own |= {name: self.e[:, k, :, lane] for k, name in enumerate(E_FIELDS)}
        return Result(self.mechanism, 1, StoredFrames(self.t, own, self.statistics), self.said[lane], {})


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


def followed(
    cases: Cases, times: np.ndarray | None = None, *, threads: int = 1, **options: Any
) -> list[Result | None]:
    """The same of cases that can be batched."""
    results: list[Result | None] = [None] * len(cases.start)

    def keep(motion: BlockMotions) -> None:
        for lane, k in enumerate(motion.own):
            results[k] = motion.result(lane)

    motions(cases, keep, times, threads=threads, **options)
    return results


def motions(
    cases: Cases, use: Callable[[BlockMotions], None], times: np.ndarray | None = None, *, threads: int = 1,
    **options: Any,
) -> None:  # fmt: skip
    """Let `use` have the motions of every block that can be followed, in the thread that has followed it."""
    from spacar.compiled.cases import InLanes, PlacedStart, blocks

    single, numbers, start = cases.single, cases.numbers, cases.start
    settings = single.settings
    if times is None:
        assert settings.duration is not None
        times = np.linspace(0.0, settings.duration, settings.n_steps + 1)
    alone = Dynamics(single)
    placed = PlacedStart(alone.start(), alone.kinematics.x.copy(), alone.sweep.e.copy())
    alone.sweep.mass()
    largest = largest_mass(single, alone.sweep)
    g = displaced(alone)

    def follow(chosen: Sequence[int]) -> None:
        """A block; a case whose user function fails has no motion, and the others begin again without it."""
        own = list(dict.fromkeys(chosen))
        while own:
            lanes = [*own, *own[-1:] * (len(chosen) - len(own))]
            drives = [_drive(single, numbers, k) for k in own]
            users = [u for _ in own if (u := user_signal(single.deck, single.numbering)) is not None]
            block = InLanes(
                alone.model, alone.kinematics.scale, numbers.take(np.array(lanes)), start[lanes], drives, users
            )
            with suppress(AnalysisError):
                motion = together_followed(block, own)
                use(motion)
                return
            if block.failed is None:
                return
            del own[block.failed]

    def together_followed(block: InLanes, own: Sequence[int]) -> BlockMotions:
        said: dict[int, tuple[str, ...]] = {}
        if not block.start(placed, largest):
            for k in own:
                looked_at = Dynamics(build(cases.deck(k), 1, **options))
                looked_at.start()  # raises where a mass matrix is singular
                if looked_at.doubt:
                    said[k] = (f"warning: {looked_at.doubt}",)
        return _motion(block, own, times, single, g, said)

    if threads == 1:
        for chosen in blocks(len(start)):
            follow(chosen)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(follow, blocks(len(start))))


def _drive(single: Mechanism, numbers: Numbers, case: int) -> Drive:
    """Prescribed motion of a case, with a function of its own if there is one."""
    deck = single.deck
    polynomial = Polynomial(numbers.x_motion[:, :, case], numbers.e_motion[:, :, case])
    statement = deck.last("USERINP", block=2)
    if statement is None:
        return polynomial
    from spacar.mechanism.user_functions import UserDrive

    return UserDrive.load(deck, statement, single.numbering, polynomial, settings_of(deck))


def _motion(
    block: InLanes, own: Sequence[int], times: Array, single: Mechanism, g: Array | None,
    said: dict[int, tuple[str, ...]],
) -> BlockMotions:  # fmt: skip
    """The motions of a block; `said` of its cases before. Raises AnalysisError."""
    settings, n, lanes = single.settings, single.numbering, block.by_case[2]
    each = None if g is None else np.broadcast_to(g[:, None], block.by_case[1:]).ravel()
    x, e = (np.empty((len(times), *shape, lanes)) for shape in ((len(X_FIELDS), n.nx), (len(E_FIELDS), n.ne)))
    counted = np.empty((len(times), len(WORK)), np.int64)
    outputs = integrated(
        block, block.y0, times, settings, Tolerances.of(settings, each),
        breaks=block.breaks, watch=block.watch, back=block.rejected, marching=block.marching,
    )  # fmt: skip
    lost: list[dict[int, str]] = [{} for _ in own]
    for step, out in enumerate(outputs):
        block.variables(float(out.t), out.y, x[step], e[step])
        if block.solver.slots.laws:
            for lane, told in enumerate(lost):
                told |= block.lost(lane) | told
        counted[step] = out.work
    of_cases = [
        (*said.get(k, ()), *block.warnings[lane].values(), *lost[lane].values()) for lane, k in enumerate(own)
    ]
    return BlockMotions(single, tuple(own), times, x, e, dict(zip(WORK, counted.T, strict=True)), of_cases)
