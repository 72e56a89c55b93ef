"""The process behind the page: replaced when it hangs or dies; and it imports nothing of the user."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import pytest
from spacar_cli.editor.task_process import TaskProcess

from spacar.errors import UsageError

DATA = Path(__file__).parents[2] / "data"
# Answers with its process number; hangs, dies or floods when it is told to.
STUB = """
import json, os, sys, time
for line in sys.stdin:
    task = json.loads(line)["task"]
    if task == "hang":
        time.sleep(60)
    if task == "die":
        os._exit(3)
    print(json.dumps({"result": [task, os.getpid(), "x" * 300000]}), flush=True)
"""


@pytest.fixture
def process():
    made = TaskProcess([sys.executable, "-c", STUB])
    yield made
    made.close()


def test_one_that_hangs_is_replaced(process):
    first = json.loads(process.ask("one", {}, 20))["result"][1]
    begun = time.monotonic()
    with pytest.raises(UsageError, match=r"no answer within 0\.3 s"):
        process.ask("hang", {}, 0.3)
    assert time.monotonic() - begun < 5
    task, second, _ = json.loads(process.ask("two", {}, 20))["result"]
    assert task == "two"
    assert second != first


def test_one_that_dies_is_replaced(process):
    first = json.loads(process.ask("one", {}, 20))["result"][1]
    with pytest.raises(UsageError, match="ended without an answer"):
        process.ask("die", {}, 20)
    assert json.loads(process.ask("two", {}, 20))["result"][1] != first


def test_the_worker_answers_and_survives_what_is_no_model(tmp_path):
    """Also texts that are no text: everything is an answer."""
    process = TaskProcess()
    path = str(tmp_path / "some.dat")
    try:
        for text in ("", "PLBEAM", "\x00\ud800 %", "PLBEAM 1 1 2 3 4\nX 3 1e308 1e308\nEND HALT\n", "END\n" * 50):
            answer = json.loads(process.ask("check", {"text": text, "file": path}, 30))
            assert "internal" not in answer.get("error", ""), answer
            answer = json.loads(process.ask("picture", {"text": text, "file": path}, 30))
            assert "internal" not in answer.get("error", ""), answer
        assert "error" in json.loads(process.ask("result", {"file": path}, 30))
    finally:
        process.close()


def test_no_user_function_is_executed_while_typing(tmp_path):
    """check, picture and freedom of a model with USERSIG: its file would leave a mark."""
    (tmp_path / "evil.py").write_text("open('mark', 'w')\ndef evil(t, state):\n    return []\n")
    text = (DATA / "fourbar.dat").read_text().replace("STARTDE", "USERSIG EVIL\nSTARTDE")
    process = TaskProcess()
    path = str(tmp_path / "some.dat")
    try:
        found = json.loads(process.ask("check", {"text": text, "file": path}, 30))["result"]
        assert [m["code"] for m in found["messages"]] == ["user-function.listed"]
        for task in ("picture", "freedom"):
            assert "result" in json.loads(process.ask(task, {"text": text, "file": path}, 30))
    finally:
        process.close()
    assert not list(tmp_path.glob("**/mark"))
    assert not Path("mark").exists()
