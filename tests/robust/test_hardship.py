"""Little memory, clocks that jump, workers that die."""

import ast
import re
import sys
import types
from pathlib import Path

import pytest
from spacar_cli.commands.sweep import AHEAD, FEWEST, run_on_cluster

from spacar.studies.runs.workers import Lost

from .processes import model, shell

HOUSE = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("kilobytes", [30_000, 45_000, 250_000])
def test_little_memory_is_a_sentence_or_enough(tmp_path, kilobytes):
    """As `ulimit -v`. Between these, OpenBLAS ends the process in its own words before anything of ours runs."""
    model(tmp_path)
    status, _, err = shell(tmp_path, f"ulimit -v {kilobytes}; exec spacar 1 crank")
    assert status in (0, 1)
    if status:
        assert err.startswith("error: out of memory")
        assert len(err.splitlines()) == 1
        assert not (tmp_path / "crank.sbd").exists()
    else:
        assert (tmp_path / "crank.sbd").exists()


def test_no_decision_depends_on_the_clock_on_the_wall():
    """Durations come from monotonic clocks; the date is printed in the log and used for nothing."""
    found = []
    for folder in ("spacar", "formats", "cli"):
        for path in (HOUSE / folder).rglob("*.py"):
            text = path.read_text(encoding="utf-8")
            if not re.search(r"\.(time|now|localtime|gmtime|st_mtime|st_ctime|st_mtime_ns)\b", text):
                continue
            for node in ast.walk(ast.parse(text)):
                name = ast.unparse(node) if isinstance(node, ast.Attribute) else ""
                if name in ("time.time", "datetime.now", "datetime.datetime.now", "time.localtime", "time.gmtime"):
                    found.append((path.name, node.lineno))
                if name.endswith((".st_mtime", ".st_ctime", ".st_mtime_ns")):
                    found.append((path.name, node.lineno))
    assert not found


class Future:
    def __init__(self, key, outcome):
        self.key, self._outcome = key, outcome
        self.status = "error" if isinstance(outcome, Exception) else "finished"

    def result(self):
        return self._outcome

    def exception(self):
        return self._outcome


class KilledWorker(Exception):
    pass


class Client:
    """A scheduler whose workers die at every seventh case; it counts how many cases it holds at a time."""

    def __init__(self, **_):
        self.made = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def nthreads(self):
        return {"a": 1, "b": 2}

    def map(self, function, cases, pure):
        futures = []
        for case in cases:
            outcome = KilledWorker("worker died") if case % 7 == 0 else function(case)
            futures.append(Future(f"key-{self.made}", outcome))
            self.made += 1
        return futures


class AsCompleted:
    most = 0

    def __init__(self, futures):
        self.waiting = list(futures)

    def update(self, futures):
        self.waiting += futures

    def __iter__(self):
        while self.waiting:
            AsCompleted.most = max(AsCompleted.most, len(self.waiting))
            yield self.waiting.pop(0)


def test_dask_workers_that_die_lose_their_own_case_only(monkeypatch):
    fake = types.SimpleNamespace(Client=Client, as_completed=AsCompleted)
    monkeypatch.setitem(sys.modules, "distributed", fake)
    taken = []

    def cases():
        for k in range(1000):
            taken.append(k)
            yield k

    outcomes = {}
    for case, outcome in run_on_cluster(lambda k: k * k, cases(), "host:1"):
        outcomes[case] = outcome
        assert len(taken) - len(outcomes) <= max(FEWEST, 3 * AHEAD) + 1  # a window, not the whole study
    assert sorted(outcomes) == list(range(1000))
    for k, outcome in outcomes.items():
        assert outcome == (Lost("KilledWorker on the cluster: worker died") if k % 7 == 0 else k * k)
