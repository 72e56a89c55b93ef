"""`spacar sweep`: results against single runs, restart, failures, killed processes, clusters."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import spacar
from spacar.studies.assignments import change, setting
from spacar.studies.runs.setting import Setup, Trade
from spacar.studies.runs.workers import Lost, run

HERE = Path(__file__).parent
CRANK = ("sweep", "crank", "--time", "0.004", "--steps", "2", "--set", "INPUTX.2.1[start rate]=50:150:3",
         "-r", "x: x[6,1]@end", "-r", "F: max(abs(fxtot[6,2]))")  # fmt: skip


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_rows_are_those_of_single_runs(call, deck):
    done = call(*CRANK)
    assert (done.status, done.err) == (0, "")
    assert "3 cases: 3 run" in done.out
    for row in rows("crank.sweep.csv"):
        rate = float(row["INPUTX.2.1[start rate]"])
        single = change(deck("crank", 1), [setting("INPUTX.2.1[start rate]")], [rate])
        result = spacar.run(1, single, duration=0.004, n_steps=2)
        assert float(row["x"]) == result.node(6, 1)[-1]  # the same arithmetic
        assert row["status"] == "done"


def test_a_mode_that_needs_another_result_is_refused(call, deck):
    """Every case failed, with the advice to give an option that a sweep does not have."""
    path = deck("robotinvlin", 3).path
    done = call("sweep", path, "--mode", "3", "--set", "XM.8=20,30", "-r", "m0[1,1]@end", "-o", "t.csv")
    assert done.status == 2
    assert "a sweep does not run mode 3" in done.err
    assert not Path("t.csv").exists()


def test_finished_cases_are_skipped_and_another_model_is_another_case(call):
    call(*CRANK)
    before = Path("crank.sweep.csv").read_bytes()
    assert "3 cases: 0 run" in call(*CRANK).out
    assert Path("crank.sweep.csv").read_bytes() == before
    more = [w.replace("150:3", "150:5") for w in CRANK]
    assert "5 cases: 2 run" in call(*more).out
    assert Path("crank.sweep.csv").read_bytes().startswith(before)
    text = Path("crank.dat").read_text().replace("0.033375", "0.04")
    Path("crank.dat").write_text(text)
    assert "3 cases: 3 run" in call(*CRANK).out


def test_another_user_function_is_another_case(call):
    """Also for `trade`, whose rows have a key of their own."""
    function = "def grow(t, step):\n    return t, [], [[2, 1, {0}*t, {0}, 0]]\n"
    Path("crank.dat").write_text(Path("crank.dat").read_text().replace("TIMESTEP", "USERINP grow\nTIMESTEP"))
    keys = set()
    for rate in (50, 60):
        Path("grow.py").write_text(function.format(rate))
        assert "3 cases: 3 run" in call(*CRANK).out
        assert "3 cases: 0 run" in call(*CRANK).out
        keys.add(Trade(1, spacar.read_deck("crank.dat", 1), ()).key(Setup()))
    assert len(keys) == 2


def test_failed_cases_say_why(call):
    words = ("sweep", "plbeam5", "-m", "7", "--set", "ESTIFF.*[EI]=100,1e-9", "-r", "x[11,2]@end", "-o", "r.jsonl")
    assert "ESTIFF.*[EI] = 1e-09" in call.refused(*words, status=1)
    good, bad = map(json.loads, Path("r.jsonl").read_text().splitlines())
    assert (good["status"], bad["status"]) == ("done", "failed")
    assert "load step 1 of 10" in bad["reason"]
    assert "0 run" in call(*words).out
    assert "1 run" in call(*words, "--retry-failed").out


def test_a_quantity_that_does_not_exist_is_a_failed_case(call):
    call.refused("sweep", "crank", "--time", "0.001", "--steps", "1", "--set", "XM.6=1", "-r", "x[99,1]@end", status=1)
    assert rows("crank.sweep.csv")[0]["reason"] == "'x[99,1]@end': node 99 does not exist; nodes are 1 to 7"


def test_tables(call):
    Path("cases.csv").write_text("XM.6,INPUTX.2.1[start rate]\n0.1,50\n0.2,60\n")
    words = ("sweep", "crank", "--time", "0.001", "--steps", "1", "-r", "x[6,1]@end")
    assert "2 cases" in call(*words, "--from", "cases.csv").out
    assert "4 cases" in call(*words, "--from", "cases.csv", "--set", "EM.2=0.2,0.3", "-o", "b.csv").out
    out = call(*words, "--zip", "--set", "XM.6=1,2", "--set", "EM.2=3,4", "-o", "c.csv").out
    assert "2 cases" in out
    assert [(r["XM.6"], r["EM.2"]) for r in rows("c.csv")] == [("1.0", "3.0"), ("2.0", "4.0")]
    summary = call(*words, "--set", "XM.6=1,2", "-o", "d.csv", "--json").out
    assert json.loads(summary)["cases"] == 2


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--set", "XM.6=1"), "nothing to keep"),
        (("-r", "t@end"), "nothing to vary"),
        (("-r", "t@end", "--set", "XM.9=1"), "no statement XM 9"),
        (("-r", "open('x')", "--set", "XM.6=1"), "functions are"),
        (("-r", "XM.6: t@end", "--set", "XM.6=1"), "two columns would be called XM.6"),
        (("-r", "t@end", "--set", "XM.6=1", "-o", "r.txt"), "written as .csv or .jsonl"),
        (("-r", "t@end", "--set", "XM.6=1", "-m", "5"), "mode 5 does not exist"),
        (("-r", "t@end", "--from", "none.csv"), "none.csv"),
    ],
)
def test_wrong_usage(call, words, why):
    assert why in call.refused("sweep", "crank", *words)
    assert not Path("crank.sweep.csv").exists()


def test_processes_give_the_same_rows(call):
    call(*CRANK, "-o", "one.csv")
    call(*CRANK, "-o", "two.csv", "-j", "2")
    plain = [{k: v for k, v in r.items() if k != "seconds"} for r in rows("one.csv")]
    both = [{k: v for k, v in r.items() if k != "seconds"} for r in rows("two.csv")]
    assert sorted(plain, key=str) == sorted(both, key=str)


def test_a_process_that_dies_takes_only_its_case(monkeypatch):
    monkeypatch.syspath_prepend(str(HERE))
    monkeypatch.setenv("PYTHONPATH", str(HERE))
    from broken import double_or_die

    outcome = dict(run(double_or_die, range(6), jobs=2))
    lost = outcome.pop(3)
    assert isinstance(lost, Lost)
    assert "died" in lost.reason
    assert outcome == {n: 2 * n for n in (0, 1, 2, 4, 5)}


def test_killed_and_started_again(call):
    """SIGKILL in the middle: whole rows stay, the rest is run by the next start, none twice."""
    words = [sys.executable, "-m", "spacar_cli.main", "sweep", "crankfl", "--time", "0.002", "--steps", "2",
             "--set", "XM.8=0.01:0.2:24", "-r", "x[8,1]@end", "--no-batch", "-o", "r.csv"]  # fmt: skip
    process = subprocess.Popen(words, env={**os.environ, "OMP_NUM_THREADS": "1"}, stdout=subprocess.PIPE)
    path = Path("r.csv")
    while process.poll() is None and not (path.exists() and path.read_text().count("\n") > 3):
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    kept = rows(path)
    assert 3 <= len(kept) < 24, "the process was not killed in the middle"
    done = call.done(*words[3:])
    assert f"{24 - len(kept)} run" in done.out
    found = rows(path)
    assert len({r["case"] for r in found}) == len(found) == 24


def test_processes_end_with_a_killed_parent(tmp_path):
    """No orphans: the processes of a parent that was killed end by themselves."""
    path = tmp_path / "alive"
    code = "from broken import note_and_wait\nfrom spacar.studies.runs.workers import run\n"
    code += f"if __name__ == '__main__':\n    list(run(note_and_wait, [{str(path)!r}] * 4, jobs=2))\n"
    script = tmp_path / "parent.py"
    script.write_text(code)
    process = subprocess.Popen([sys.executable, str(script)], env={**os.environ, "PYTHONPATH": str(HERE)})
    wait_until(lambda: path.exists() and len(path.read_text().split()) >= 2)
    process.kill()
    process.wait()
    children = [int(word) for word in path.read_text().split()]
    wait_until(lambda: not any(running(child) for child in children))


def wait_until(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def running(pid):
    """Whether a process exists and is no zombie."""
    try:
        os.kill(pid, 0)
        return "Z" not in Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (ProcessLookupError, FileNotFoundError):
        return False


def test_a_cluster_without_dask(call, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert "pip install 'spacar[dask]'" in call.refused(*CRANK, "--scheduler", "localhost:1")


def test_a_cluster(call):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
    ) as cluster:
        done = call(*CRANK, "--scheduler", cluster.scheduler_address, "-o", "far.csv")
    assert done.status == 0, done.err
    call(*CRANK, "-o", "near.csv")
    assert sorted((r["case"], r["x"]) for r in rows("far.csv")) == sorted((r["case"], r["x"]) for r in rows("near.csv"))
