"""Many cases of one mechanism at once: forward dynamics of decks that differ in numbers only.

The cases become one mechanism of N disjoint copies: case k has the nodes and elements of the first one, their numbers
raised by k times the largest number. So every element family evaluates n N elements along its element axis, the
matrices are block diagonal and factored in one call (band storage: the bandwidth is that of one case), and the overhead
of NumPy calls, which is most of the time of a small mechanism, is paid once for all. Since coordinates are numbered by
class, then node, case k holds the same places of every class as the single mechanism.

All cases share the steps. The error norm of a step is never smaller than the largest norm of a case: the norm of
method 0 is a sum over the state, that of the Runge-Kutta methods a mean, whose tolerance is therefore divided by
sqrt(N). So every case is at least as accurate as alone; one demanding case makes all of its batch take small steps.

Where the mechanism has a compiled form, the copies only give the numbers: C evaluates one mechanism for several cases
at a time, in the lanes of the processor's vectors (spacar.compiled.cases), and every case keeps the tolerance.

Not for: modes other than 1, user functions, wheels and other slips, implicit methods (dense Jacobian), cases whose
statements, settings or GRAVITY differ. An error in one case ends the batch; `spacar.studies.batched_cases` then
runs its cases one by one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from spacar.arrays import Array
from spacar.deck import ELEMENT_TYPES, Deck, Statement
from spacar.dynamics.array_evaluator import Dynamics
from spacar.errors import AnalysisError, Report, UsageError
from spacar.forward.displaced import displaced
from spacar.forward.driver import Tolerances, frames, integrated, watched, work
from spacar.frame import Frame, StoredFrames
from spacar.integrators import METHODS
from spacar.mechanism import Mechanism, build
from spacar.result import Result
from spacar.studies.assignments import parameters_of
from spacar.studies.reduced import ReducedCopies

X_FIELDS = ("x", "xd", "xdd", "fx", "fxgrav", "fxtot")
E_FIELDS = ("e", "ed", "edd", "sig")
METHOD_WITH_SUM = 0  # the norm of this method does not shrink with the number of cases
WITHOUT_LANES = (220, 225)  # want a state of positions first, then velocities


def why_not(deck: Deck, **options: Any) -> str:
    """Why the cases of a deck cannot be run together; empty when they can."""
    if deck.of("USERSIG", "USERINP", block=2):
        return "user functions are called for one mechanism"
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
    return ""


def alike(a: Deck, *others: Deck) -> bool:
    """Whether decks are cases of one mechanism: the same statements, references and settings."""
    statements = [(s, _references(a, s)) for s in _statements(a)]
    return all(_like(statements, _statements(other)) for other in others)


def _like(statements: list[tuple[Statement, list[int]]], others: list[Statement]) -> bool:
    if len(statements) != len(others):
        return False
    for (s, references), o in zip(statements, others, strict=True):
        if s.keyword != o.keyword or len(s.values) != len(o.values) or (not references and s.values != o.values):
            return False
        if any(s.values[i] != o.values[i] for i in references):
            return False
    return True


def ensemble(decks: Sequence[Deck], times: np.ndarray | None = None, **options: Any) -> list[Result]:
    """Results of mode 1 of every deck at the same times (default TIMESTEP), as `spacar.run` gives them.

    `options` as for `spacar.run`. Raises UsageError for decks that cannot be batched, AnalysisError when a case fails.
    """
    first = decks[0]
    reason = why_not(first, **options)
    if reason or not alike(first, *decks[1:]):
        raise UsageError(
            f"the cases cannot be run together: {reason or 'they differ in more than numbers'}", "study.batch"
        )
    from spacar.compiled import why_general, why_not_in_lanes

    single = build(first, 1, **options)
    together = build(copies(decks), 1, **options)
    settings = single.settings
    if times is None:
        assert settings.duration is not None
        times = np.linspace(0.0, settings.duration, settings.n_steps + 1)
    x_of, e_of = _places(single, together, len(decks), _stride(first))
    if settings.integrator not in WITHOUT_LANES and not (why_general(single) or why_not_in_lanes(single)):
        return _in_lanes(single, together, times, x_of, e_of)
    found: list[list[Frame]] = [[] for _ in decks]
    for frame in _frames(together, times, x_of):
        x = [getattr(frame, name)[x_of] for name in X_FIELDS]
        e = [getattr(frame, name)[e_of] for name in E_FIELDS]
        for k, own in enumerate(found):
            values = {name: v[k] for name, v in zip((*X_FIELDS, *E_FIELDS), (*x, *e), strict=True)}
            own.append(Frame(t=frame.t, statistics=frame.statistics, **values))
    return [Result(single, 1, tuple(frames), (), {}) for frames in found]


def _in_lanes(single: Mechanism, together: Mechanism, times: Array, x_of: Array, e_of: Array) -> list[Result]:
    """Results of the compiled batch."""
    from spacar.compiled.cases import CompiledCases
    from spacar.compiled.numbers import of_copies

    settings = single.settings
    cases = CompiledCases(single, of_copies(single, together, x_of, e_of), _start(together, x_of, e_of))
    stored: list[dict[str, Array]] = []
    statistics: list[dict[str, int]] = []
    first = Dynamics(single)
    first.start()
    g = displaced(first)
    if g is not None:
        g = np.broadcast_to(g[None, :, None], cases.by_case).ravel()
    tolerances = Tolerances.of(settings, g=g)
    for out in integrated(cases, cases.y0, times, settings, tolerances, watch=cases.watch, back=cases.rejected):
        stored.append(cases.variables(float(out.t), out.y))
        statistics.append(work(out))
    arrays = {name: np.stack([s[name] for s in stored]).transpose(2, 0, 1) for name in (*X_FIELDS, *E_FIELDS)}
    results: list[Result] = []
    for k in range(len(x_of)):
        own = {name: array[k] for name, array in arrays.items()}
        results.append(Result(single, 1, StoredFrames(times, own, statistics), (), {}))
    return results


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
    references = [_references(first, s) for s in _statements(first)]
    for k, deck in enumerate(decks):
        for s, places in zip(_statements(deck), references, strict=True):
            if not places:
                statements += [s] * (k == 0)
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
    return max(s.integer(i) for s in _statements(deck) for i in _references(deck, s))


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


def _frames(mechanism: Mechanism, times: np.ndarray, x_of: np.ndarray) -> Iterator[Frame]:
    """Frames of the copies, with the common work in their statistics."""
    settings, n = mechanism.settings, len(x_of)
    method = METHODS[settings.integrator]
    dynamics = Dynamics(mechanism)
    y = dynamics.start()
    passed = Report()
    together = frames(
        dynamics, y, times, settings, Report(),
        watch=watched(dynamics, passed),
        divisor=float(np.sqrt(n)) if method.variable_step and method.code != METHOD_WITH_SUM else 1.0,
        moved_by=ReducedCopies(dynamics, x_of) if ReducedCopies.suits(mechanism, n) else None,
    )  # fmt: skip
    for _, frame in together:
        if passed.lines:  # each case says it in its own log
            raise AnalysisError("a case of the batch passed a dead point", "study.batch")
        yield frame
