"""Many cases of one mechanism at once: forward dynamics of decks that differ in numbers only.

C evaluates and integrates as many cases at a time as a vector of the processor has lanes (`spacar.compiled.cases`): a
block. The cases of a block share the steps, whose error is the largest one of all cases in it, so that every case is at
least as accurate as alone. The numbers of all cases come from one mechanism of disjoint copies: case k has the nodes
and elements of the first one, their numbers raised by k times the largest number. Since coordinates are numbered by
class, then node, case k holds the same places of every class as the single mechanism.

Every case has user functions of its own, loaded for it as for a run alone; Python calls them for the stresses and
prescribed motions of each lane, the rest stays in C. A case whose function fails leaves its block, which begins again.

Not for: modes other than 1, wheels and other slips, elements without functions in C, implicit methods, cases whose
statements, settings or GRAVITY differ, and installations without the compiled engine: these run one by one. Of a block
in which a case cannot be followed all cases have to be run alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.dynamics.array_evaluator import Dynamics
from spacar.dynamics.mass_check import largest_mass
from spacar.errors import AnalysisError, UsageError
from spacar.forward.displaced import displaced
from spacar.forward.driver import Tolerances, integrated, work
from spacar.frame import StoredFrames
from spacar.integrators import METHODS
from spacar.mechanism import Mechanism, build
from spacar.mechanism.inputs import settings as settings_of
from spacar.mechanism.inputs import user_signal
from spacar.mechanism.mechanism import Drive, Polynomial
from spacar.mechanism.user_functions import STATEMENTS
from spacar.result import Result
from spacar.studies.assignments import parameters_of

if TYPE_CHECKING:
    from spacar.compiled.cases import InLanes
    from spacar.compiled.numbers import Numbers

X_FIELDS = ("x", "xd", "xdd", "fx", "fxgrav", "fxtot")
E_FIELDS = ("e", "ed", "edd", "sig")
WITHOUT_LANES = (220, 225)  # methods that want a state of positions first, then velocities


def why_not(deck: Deck, **options: Any) -> str:
    """Why the cases of a deck cannot be run together; empty when they can."""
    if any(ELEMENT_TYPES[s.keyword].slips for s in deck.of(*ELEMENT_TYPES, block=1)):
        return "wheels are not in batches"
    mechanism = build(deck, 1, **options)
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


def alike(a: Deck, *others: Deck) -> bool:
    """Whether decks are cases of one mechanism: the same statements, references and settings."""
    statements = _with_references(a)
    return all(_like(statements, _statements(other)) for other in others)


@lru_cache(maxsize=8)
def _with_references(deck: Deck) -> list[tuple[Statement, list[int]]]:
    """Statements that matter, and the places of the values in them that are node or element numbers."""
    return [(s, _references(deck, s)) for s in _statements(deck)]


def _like(statements: list[tuple[Statement, list[int]]], others: list[Statement]) -> bool:
    if len(statements) != len(others):
        return False
    for (s, references), o in zip(statements, others, strict=True):
        if s is o:
            continue
        if s.keyword != o.keyword or len(s.values) != len(o.values) or (not references and s.values != o.values):
            return False
        if any(s.values[i] != o.values[i] for i in references):
            return False
    return True


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
    from spacar.compiled.cases import InLanes, blocks
    from spacar.compiled.numbers import of_copies

    single = build(first, 1, **options)
    together = build(copies(decks), 1, **options)
    settings = single.settings
    if times is None:
        assert settings.duration is not None
        times = np.linspace(0.0, settings.duration, settings.n_steps + 1)
    x_of, e_of = _places(single, together, len(decks), _stride(first))
    numbers, start = of_copies(single, together, x_of, e_of), _start(together, x_of, e_of)
    alone = Dynamics(single)
    alone.start()
    alone.sweep.mass()
    largest = largest_mass(single, alone.sweep)
    g = displaced(alone)
    results: list[Result | None] = [None] * len(decks)

    def follow(cases: Sequence[int]) -> None:
        """Results of a block; a case whose user function fails has none, and the others begin again without it."""
        own = list(dict.fromkeys(cases))
        while own:
            lanes = [*own, *own[-1:] * (len(cases) - len(own))]
            drives = [_drive(decks[k], single, numbers, k) for k in own]
            users = [u for k in own if (u := user_signal(decks[k], single.numbering)) is not None]
            block = InLanes(
                alone.model, alone.kinematics.scale, numbers.take(np.array(lanes)), start[lanes], drives, users
            )
            with suppress(AnalysisError):
                together_followed(block, own)
                return
            if block.failed is None:
                return
            del own[block.failed]

    def together_followed(block: InLanes, cases: Sequence[int]) -> None:
        said: dict[int, tuple[str, ...]] = {}
        if not block.start(largest):
            for k in cases:
                looked_at = Dynamics(build(decks[k], 1, **options))
                looked_at.start()  # raises where a mass matrix is singular
                if looked_at.doubt:
                    said[k] = (f"warning: {looked_at.doubt}",)
        found = _motion(block, times, single, g)
        for lane, k in enumerate(cases):
            frames, lost = found(lane)
            results[k] = Result(single, 1, frames, (*said.get(k, ()), *lost), {})

    if threads == 1:
        for cases in blocks(len(decks)):
            follow(cases)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(follow, blocks(len(decks))))
    return results


def _drive(deck: Deck, single: Mechanism, numbers: Numbers, case: int) -> Drive:
    """Prescribed motion of a case, with a function of its own if there is one."""
    polynomial = Polynomial(numbers.x_motion[:, :, case], numbers.e_motion[:, :, case])
    statement = deck.last("USERINP", block=2)
    if statement is None:
        return polynomial
    from spacar.mechanism.user_functions import UserDrive

    return UserDrive.load(deck, statement, single.numbering, polynomial, settings_of(deck))


Lane = tuple[StoredFrames, tuple[str, ...]]


def _motion(block: InLanes, times: Array, single: Mechanism, g: Array | None) -> Callable[[int], Lane]:
    """The frames of a lane of the block, and what is said of its stresses. Raises AnalysisError."""
    settings = single.settings
    each = None if g is None else np.broadcast_to(g[:, None], block.by_case[1:]).ravel()
    xs, es = [], []
    statistics: list[dict[str, int]] = []
    outputs = integrated(
        block, block.y0, times, settings, Tolerances.of(settings, each),
        breaks=block.breaks, watch=block.watch, back=block.rejected, marching=block.marching,
    )  # fmt: skip
    lost: list[dict[int, str]] = [{} for _ in range(block.by_case[2])]
    for out in outputs:
        x, e = block.variables(float(out.t), out.y)
        for lane, told in enumerate(lost):
            told |= block.lost(lane) | told
        xs.append(x)
        es.append(e)
        statistics.append(work(out))
    all_x, all_e = np.array(xs).transpose(3, 1, 0, 2), np.array(es).transpose(3, 1, 0, 2)  # lane, variable, step, place

    def of_lane(lane: int) -> Lane:
        own = dict(zip((*X_FIELDS, *E_FIELDS), (*all_x[lane], *all_e[lane]), strict=True))
        return StoredFrames(times, own, statistics), tuple(lost[lane].values())

    return of_lane


def _start(together: Mechanism, x_of: Array, e_of: Array) -> Array:
    """State of every case at the start, (cases, components): dynamic coordinates and deformations, their rates."""
    n, s = together.numbering, together.start
    x, e = np.full((2, n.nx), np.nan), np.full((2, n.ne), np.nan)
    x[:, n.x_class["dynamic"]] = s.x_value, s.x_rate
    e[:, n.e_class["dynamic"]] = s.e_value, s.e_rate
    both = np.concatenate((x[:, x_of], e[:, e_of]), axis=-1)
    dynamic = ~np.isnan(both[0, 0])
    return np.concatenate(both[:, :, dynamic], axis=-1)


def copies(decks: Sequence[Deck]) -> Deck:
    """One deck with the mechanisms of all decks side by side. The decks are alike and have been checked."""
    first = decks[0]
    stride = _stride(first)
    statements = []
    references = [places for _, places in _with_references(first)]
    for k, deck in enumerate(decks):
        for s, places in zip(_statements(deck), references, strict=True):
            if not places:
                statements += [s] * (k == 0 and s.keyword not in STATEMENTS)
                continue
            values = list(s.values)
            for i in places:
                values[i] = s.integer(i) + k * stride
            statements.append(Statement(s.keyword, tuple(values), s.block, s.line, s.lines, s.place))
    return Deck(tuple(statements), first.source, first.path, first.text, first.data, mode=1)


def _statements(deck: Deck) -> list[Statement]:
    return [s for s in deck.statements if s.block < 3 and s.keyword != "OUTLEVEL"]


def _references(deck: Deck, s: Statement) -> list[int]:
    """Places of the values that are node or element numbers."""
    if s.keyword in ELEMENT_TYPES:
        return list(range(1 + len(ELEMENT_TYPES[s.keyword].nodes)))
    parameters = parameters_of(deck, s)
    return [i for i in range(len(s.values)) if parameters[i].of == "element" or parameters[i].of.endswith("node")]


def _stride(deck: Deck) -> int:
    return max(s.integer(i) for s, places in _with_references(deck) for i in places)


def _places(single: Mechanism, together: Mechanism, n: int, stride: int) -> tuple[np.ndarray, np.ndarray]:
    """Where the coordinates and deformations of every case are, (n, nx) and (n, ne)."""
    one, all_ = single.numbering, together.numbering
    node, coordinate = np.array([one.x_owner(i) for i in range(one.nx)]).T
    shift = stride * np.arange(n)[:, None]
    x = all_.lnp[node + shift - 1, coordinate - 1] - 1
    owners = np.array([one.e_owner(i) for i in range(one.ne)]).reshape(-1, 2)
    number, mode = owners.T
    e = all_.le[np.maximum(number, 1) + shift - 1, mode - 1] - 1
    if len(one.normalization):
        row = dict(all_.normalization.tolist())
        for i in np.flatnonzero(number < 0):
            e[:, i] = [row[int(m)] for m in -number[i] + shift[:, 0]]
    return x, e
