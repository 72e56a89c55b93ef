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

A follower has one model in C, into which the numbers of block after block go, and one array for the variables of a
group of blocks, so that a case costs next to nothing but its evaluations. Every thread has a follower of its own. Cases
with user functions have a model for each block, as the functions belong to it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from spacar.arrays import Array
from spacar.deck import Deck
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.loaded_mechanism import LoadedMechanism
from spacar.dynamics.mass_check import largest_mass
from spacar.errors import AnalysisError
from spacar.forward.accepted_steps import FAR
from spacar.forward.displaced import displaced
from spacar.forward.driver import WORK, Integrand, Times, Tolerances
from spacar.frame import E_FIELDS, X_FIELDS, StoredFrames
from spacar.integrators import METHODS, EvenTimes, integrate
from spacar.mechanism import Mechanism, build
from spacar.mechanism.mechanism import Drive, Polynomial, UserSignal
from spacar.result import Result
from spacar.studies.side_by_side import Cases, start_of

if TYPE_CHECKING:
    from spacar.compiled.cases import InLanes, PlacedStart
    from spacar.compiled.compiled_stepper import CompiledStepper
    from spacar.mechanism.user_functions import UserLaw

ROOM = 500_000  # variables of a group of cases, where these are so many: 4 MB
LARGEST = 64  # cases of a group
Used = TypeVar("Used")
X_INDEX, E_INDEX = ({name: k for k, name in enumerate(of)} for of in (X_FIELDS, E_FIELDS))
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


@dataclass(frozen=True)
class OfCases:
    """A variable of some cases: `[:, column]` is what a case has of it, with the cases last, (steps, ..., cases).

    rows (blocks, steps, nx or ne, lanes);  chosen  which of all lanes
    """

    rows: Array
    chosen: Sequence[int]

    def __getitem__(self, place: Any) -> Array:
        found = np.moveaxis(self.rows, 0, -2)[place]
        values, n = found.reshape(*found.shape[:-2], -1), len(self.chosen)
        return values[..., :n] if not n or self.chosen[-1] == n - 1 else values[..., self.chosen]


@dataclass(frozen=True)
class GroupMotions:
    """The motions of some cases.

    own      places of the cases;  lanes  where they are in the rows
    rows     (blocks, steps, 6 nx + 4 ne, lanes): X_FIELDS, E_FIELDS. They are used again for other cases
    counted  (steps, 5) the work of every output, of every case;  said  of every case
    """

    mechanism: Mechanism
    own: list[int]
    lanes: list[int]
    t: Array
    rows: Array
    counted: list[Array]
    said: list[tuple[str, ...]]

    @property
    def lnp(self) -> NDArray[np.int64]:
        return self.mechanism.numbering.lnp

    @property
    def le(self) -> NDArray[np.int64]:
        return self.mechanism.numbering.le

    def __getitem__(self, name: str) -> Any:
        """t, or one of X_FIELDS or E_FIELDS, `OfCases`. Raises KeyError for what only a result has."""
        return self.t if name == "t" else OfCases(self._values(name), self.lanes)

    def _values(self, name: str) -> Array:
        n = self.mechanism.numbering
        first, size = (X_INDEX[name] * n.nx, n.nx) if name in X_INDEX else (6 * n.nx + E_INDEX[name] * n.ne, n.ne)
        return self.rows[:, :, first : first + size]

    def results(self) -> Iterator[tuple[int, Result]]:
        """Place and everything of each case."""
        for k, place, counted, said in zip(self.own, self.lanes, self.counted, self.said, strict=True):
            block, lane = divmod(place, self.rows.shape[-1])
            own = {name: self._values(name)[block, ..., lane].copy() for name in (*X_FIELDS, *E_FIELDS)}
            frames = StoredFrames(self.t, own, dict(zip(WORK, counted.T, strict=True)))
            yield k, Result(self.mechanism, 1, frames, said, {})


class Followers:
    """Those of cases at `times` [s], with what they have in common; `width`: numbers of a step."""

    def __init__(self, cases: Cases, times: Times, options: dict[str, Any]) -> None:
        from spacar.compiled.cases import blocks

        self.cases, self.asked, self.options = cases, times, options
        self.times = np.array(times, float)
        self.single = single = cases.single
        n = len(cases.start)
        # without lengths among the degrees of freedom there is none: the first case need not be placed
        lengths = single.is_length[single.numbering.e_class["dynamic"]].any()
        g = displaced(self.alone) if lengths else None
        self.g = None if g is None else g[:, None]
        self.model = LoadedMechanism.of(single)
        self.values = np.concatenate([a.reshape(-1, n) for a in cases.numbers.arrays()])
        self.driven = single.deck.last("USERINP", block=2) is not None
        self.first = next(blocks(n))
        self.own_functions = self.driven or single.user_signal is not None
        self.width = 6 * single.numbering.nx + 4 * single.numbering.ne
        self._spare: list[Follower] = []

    @cached_property
    def alone(self) -> Dynamics:
        """The evaluator of the first case, at its start. Raises AnalysisError where it cannot be placed."""
        alone = Dynamics(self.single)
        alone.start()
        return alone

    def placed(self) -> PlacedStart:
        """The start of the first case, from which a start that is far away is reached."""
        from spacar.compiled.cases import PlacedStart

        alone = self.alone
        alone.sweep.mass()
        largest = largest_mass(self.single, alone.sweep)
        return PlacedStart(start_of(self.single), alone.kinematics.x, alone.sweep.e, largest)

    @contextmanager
    def one(self) -> Iterator[Follower]:
        """A follower that nobody else has."""
        try:
            found = self._spare.pop()
        except IndexError:
            found = Follower(self)
        yield found
        self._spare.append(found)

    def drives(self, own: Sequence[int]) -> list[Drive]:
        """Prescribed motions of cases, with a function of its own each if there is one; none: polynomials."""
        from spacar.mechanism.user_functions import UserDrive

        drive, numbers = self.single.drive, self.cases.numbers
        if not isinstance(drive, UserDrive):
            return []
        return [drive.anew(Polynomial(numbers.x_motion[:, :, k], numbers.e_motion[:, :, k])) for k in own]

    def users(self, own: Sequence[int]) -> list[UserLaw]:
        """User functions of stresses of cases, one each if there is one."""
        from spacar.mechanism.user_functions import UserLaw

        law = self.single.user_signal
        return [law.anew() for _ in own] if isinstance(law, UserLaw) else []


