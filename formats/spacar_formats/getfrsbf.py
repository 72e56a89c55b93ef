"""getfrsbf: one variable of a result file, at all or at selected steps (reference/files.md section 4)."""

import os
import re
from collections.abc import Iterable

import numpy as np

from spacar.errors import UsageError
from spacar_formats.locate import open_result

_RANGE = re.compile(r"(-?\d+|end)(?::(\d+|end))?(?::(\d+|end))?")


def getfrsbf(
    name: str | os.PathLike[str], ident: str, steps: int | str | Iterable[int] | None = None
) -> np.ndarray | list[str]:
    """Value of the variable `ident` (any case, short or MATLAB name) of the file `name` (extension optional).

    `steps` counts from 1: a number, several, or text as for `step_numbers`. One step gives (rows, cols),
    several give (number of steps, rows*cols) with the values of a step column after column; text gives a list
    of lines. Raises UsageError for a missing file, variable or step and SbfError for damaged bytes.
    """
    with open_result(name) as file:
        return file.get(ident, step_numbers(steps, file.steps) if isinstance(steps, str) else steps)


def step_numbers(text: str, last: int) -> int | list[int]:
    """Step numbers as MATLAB writes them: `7`, `end`, `2:5`, `1:10:end`, `1,4,9`; `-1`: the last. Raises UsageError."""
    chosen: list[int] = []
    for word in text.replace(" ", "").split(","):
        match = _RANGE.fullmatch(word)
        if match is None:
            raise UsageError(f"'{word}' is no step; write for example 3, end, 2:5, 1:10:end or 1,4,9", "files.step")
        first, *rest = [last if w == "end" else int(w) for w in match.groups() if w is not None]
        if first < 0:
            first += last + 1
        if not rest:
            if first < 1 and word.startswith("-"):
                raise UsageError(f"the step {word} does not exist: the file has steps 1 to {last}", "files.step")
            chosen.append(first)
            continue
        increment, stop = (rest[0], rest[1]) if len(rest) == 2 else (1, rest[0])
        if increment == 0 or first < 1 or stop > last or first > stop:
            raise UsageError(f"the steps {word} do not exist: the file has steps 1 to {last}", "files.step")
        chosen += range(first, stop + 1, increment)
    return chosen[0] if len(chosen) == 1 else chosen


def stored_step(at: int, count: int, of: object) -> int:
    """The number of a stored step, from the end where it is negative. Raises UsageError."""
    step = count + 1 + at if at < 0 else at
    if not 1 <= step <= count:
        raise UsageError(f"step {at} does not exist: {of} has steps 1 to {count}", "files.step")
    return step


def as_json(ident: str, value: np.ndarray | list[str]) -> dict[str, object]:
    """`{"id", "shape", "data"}`: `numpy.array(data).reshape(shape)` is the value; infinite numbers stay Infinity."""
    if isinstance(value, list):
        return {"id": ident, "shape": [len(value)], "data": value}
    return {"id": ident, "shape": list(value.shape), "data": value.ravel().tolist()}


def as_lines(value: np.ndarray | list[str]) -> list[str]:
    """One line a row, with all digits that a number needs to be read back exactly."""
    return value if isinstance(value, list) else [" ".join(map(repr, row)) for row in value.tolist()]
