"""`spacar spacntrl FILE`: feedback folded into a time-varying linear system."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from spacar.errors import BY_USERS, AnalysisError, UsageError, type_and_text
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes


@words.command("spacntrl")
@words.option("kp", ": numbers (its diagonal) such as 100,50, FILE.csv, or FILE.py:NAME.")
@words.option("kd", ", as K_P")
@words.option("omega", ": K_P = omega^2 M0 and, with --damping, K_D = 2 damping omega M0.")
@words.option("damping", default=0.0)
@words.option("output", "; default FILEkp.ltv")
def command(
    environment: Environment, file: str, kp: str | None, kd: str | None, omega: float | None, damping: float,
    output: Path | None,
) -> None:  # fmt: skip
    """Add feedback of the actuated coordinates to the system of an .ltv file: K_P enters K0B and A, K_D C0B and A.

    A function is called with -1 first, then with every step 1, 2, ...; it returns a square matrix, one row per nominal
    input. A .csv file has such a matrix in every line, column after column: a line a step, or one for all.
    """
    from spacar_formats.locate import result_path
    from spacar_formats.ltvfile import read_ltv, write_ltv

    from spacar.simulation.feedback import tracking_gains, with_gain

    if (kp is None) == (omega is None):
        raise UsageError("give either --kp or --omega", "usage.gain")
    data, warnings = read_ltv(file)
    path = result_path(file, "ltv")
    if omega is not None:
        proportional, derivative = tracking_gains(data, omega, damping)
    else:
        proportional = _gain(str(kp), data.n_nominal, len(data.t))
        derivative = None
    if kd is not None:
        derivative = _gain(kd, data.n_nominal, len(data.t))
    target = output or path.with_name(f"{path.stem}kp.ltv")
    write_ltv(with_gain(data, proportional, derivative), target, path)
    tell_notes(environment, warnings)
    environment.wrote(target)


def _gain(text: str, count: int, steps: int) -> Any:
    """(count, count) from numbers, (steps, count, count) from a function. Raises UsageError."""
    import numpy as np
    from spacar_formats.block_makers import load_function

    if ".py:" in text:
        function = load_function(Path(text), lambda reason: UsageError(reason, "usage.gain"))
        found = [_called(function, text, k) for k in (-1, *range(1, steps + 1))][1:]
        try:
            return np.array([np.atleast_2d(np.asarray(gain, float)) for gain in found])
        except (TypeError, ValueError) as error:
            raise UsageError(f"{text} does not return square matrices of numbers: {error}", "usage.gain") from None
    if text.lower().endswith(".csv"):
        return _table(Path(text), count, steps)
    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        raise UsageError(f"'{text}' is neither a list of numbers nor FILE.csv nor FILE.py:NAME", "usage.gain") from None
    if len(numbers) not in (1, count):
        raise UsageError(f"{len(numbers)} gains for {count} nominal inputs", "usage.gain")
    return np.diag(numbers * (count if len(numbers) == 1 else 1))


def _called(function: Callable[[int], Any], text: str, step: int) -> Any:
    """Its answer. Raises AnalysisError."""
    try:
        return function(step)
    except BY_USERS as error:  # a user's function may fail in any way
        why = f"{text} failed at step {step}: {type_and_text(error)}"
        raise AnalysisError(why, "user-function.failed") from error


def _table(path: Path, count: int, steps: int) -> Any:
    """(steps, count, count) from a file with a line a step, or one for all. Raises UsageError."""
    import numpy as np

    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2)
    except OSError as error:
        raise UsageError(f"cannot open {path}: {error.strerror or error}", "usage.gain") from None
    except ValueError as error:
        raise UsageError(f"{path} is no table of numbers: {error}", "usage.gain") from None
    if rows.shape not in ((1, count * count), (steps, count * count)):
        text = f"{path} has {rows.shape[0]} lines of {rows.shape[1]} numbers"
        raise UsageError(f"{text}, {steps} (or 1) of {count * count} are needed", "usage.gain")
    return np.broadcast_to(rows, (steps, count * count)).reshape(steps, count, count).swapaxes(1, 2)