class Follower:
    """One model in C for block after block; `buffer` has the variables of a group."""

    def __init__(self, of: Followers) -> None:
        self.of = of
        self.block: InLanes | None = None
        self.stepper: CompiledStepper | None = None  # of that block
        self.buffer = np.empty(0)

    def follow(self, group: Sequence[Sequence[int]]) -> GroupMotions:
        """The motions of all cases of some blocks, without those of blocks that cannot be followed; a block whose last
        cases are the same is filled up."""
        of, lanes = self.of, len(group[0])
        shape = len(group), len(of.times), of.width, lanes
        size = int(np.prod(shape))
        if len(self.buffer) < size:
            self.buffer = np.empty(size)
        rows = self.buffer[:size].reshape(shape)
        motions = GroupMotions(of.single, [], [], of.times, rows, [], [])
        for k, chosen in enumerate(group):
            own = list(dict.fromkeys(chosen))
            while own:
                with suppress(AnalysisError):
                    said, counted = self._followed([*own, *own[-1:] * (lanes - len(own))], own, rows[k])
                    motions.own.extend(own)
                    motions.lanes.extend(range(k * lanes, k * lanes + len(own)))
                    motions.counted.extend([counted] * len(own))
                    motions.said.extend(said)
                    break
                # a case whose user function fails has no motion, and the others begin again without it
                failed = None if self.block is None else self.block.failed
                if failed is None:
                    break
                del own[failed]
        return motions

    def _followed(self, lanes: list[int], own: list[int], rows: Array) -> tuple[list[tuple[str, ...]], Array]:
        """What is said of each case of a block, and its work at every output. Raises AnalysisError."""
        of = self.of
        self.block = block = self._lanes(lanes, own)
        said: dict[int, tuple[str, ...]] = {}
        if not block.start(of.placed):
            for case in own:
                looked_at = Dynamics(build(of.cases.deck(case), 1, **of.options))
                looked_at.start()  # raises where a mass matrix is singular
                if looked_at.doubt:
                    said[case] = (f"warning: {looked_at.doubt}",)
        settings = of.single.settings
        each = None if of.g is None else np.broadcast_to(of.g, block.by_case[1:]).ravel()
        block.output_block.into(of.times, rows, FAR)
        stepper = self.stepper
        if stepper is None or stepper.evaluator is not block:
            self.stepper = stepper = block.stepper()
        stepper.anew()
        within = Tolerances.of(settings, each)
        outputs = integrate(
            Integrand(block, block, within.position, stepper), block.y0, of.asked, settings.integrator, within.atol,
            within.rtol, settings.step, breaks=block.breaks,
        )  # fmt: skip
        counted, step = np.empty((len(of.times), len(WORK))), 0
        for out in outputs:
            if out.passed is None:
                block.output_block.show(step, out.y)
            made = 1 if out.passed is None else len(out.passed.work)
            counted[step : step + made] = out.work if out.passed is None else out.passed.work
            step += made
        i, j, S = of.cases.numbers.stiffness
        lifted = block.wheels_lifted(of.times, rows, (i, j, S[:, lanes]))
        of_cases = [
            (*said.get(case, ()), *lifted[lane].values(), *block.lost(lane).values()) for lane, case in enumerate(own)
        ]
        return of_cases, counted

    def _lanes(self, lanes: list[int], own: list[int]) -> InLanes:
        """The model with the numbers of these cases."""
        of = self.of
        if of.own_functions:
            self.block = None  # it says which function failed
            return self._model(lanes, of.drives(own), of.users(own))
        in_order = len(own) == len(lanes) == own[-1] - own[0] + 1
        chosen = slice(own[0], own[-1] + 1) if in_order else lanes
        block = self.block or self._first()
        block.renew(of.values[:, chosen], of.cases.start[chosen])
        return block

    def _first(self) -> InLanes:
        """A model that has evaluated the start of the first block, from which orders of pivots come: those of every
        follower, whatever it has followed."""
        block = self._model(self.of.first)
        with suppress(AnalysisError):
            block.start(self.of.placed)
        return block

    def _model(self, lanes: Sequence[int], drives: Sequence[Drive] = (), users: Sequence[UserSignal] = ()) -> InLanes:
        from spacar.compiled.cases import InLanes

        of, cases = self.of, self.of.cases
        numbers = cases.numbers.take(np.array(lanes))
        scale, start = of.single.scale, cases.start[list(lanes)]
        return InLanes(of.model, scale, numbers, start, drives, users)
