"""The two calls that everybody uses: `frames` (a stream) and `run` (a result)."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Integral
from typing import TYPE_CHECKING, Any

from spacar.deck.rewrite.refine import refine_divisible
from spacar.deck.rewrite.simpler import rigid
from spacar.errors import UsageError
from spacar.mechanism import build
from spacar.modes import Mode, find_mode
from spacar.options import check_modes, checked_options
from spacar.sources import Source, deck_of
from spacar.stream import AccuracyRequest, Run

if TYPE_CHECKING:
    from spacar.result import Result


def frames(
    mode: int, source: Source, *, nominal: Any = None, accuracy: float | bool | None = None,
    variables: Sequence[str] = (), mesh: bool = True, elements: int = 1, rigid_beams: bool = False, **options: Any,
) -> Run:  # fmt: skip
    """Prepare an analysis: read, check and number the model; the frames come when the returned Run is iterated over.

    mode      0 to 4, 7 to 10, see MODES;  source   path of the input file, a Model, or a Deck, which is
              checked again when it was read for another mode
    nominal   mode 3 only: result of mode 2, or of modes 7 to 10
    accuracy  modes 1, 4, 7 to 10: error of the result over the amplitude of each variable, estimated and kept by
              several runs; True: only estimated. In `header["accuracy"]` of the result, and `xerr` of its frames
    variables expressions whose accuracy it is ('x[6,1]'); default: all free coordinates, in the stationary modes also
              reactions, the lowest frequencies and load multipliers
    mesh      False: the accuracy is that of the integration alone, the beams are not divided for it
    elements  equal beams in the place of each flexible beam that can be divided; results are those of the divided
              model, in which nodes of the file keep their numbers
    rigid_beams  the model with all dynamic deformations of its beams fixed
    options   override the deck for this run: atol, rtol, integrator, step, duration, n_steps, compiled (see Settings)

    Raises UsageError (unknown mode or option, wrong value of one), InputError (bad input) now; AnalysisError while
    iterating.

    >>> import spacar
    >>> for frame in spacar.frames(1, "data/crank.dat"):
    ...     if frame.t > 0.05:
    ...         break
    >>> frame.x.shape  # coordinates [m, rad]
    (10,)
    """
    found = find_mode(mode)
    options, notes = checked_options(options)
    check_modes(found, options.get("modes"))
    deck = deck_of(source, found.number)
    request = _accuracy(found, accuracy, variables, mesh)
    kept: dict[int, str] = {}
    if rigid_beams:
        deck = rigid(deck)
    if elements != 1:
        deck, kept = refine_divisible(deck, _pieces(elements))
    prepared = Run(found, build(deck, found.number, **options), nominal=nominal, accuracy=request)
    for note in notes:
        prepared.report.add(f"warning: {note}")
    for beam, reason in kept.items():
        prepared.report.add(f"warning: beam {beam} is not divided into {elements}: {reason}")
    if deck.of("RLSE", block=1):
        from spacar.kinematics.lost_stiffness import lost_stiffness

        for message in lost_stiffness(deck, prepared.mechanism):
            prepared.report.add(str(message))
        if prepared.mechanism.deck.divided:
            from spacar.kinematics.released_parts import released_parts

            for text in released_parts(prepared.mechanism, found):
                prepared.report.add(f"warning: {text}")
    return prepared


def _pieces(elements: object) -> int:
    """A whole number of beams in the place of one. Raises UsageError."""
    if isinstance(elements, bool) or not isinstance(elements, Integral) or elements < 1:
        raise UsageError(f"the option elements = {elements!r} must be a whole number from 1", "usage.option")
    return int(elements)


def _accuracy(
    mode: Mode, accuracy: float | bool | None, variables: Sequence[str], mesh: bool
) -> AccuracyRequest | None:
    """What is asked of the error of the result. Raises UsageError."""
    if accuracy is None or accuracy is False:
        if variables:
            raise UsageError("the variables are those whose accuracy is asked for; give an accuracy", "usage.accuracy")
        return None
    if not (mode.integrated or mode.stationary):
        text = f"an accuracy is asked of motions and stationary solutions (1, 4, 7 to 10), not of mode {mode.number}"
        raise UsageError(text, "usage.accuracy")
    if mode.stationary and not mesh:
        text = "the accuracy of a stationary solution is that of its mesh, which is not to be looked at"
        raise UsageError(text, "usage.accuracy")
    if accuracy is True:
        return AccuracyRequest(None, tuple(variables), mesh)
    if isinstance(accuracy, str) or not 0.0 < accuracy < 1.0:
        raise UsageError(f"the accuracy {accuracy!r} must be a number between 0 and 1", "usage.accuracy")
    return AccuracyRequest(float(accuracy), tuple(variables), mesh)


def run(mode: int, source: Source, *, nominal: Any = None, **options: Any) -> Result:
    """Run an analysis to its end and keep all frames in memory. Errors as `frames`.

    mode      0 to 4, 7 to 10, see MODES;  source   path of the input file, a Deck, or a Model
    nominal   mode 3 only: result of mode 2, or of modes 7 to 10
    options   accuracy, variables, elements, rigid_beams, and what overrides the deck, see `frames`

    >>> import spacar
    >>> result = spacar.run(1, "data/crank.dat")
    >>> result["x"].shape  # steps, coordinates [m, rad]
    (101, 10)
    """
    from spacar.result import Result  # the command line needs no results in memory

    return Result.collect(frames(mode, source, nominal=nominal, **options))
