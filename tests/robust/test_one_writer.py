"""One writer at a time: a second run on the same results is refused before it computes, or waits."""

import io
import os
import signal
import time

import pytest
from spacar_cli.environment import Environment
from spacar_cli.main import main
from spacar_formats import safety as claims
from spacar_formats.getfrsbf import getfrsbf
from spacar_formats.safety import Claim

import spacar
from spacar import locks
from spacar.errors import AnalysisError, UsageError

from .processes import LONG, done, grows, model, shell, start, until


def test_the_second_of_two_runs_is_refused_and_the_first_keeps_everything(tmp_path):
    model(tmp_path)
    first = start(tmp_path, 1, "crank", "--steps", 10_000)
    until(grows(tmp_path / "crank.sbd.part", 20_000), first)
    first.send_signal(signal.SIGSTOP)  # it runs for as long as the second one asks
    log = (tmp_path / "crank.log").read_text()
    status, _, err = done(tmp_path, 1, "crank", "--steps", 50)
    assert (status, len(err.splitlines())) == (2, 1)
    assert "another run is writing crank.sbd" in err
    first.send_signal(signal.SIGCONT)
    assert first.wait(timeout=120) == 0
    assert getfrsbf(tmp_path / "crank.sbd", "tdef") == [[10_001]]
    assert (tmp_path / "crank.log").read_text().startswith(log)  # nor did the second touch the log
    assert sorted(p.name for p in tmp_path.iterdir()) == ["crank.dat", "crank.log", "crank.sbd"]


def test_one_that_waits_runs_when_the_other_has_ended(tmp_path):
    model(tmp_path)
    first = start(tmp_path, 1, "crank", *LONG)
    until(grows(tmp_path / "crank.sbd.part"), first)
    second = start(tmp_path, 1, "crank", "--steps", 50, "--wait")
    time.sleep(1.0)
    assert second.poll() is None
    first.kill()  # the lock ends with the process
    first.wait()
    assert second.wait(timeout=60) == 0
    assert getfrsbf(tmp_path / "crank.sbd", "tdef") == [[51]]
    assert not (tmp_path / "crank.sbd.part").exists()


def test_a_killed_run_blocks_nobody(tmp_path):
    model(tmp_path)
    first = start(tmp_path, 1, "crank", *LONG)
    until(grows(tmp_path / "crank.sbd.part"), first)
    first.kill()
    first.wait()
    assert done(tmp_path, 1, "crank")[0] == 0
    assert getfrsbf(tmp_path / "crank.sbd", "tdef") == [[101]]


def test_a_folder_of_the_name_is_not_moved_away(tmp_path, monkeypatch):
    monkeypatch.chdir(model(tmp_path))
    for name in ("crank.sbd", "crank.log", "crank.sbd.bak", "crank.sbd.part"):
        (tmp_path / name).mkdir()
        err = io.StringIO()
        status = main(["1", "crank"], Environment(stderr=err, variables={}))
        assert (status, len(err.getvalue().splitlines())) == (2, 1)
        assert "folder" in err.getvalue()
        assert (tmp_path / name).is_dir()
        (tmp_path / name).rmdir()
        assert sorted(p.name for p in tmp_path.iterdir()) == ["crank.dat"]


@pytest.fixture(params=["flock", "process number"])
def kind(request, monkeypatch):
    if request.param != "flock":
        monkeypatch.setattr(locks, "fcntl", None)
    return request.param


def test_claims(tmp_path, kind):
    """Both kinds of lock: one holder, released for the next, only one's own file published."""
    final = tmp_path / "a.sbd"
    one = Claim(final)
    with pytest.raises(UsageError, match=r"another run is writing .*a\.sbd"):
        Claim(final)
    one.begin()
    with one.open() as part:
        part.write(b"one")
    one.publish()
    two = Claim(final)
    two.begin()
    assert (tmp_path / "a.sbd.bak").read_bytes() == b"one"
    two.part.unlink()
    two.part.write_bytes(b"of somebody else")
    with pytest.raises(AnalysisError, match="removed or replaced"):
        two.publish()
    two.release()
    two.release()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.sbd.bak", "a.sbd.part"]
    three = Claim(final)  # what a killed run left is replaced
    three.begin()
    three.release()
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.sbd.bak"]


def test_the_lock_file_of_a_dead_process_does_not_count(tmp_path, monkeypatch):
    monkeypatch.setattr(locks, "fcntl", None)
    lock = tmp_path / "a.sbd.part.lock"
    lock.write_text(f"{locks.platform.node()} 4194305\n")  # above the largest process number of Linux
    Claim(tmp_path / "a.sbd").release()
    assert not lock.exists()


@pytest.mark.parametrize(
    ("text", "whose"),
    [
        (b"another-machine 17\n", "process 17 on another-machine"),
        (f"{locks.platform.node()} {os.getpid()}\n".encode(), f"process {os.getpid()} on {locks.platform.node()}"),
        (b"", "a process that it does not name"),
        (b"\xff\xb2 \xb2", "a process that it does not name"),
    ],
    ids=["another machine", "this process", "empty", "no text"],  # the same in all workers
)
def test_a_lock_that_may_be_stale_is_named(tmp_path, monkeypatch, text, whose):
    """On disks without flock: another machine cannot be asked, a number may be of another process by now."""
    monkeypatch.setattr(locks, "fcntl", None)
    lock = tmp_path / "a.sbd.part.lock"
    lock.write_bytes(text)
    with pytest.raises(UsageError, match="another run") as caught:
        Claim(tmp_path / "a.sbd")
    assert f"(its lock is {lock}, of {whose}; remove this file if that process has ended)" in str(caught.value)
    lock.unlink()
    Claim(tmp_path / "a.sbd").release()


def test_a_file_that_was_renamed_between_opening_and_locking_is_opened_again(tmp_path, monkeypatch):
    final = tmp_path / "a.sbd"
    lock, calls = locks.lock, []

    def slow(fd, path):
        calls.append(path)
        if len(calls) == 1:
            os.replace(path, final)  # the other run ended just now
        return lock(fd, path)

    monkeypatch.setattr(claims.locks, "lock", slow)
    with pytest.raises(UsageError):  # refused once: the name was of another file
        Claim(final)
    Claim(final, wait=True).release()


@pytest.mark.parametrize("closed", [
    "<&- >&- 2>&-", "2>/dev/full", *(pytest.param(c, marks=pytest.mark.slow) for c in ("2>&-", ">&-", "<&-")),
])  # fmt: skip
def test_missing_streams(tmp_path, closed):
    """Point 3: a run needs no streams, and no file gets the number of one."""
    model(tmp_path)
    status, _, _ = shell(tmp_path, f"spacar 1 crank -v {closed}")
    assert status == 0
    assert getfrsbf(tmp_path / "crank.sbd", "tdef") == [[101]]
    assert "internal" not in (tmp_path / "crank.log").read_text()


def test_failures_of_streams(tmp_path):
    """Wrong input without a stream to tell it; a full standard output."""
    assert shell(tmp_path, "spacar 1 nothing 2>&-")[0] == 2
    spacar.run(1, model(tmp_path) / "crank.dat").save(tmp_path / "crank")
    status, _, err = shell(tmp_path, "spacar getfrsbf crank x > /dev/full")
    assert (status, err) == (1, "error: cannot write to standard output: No space left on device\n")
