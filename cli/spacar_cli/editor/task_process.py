"""A process that answers the questions of the page; another one takes its place when it does not answer or dies.

What it is asked may take long, or more memory than there is. A pipe carries the questions and the answers.
"""

import contextlib
import os
import signal
import warnings
from multiprocessing import get_context
from multiprocessing.connection import Connection
from threading import Lock
from typing import Any

from spacar.errors import UsageError

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
TO_BEGIN = 120.0  # seconds in which a new process is ready, on a busy machine as well
SPAWN = get_context("spawn")


def answer_until_the_end(pipe: Connection) -> None:
    """What the process does: says that it is ready, then a JSON text for each (task, arguments)."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the server
    warnings.simplefilter("ignore")
    os.environ.update(ONE_THREAD)  # read when NumPy is imported
    from spacar_cli.editor.model_tasks import answered

    with contextlib.suppress(EOFError, OSError):  # the server has ended
        pipe.send("ready")
        while True:
            pipe.send(answered(*pipe.recv()))


class TaskProcess:
    """One process, started when it is first asked; questions wait for each other."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._process: Any = None

    def ask(self, task: str, arguments: dict[str, Any], seconds: float) -> str:
        """The answer, JSON. Raises UsageError with the reason why there is none; the process is another one after a
        death and after `seconds` without an answer, in which the time to begin does not count."""
        with self._lock:
            try:
                if self._process is None or not self._process.is_alive():
                    self._begin()
                self._pipe.send((task, arguments))
                if self._pipe.poll(seconds):
                    return str(self._pipe.recv())
            except (EOFError, OSError):
                self._end()
                raise UsageError(f"{task}: the process ended without an answer; another one is started",
                                 "edit.died") from None  # fmt: skip
            self._end()
            text = f"{task}: no answer within {seconds:g} s; the process was stopped and another one is started"
            raise UsageError(text, "edit.hung")

    def _begin(self) -> None:
        """Raises OSError when it is not ready in time, EOFError when it dies."""
        self._end()
        self._pipe, theirs = SPAWN.Pipe()
        self._process = SPAWN.Process(target=answer_until_the_end, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()  # so that its death is the end of the pipe
        if not self._pipe.poll(TO_BEGIN):
            raise OSError
        self._pipe.recv()

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
            self._process = None

    def close(self) -> None:
        """End the process; a question that waits gets no answer."""
        process = self._process
        if process is not None:
            process.kill()
        with self._lock:
            self._end()
