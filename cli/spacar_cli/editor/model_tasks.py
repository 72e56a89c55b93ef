"""What the page asks about the text in its editor and about results: a function for each question, JSON in and out.

They run in a process of their own (`task_process`). Nothing of the user's Python files is imported here: functions are
listed; runs execute them.
"""

import json
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from spacar_drawing.curves import evaluate, in_units
from spacar_drawing.history import axis_text
from spacar_drawing.live_picture import free_motions, motion_model, motion_of_freedom, start_model, start_source
from spacar_drawing.mechanism_picture import chosen_steps
from spacar_drawing.mode_shapes import ModeShape, modes_of
from spacar_drawing.picture_source import PictureSource, open_source
from spacar_drawing.viewer_page import view_model
from spacar_formats.locate import open_result
from spacar_formats.safety import part_path

from spacar.calls import has_interval, run
from spacar.deck import Deck
from spacar.deck.deck import parse
from spacar.deck.lexer import visualization_of
from spacar.errors import InputError, SpacarError, UsageError, type_and_text
from spacar.kinematics.advice import HINGE, KEEPS, REDUNDANT
from spacar.kinematics.release import release
from spacar.mechanism.user_files import without_functions
from spacar.modes import MODES
from spacar_cli.commands.check import CheckedDeck, checked_deck
from spacar_cli.editor.edited_file import result_file
from spacar_cli.releasing import as_record

Answer = dict[str, Any]
MOST_NAMES = 60  # degrees of freedom that are listed
MOST_MODES = 12  # vibration or buckling modes that are listed


def deck_of_text(text: str, file: str, mode: int | None) -> Deck:
    beside = Path(file).with_suffix(".spv")
    settings = visualization_of(beside.read_text("utf-8", "replace")) if beside.is_file() else None
    return parse(text, Path(file).name, mode, path=Path(file), visualization=settings)


@lru_cache(2)
def _checked(text: str, file: str) -> CheckedDeck:
    return checked_deck(lambda: deck_of_text(text, file, None), Path(file), None, text)


def check(text: str, file: str) -> Answer:
    found = _checked(text, file)
    messages = [
        {"severity": m.severity, "line": m.line, "keyword": m.keyword, "text": m.text, "code": m.code,
         "here": m.file == Path(file).name}
        for m in found.messages + found.drawing
    ]  # fmt: skip
    ready = found.deck is not None and found.error is None
    return {"messages": messages, "drawable": ready, "modes": fitting_modes(found.deck) if ready and found.deck else []}


def fitting_modes(deck: Deck) -> list[Answer]:
    """The modes whose blocks and statements a deck has, with what tells how far a run is."""
    interval = deck.last("TIMESTEP", block=2)
    duration = None if interval is None else interval.real(0)
    found = []
    for mode in MODES.values():
        fits = not mode.forces or 2 in deck.spans
        fits &= not mode.integrated or has_interval(deck)
        fits &= mode.third is None or (deck.third is not None and deck.third.name.lower() == mode.third)
        fits &= not mode.stationary or (deck.third is None or deck.third.name != "TRAJECTORY")
        if fits:
            length = duration if mode.integrated else None
            found.append({"number": mode.number, "title": mode.title, "duration": length})
    return found


def picture(text: str, file: str) -> Answer:
    """The start position. Raises UsageError for a text that is wrong, and where there is nothing to draw."""
    found = _checked(text, file)
    if found.mechanism is None:
        raise UsageError("the text has errors", "edit.text")
    return start_model(found.mechanism)


def freedom(text: str, file: str) -> Answer:
    """Degrees of freedom, over- and under-constraints of the start position (mode 0), and the lines of releases."""
    result = run(0, without_functions(deck_of_text(text, file, 0)))
    n, found = result.mechanism.numbering, result.header["diagnosis"]
    inserted = [
        {"line": f"RLSE {p.element} {p.mode}", "text": f"{p.name}: {p.text}", "keeps": p.effect in KEEPS}
        for p in found.advice
        if p.effect in KEEPS or REDUNDANT <= p.effect <= HINGE
    ]
    return as_record(found) | {
        "nx": n.nx, "ne": n.ne, "ndof": n.ndof, "names": list(n.q_names[:MOST_NAMES]), "insert": inserted,
        "releasable": any(p.effect in KEEPS for p in found.advice),
    }  # fmt: skip


