"""The two calls that everybody uses, `frames` (a stream) and `run` (a result), and the doors of their arguments.

`deck_of`: a path, a Deck or a Model becomes a checked deck; every call that takes a model goes through.
`checked_options`: what replaces numbers of the deck, fields of SolverSettings, checked as the deck's numbers are.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import fields
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from spacar.deck import Deck, read_deck
from spacar.deck.rewrite.refine import refine_divisible, rigid
from spacar.deck.table_solvers import INTEGRATOR_ALIASES, INTEGRATORS, alias_note
from spacar.errors import UsageError
from spacar.mechanism import SolverSettings, build
from spacar.modes import Mode, find_mode
from spacar.stream import AccuracyRequest, Run

if TYPE_CHECKING:
    from spacar.deck.model import Model
    from spacar.deck.table_types import Purpose
    from spacar.result import Result


POSITIVE = ("atol", "rtol", "step", "duration", "n_steps")
BEAMS = ("angle", "sine")  # measures of the deformations of beams and tubes
# name -> type, which is a text as that module postpones its annotations
OPTIONS = {f.name: str(f.type).removesuffix(" | None") for f in fields(SolverSettings)}
KINDS: dict[str, tuple[Any, Any, str]] = {  # type -> how it is made, of what, in words
    "bool": (bool, (bool, np.bool_), "True or False"), "int": (int, Integral, "a whole number"),
    "float": (float, Real, "a number"), "str": (str, str, "a word"),
}  # fmt: skip
LARGEST = {"rtol": 1.0, "n_steps": 10**15}  # an error of 100 %; times that still differ


def checked_options(options: dict[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """The options as `SolverSettings` takes them, None left out, and what the log must say about them.

    Raises UsageError for an unknown option, a value of the wrong type, one that is not positive or not finite where it
    must be, and an integration method that does not exist.
    """
    found, notes = {}, []
    for name, value in options.items():
        if name not in OPTIONS:
            raise UsageError(f"there is no option '{name}'; the options are {', '.join(OPTIONS)}", "usage.option")
        if value is None:
            continue
        v = found[name] = _converted(name, value)
        for wrong, rule in (
            (name in POSITIVE and not 0 < v < np.inf, "must be positive and finite"),
            (name == "modes" and v < 0, "must not be negative (0: all)"),
            (name in LARGEST and v > LARGEST[name], f"is at most {LARGEST.get(name, 0):g}"),
            (name == "beams" and v not in BEAMS, f"is one of {', '.join(BEAMS)}"),
        ):
            if wrong:
                raise UsageError(f"the option {name} = {value!r} {rule}", "usage.option")
        if name == "integrator":
            found[name], note = integrator(found[name])
            notes += [note] if note else []
    return found, notes


def _converted(name: str, value: Any) -> Any:
    """The value as a number of the kind that the option has; NumPy's numbers are numbers too."""
    kind, types, wanted = KINDS[OPTIONS[name]]
    if not isinstance(value, types) or (isinstance(value, bool) and kind is not bool):
        raise UsageError(f"the option {name} = {value!r} must be {wanted}, not {type(value).__name__}", "usage.option")
    return kind(value)


def texts(name: str, given: object) -> tuple[str, ...]:
    """One text or several. Raises UsageError for anything else."""
    found = tuple(given) if isinstance(given, Iterable) and not isinstance(given, str) else (given,)
    if not all(isinstance(text, str) for text in found):
        raise UsageError(f"{name} is a text or a list of texts, not {given!r:.60}", "usage.text")
    return found


def path_of(given: object) -> Path:
    """The path of a file. Raises UsageError for what is none."""
    if isinstance(given, str | os.PathLike):
        return Path(given)
    raise UsageError(f"a path is a text or a Path, not {given!r:.60}", "usage.path")


def integrator(code: int, subject: str = "integrator type") -> tuple[int, str | None]:
    """The integration method of this code, and the note on an alias (the sentence of INTEGRAT). Raises UsageError."""
    if code in INTEGRATOR_ALIASES:
        return INTEGRATOR_ALIASES[code], alias_note(code)
    if code not in INTEGRATORS:
        known = ", ".join(map(str, sorted((*INTEGRATORS, *INTEGRATOR_ALIASES))))
        raise UsageError(f"{subject} {code} does not exist; the methods are {known}", "usage.integrator")
    return code, None


def check_modes(mode: Mode, wanted: int | None) -> None:
    """Raises UsageError when modes of vibration are asked for of a mode that stores only matrices along a motion."""
    if mode.takes_setpoints and wanted:
        text = f"mode {mode.number} computes no modes of vibration: the option modes = {wanted} can only be 0"
        raise UsageError(f"{text} (A, B, C, D and reduced matrices of a model of any size)", "usage.option")


Source: TypeAlias = "str | os.PathLike[str] | Deck | Model"


def deck_of(source: Source, mode: Purpose) -> Deck:
    """The checked deck of a path, a Model or a Deck, for a mode (as `read_deck`).

    Raises UsageError for anything else and for a file that cannot be read, InputError for a wrong model.
    """
    if isinstance(source, str | os.PathLike):
        return read_deck(Path(source), mode)
    if isinstance(source, Deck):
        # its checks and its third block are those of the mode it was read for
        return source if source.mode == mode else source.for_mode(mode)
    if callable(getattr(source, "deck", None)):  # a Model, which is not imported to ask for it
        return source.deck(mode)
    text = f"a model is the path of an input file, a Deck or a Model, not {source!r:.60} ({type(source).__name__})"
    raise UsageError(text, "usage.model")


def has_interval(deck: Deck) -> bool:
    """Does mode 1 suit a model, because it has a time interval? Else mode 7 does."""
    return bool(deck.of("TIMESTEP", block=2))


def frames(
    mode: int, source: Source, *, nominal: Any = None, accuracy: float | bool | None = None,
    variables: str | Sequence[str] = (), mesh: bool = True, elements: int = 1, rigid_beams: bool = False,
    **options: Any,
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
    if prepared.mechanism.user_signal is not None and prepared.mechanism.deck.divided:
        prepared.report.add(
            "warning: beams are divided: a stress that the function of USERSIG gives to one of them, and the"
            " deformations that it gets of it, are those of its first part"
        )
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
    mode: Mode, accuracy: float | bool | None, variables: str | Sequence[str], mesh: bool
) -> AccuracyRequest | None:
    """What is asked of the error of the result. Raises UsageError."""
    wanted = texts("variables", variables)
    if accuracy is None or accuracy is False:
        if wanted:
            raise UsageError("the variables are those whose accuracy is asked for; give an accuracy", "usage.accuracy")
        return None
    if not (mode.integrated or mode.stationary):
        text = f"an accuracy is asked of motions and stationary solutions (1, 4, 7 to 10), not of mode {mode.number}"
        raise UsageError(text, "usage.accuracy")
    if mode.stationary and not mesh:
        text = "the accuracy of a stationary solution is that of its mesh, which is not to be looked at"
        raise UsageError(text, "usage.accuracy")
    if accuracy is True:
        return AccuracyRequest(None, wanted, mesh)
    if not isinstance(accuracy, Real) or not 0.0 < accuracy < 1.0:
        raise UsageError(f"the accuracy {accuracy!r} must be a number between 0 and 1", "usage.accuracy")
    return AccuracyRequest(float(accuracy), wanted, mesh)


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
