"""The process that answers the questions of the page: a line of JSON for each on standard input, one as its answer.

`python -m spacar_cli.editor.task_worker`. What it is asked may end it: `task_process` starts another one then.
"""

from __future__ import annotations

import json
import os
import sys
import warnings

from spacar.errors import InputError, SpacarError


def answered(line: str) -> str:
    """The answer to one line: {"result": ...} or {"error": text}."""
    from spacar_cli.editor.model_tasks import TASKS

    asked = json.loads(line)
    try:
        return json.dumps({"result": TASKS[asked["task"]](**asked["arguments"])}, allow_nan=False)
    except InputError as error:
        return json.dumps({"error": str(error.messages[0]) if error.messages else str(error)})
    except SpacarError as error:
        return json.dumps({"error": str(error)})
    except Exception as error:
        text = " ".join(str(error).split())
        return json.dumps({"error": f"internal error: {type(error).__name__}: {text} (please report it)"})


def main() -> None:
    """Answer until standard input ends."""
    warnings.simplefilter("ignore")
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # nobody else writes answers
    for line in sys.stdin:
        answers.write(answered(line) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