def released(text: str, file: str) -> Answer:
    found = release(deck_of_text(text, file, 0))
    return {"text": found.deck.text, "left": found.left, "released": len(found.parts)}


def motion(text: str, file: str, name: str = "", under: int = 0) -> Answer:
    """Pictures of the motion of one degree of freedom, or of an under-constraint (from 1)."""
    result = run(0, without_functions(deck_of_text(text, file, 0)))
    mechanism = result.mechanism
    if name:
        return motion_model(start_source(mechanism), mechanism.x0, motion_of_freedom(mechanism, name), name)
    gradient = result.frames[0].bigd
    if gradient is None:
        raise UsageError("the model is too large to look for the motions of its under-constraints", "edit.large")
    motions = free_motions(mechanism, gradient)
    if not 1 <= under <= len(motions):
        raise UsageError(f"there is no under-constraint {under}", "edit.motion")
    return motion_model(start_source(mechanism), mechanism.x0, motions[under - 1], f"under-constraint {under}")


def result(file: str) -> Answer:
    """A finished run: its pictures, and its vibration and buckling modes. Raises UsageError for one of another text."""
    source = _opened(file)
    shapes = [mode.label for mode in _shapes(source)]
    return {"model": view_model(source), "shapes": shapes, "stationary": source.scene.analysis.stationary}


def shape(file: str, number: int) -> Answer:
    """Pictures of one of the modes that `result` lists (from 0), at its last load step."""
    source = _opened(file)
    modes = _shapes(source)
    if not 0 <= number < len(modes):
        raise UsageError("there is no such mode", "edit.mode")
    step = chosen_steps(source, None, None, False)[0]
    return motion_model(source, np.ravel(source.x(step)), modes[number].motion, modes[number].label)


def _opened(file: str) -> PictureSource:
    """The result beside the file, or what a run left that did not finish."""
    written = result_file(Path(file), "sbd")
    unfinished = part_path(written)
    return open_source(unfinished if unfinished.is_file() and not written.is_file() else written)


def _shapes(source: PictureSource) -> list[ModeShape]:
    mode, step = source.scene.analysis, chosen_steps(source, None, None, False)[0]
    given = {"vibration": mode.linearized and not mode.integrated, "buckling": mode.buckling}
    return [m for kind, has in given.items() if has for m in modes_of(source, kind, step)[:MOST_MODES]]


def curve(file: str, expressions: list[str]) -> Answer:
    source = _opened(file)
    metre = source.scene.metre
    found = [in_units(evaluate(source, text), metre) for text in ("t", *expressions)]
    # numbers that JSON does not have are gaps
    columns = [[v if np.isfinite(v) else None for v in c.values.tolist()] for c in found]
    stationary = source.scene.analysis.stationary
    names = ["load step" if stationary else "t (s)", *(axis_text(c) for c in found[1:])]
    return {"names": names, "columns": columns}


def progress(file: str) -> Answer:
    part = part_path(result_file(Path(file), "sbd"))
    if not part.is_file():
        return {"steps": 0, "t": None}
    read = open_result(part, verify=False)
    return {"steps": read.steps, "t": read.time(read.steps) if read.steps else None}


TASKS: dict[str, Callable[..., Answer]] = {
    f.__name__: f for f in (check, picture, freedom, released, motion, result, shape, curve, progress)
}


def answered(task: str, arguments: Answer) -> str:
    """{"result": ...} or {"error": text} as JSON."""
    try:
        return json.dumps({"result": TASKS[task](**arguments)}, allow_nan=False)
    except InputError as error:
        return json.dumps({"error": str(error.messages[0]) if error.messages else str(error)})
    except SpacarError as error:
        return json.dumps({"error": str(error)})
    except Exception as error:
        return json.dumps({"error": f"internal error: {type_and_text(error)} (please report it)"})
