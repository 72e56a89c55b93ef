"""The process behind the page: replaced when it hangs or dies; and it imports nothing of the user."""

import json
import os
import signal
from pathlib import Path
from threading import Timer

import pytest
from spacar_cli.editor.task_process import TaskProcess

from spacar.errors import UsageError
from tests.examples import DATA


@pytest.fixture
def process():
    made = TaskProcess()
    yield made
    made.close()


def asked(process: TaskProcess, seconds: float = 60) -> int:
    """The number of the process that answered."""
    assert json.loads(process.ask("progress", {"file": "none.dat"}, seconds))["result"]["steps"] == 0
    return process._process.pid


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no process can be stopped")
@pytest.mark.parametrize(("dies", "seconds", "told"), [
    (False, 0.3, r"no answer within 0\.3 s"), (True, 60, "ended without an answer"),
])  # fmt: skip
def test_one_that_hangs_or_dies_is_replaced(process, dies, seconds, told):
    first = asked(process)
    os.kill(first, signal.SIGSTOP)
    if dies:
        Timer(0.2, os.kill, (first, signal.SIGKILL)).start()
    with pytest.raises(UsageError, match=told):
        asked(process, seconds)
    assert asked(process) != first


def test_one_that_died_between_two_questions_is_replaced(process):
    first = asked(process)
    process._process.kill()
    process._process.join()
    assert asked(process) != first


def test_the_time_to_begin_is_not_that_of_an_answer(process, monkeypatch):
    """On a busy machine no process would live to give one."""
    monkeypatch.setattr("spacar_cli.editor.task_process.TO_BEGIN", 0.0)
    with pytest.raises(UsageError, match="ended without an answer"):
        asked(process)


def test_the_worker_answers_and_survives_what_is_no_model(process, tmp_path):
    """Also texts that are no text: everything is an answer."""
    path = str(tmp_path / "some.dat")
    for text in ("", "PLBEAM", "\x00\ud800 %", "PLBEAM 1 1 2 3 4\nX 3 1e308 1e308\nEND HALT\n", "END\n" * 50):
        for task in ("check", "picture"):
            answer = json.loads(process.ask(task, {"text": text, "file": path}, 30))
            assert "internal" not in answer.get("error", ""), answer
    assert "error" in json.loads(process.ask("result", {"file": path}, 30))


def test_no_user_function_is_executed_while_typing(process, tmp_path):
    """check, picture and freedom of a model with USERSIG: its file would leave a mark."""
    (tmp_path / "evil.py").write_text("open('mark', 'w')\ndef evil(t, state):\n    return []\n")
    text = (DATA / "fourbar.dat").read_text().replace("STARTDE", "USERSIG EVIL\nSTARTDE")
    path = str(tmp_path / "some.dat")
    found = json.loads(process.ask("check", {"text": text, "file": path}, 30))["result"]
    assert [m["code"] for m in found["messages"]] == ["user-function.listed"]
    for task in ("picture", "freedom"):
        assert "result" in json.loads(process.ask(task, {"text": text, "file": path}, 30))
    assert not list(tmp_path.glob("**/mark"))
    assert not Path("mark").exists()
