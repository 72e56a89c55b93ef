"""Damaged bytes and killed processes: only SbfError is raised, committed steps are never lost."""

import signal
import struct
import subprocess
import sys
import time
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from spacar_formats.checksbf import checksbf
from spacar_formats.locate import incomplete_note
from spacar_formats.sbf import SbfError, SbfFile

from spacar.errors import UsageError
from tests.fuzz.cases import repaired

from .samples import VECTOR, sbd, vector_file

COVERED = [k for k in range(512) if k != 13 and not 0x118 <= k < 0x120]  # state and number of steps have no checksum


def read_everything(path):
    """Everything that a tool can ask of a file; returns the values."""
    checksbf(path)
    with SbfFile(path) as file:
        incomplete_note(file)
        return {ident: file.get(ident) for ident in file.ids}


@pytest.mark.parametrize("at", COVERED)
def test_every_changed_byte_under_a_checksum_is_noticed(tmp_path, at):
    raw = bytearray(VECTOR)
    raw[at] ^= 0x10
    path = tmp_path / "v.sbd"
    path.write_bytes(raw)
    with pytest.raises(SbfError, match=r"v\.sbd") as caught:
        read_everything(path)
    assert caught.value.exit_status == 2


@pytest.mark.parametrize("length", range(512))
def test_a_file_cut_off_anywhere_is_refused_or_has_whole_steps_only(tmp_path, length):
    path = tmp_path / "v.sbd"
    path.write_bytes(VECTOR[:length])
    if length < 0x1C0:
        with pytest.raises(SbfError):
            read_everything(path)
        return
    with SbfFile(path) as file:
        assert file.steps == (length - 0x1C0) // 32
        assert not file.complete
        assert file.truncated
    assert not checksbf(path).sound


CHANGES = st.lists(st.tuples(st.integers(0, 511), st.integers(0, 255)), min_size=1, max_size=6)
NUMBERS = st.sampled_from([0, 1, 7, 8, 64, 2**31 - 1, 2**31, 2**32, 2**60, 2**61, 2**63, 2**64 - 1])
WORDS = st.tuples(st.integers(2, 63).map(lambda k: 8 * k), NUMBERS)


def only_sbf_errors(tmp_path_factory, changes, words, cut, repair):
    raw = bytearray(VECTOR)
    for at, value in changes:
        raw[at] = value
    for at, number in words:
        struct.pack_into("<Q", raw, at, number)
    done = bytes(raw[:cut]) if cut < len(raw) else bytes(raw)
    path = tmp_path_factory.getbasetemp() / "fuzz.sbd"
    path.write_bytes(repaired(done) if repair and len(done) >= 64 else done)
    with suppress(SbfError):
        read_everything(path)


fuzzed = given(
    changes=CHANGES, words=st.lists(WORDS, max_size=2), cut=st.integers(0, 512) | st.just(512), repair=st.booleans()
)
test_fuzzed_bytes_raise_nothing_but_sbf_errors = settings(max_examples=300, deadline=None)(fuzzed(only_sbf_errors))
test_many_fuzzed_bytes = pytest.mark.slow(settings(max_examples=1500, deadline=None)(fuzzed(only_sbf_errors)))


@settings(max_examples=300, deadline=None)
@given(raw=st.binary(max_size=300))
def test_any_other_file_is_refused(tmp_path_factory, raw):
    path = tmp_path_factory.getbasetemp() / "any.sbd"
    path.write_bytes(raw)
    with pytest.raises(SbfError):
        SbfFile(path)


def test_a_damaged_step_is_refused_by_number_and_the_others_are_read(tmp_path):
    path = sbd(tmp_path / "a.sbd", steps=5)
    with SbfFile(path) as file:
        at = file.directory.data_offset + 2 * file.directory.stride + 30
    raw = bytearray(path.read_bytes())
    raw[at] ^= 1
    path.write_bytes(raw)
    with SbfFile(path) as file:
        with pytest.raises(SbfError, match="step 3"):
            file.get("x")
        np.testing.assert_array_equal(file.get("t", [1, 2, 4, 5])[:, 0], [0.0, 0.1, 0.1 * 3, 0.4])
        assert file.damaged_steps().tolist() == [3]
    with SbfFile(path, verify=False) as file:
        assert file.get("t").shape == (5, 1)


def test_a_newer_version_is_refused_by_its_number(tmp_path):
    raw = bytearray(VECTOR)
    raw[8] = 2
    (tmp_path / "v.sbd").write_bytes(repaired(bytes(raw)))
    with pytest.raises(SbfError, match="version 2"):
        SbfFile(tmp_path / "v.sbd")


def test_a_newer_minor_version_is_read(tmp_path):
    raw = bytearray(VECTOR)
    raw[10] = 9
    (tmp_path / "v.sbd").write_bytes(repaired(bytes(raw)))
    assert read_everything(tmp_path / "v.sbd")["NX"] == 2


def test_a_folder_or_a_missing_file_is_wrong_use(tmp_path):
    for path in (tmp_path, tmp_path / "absent.sbd"):
        with pytest.raises(UsageError, match="cannot open"):
            SbfFile(path)


def test_an_unmapped_writer_does_not_disturb_an_open_reader(tmp_path):
    """A new run unlinks the old side file first: truncating a mapped file would kill the reader (SIGBUS)."""
    path = sbd(tmp_path / "a.sbd", steps=200)
    with SbfFile(path) as file:
        vector_file(path)
        assert file.get("x", 200)[0, 0] == 199


PROGRAM = """
import sys, numpy as np
from spacar_formats.sbf import SbfWriter
out = SbfWriter(sys.argv[1], "sbd", {"NX": 40}, {"T": (1, 1), "X": (40, 1)})
for k in range(10**9):
    out.append({"T": k, "X": np.full(40, k)})
    if k == 20:
        print("go", flush=True)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
@pytest.mark.parametrize("delay", [0.0, 0.003, 0.02, 0.1])
def test_a_killed_process_leaves_whole_steps(tmp_path, delay):
    path = tmp_path / "killed.sbd.part"
    child = subprocess.Popen([sys.executable, "-c", PROGRAM, str(path)], stdout=subprocess.PIPE)
    assert child.stdout is not None
    child.stdout.readline()
    time.sleep(delay)
    child.send_signal(signal.SIGKILL)
    child.wait()
    child.stdout.close()
    with SbfFile(path) as file:
        assert (file.state, file.complete, file.truncated) == (0, False, False)
        assert file.steps >= 21
        assert file.surplus in (0, file.directory.stride) or 0 < file.surplus < file.directory.stride
        assert file.damaged_steps().size == 0
        np.testing.assert_array_equal(file.get("t")[:, 0], np.arange(file.steps))
        assert f"stopped after step {file.steps} at t = {file.steps - 1}" in (incomplete_note(file) or "")
    assert checksbf(path).sound


FULL_DISK = """
import resource, signal, sys
from spacar.errors import AnalysisError
from spacar_formats.sbf import SbfWriter
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))
out = SbfWriter(sys.argv[1], "sbd", {}, {"X": (40, 1)})
try:
    for k in range(100):
        out.append({"X": [k] * 40})
except AnalysisError as error:
    print(out.steps, error)
out.close(complete=False)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="needs a limit on the size of files")
def test_a_full_disk_stops_with_a_reason_and_keeps_the_steps_before(tmp_path):
    path = tmp_path / "full.sbd.part"
    done = subprocess.run([sys.executable, "-c", FULL_DISK, str(path)], capture_output=True, text=True, check=True)
    steps, text = done.stdout.split(" ", 1)
    assert f"step {int(steps) + 1}" in text
    with SbfFile(path) as file:
        assert (file.steps, file.state) == (int(steps), 2)
        assert file.steps == (10_000 - file.directory.data_offset) // file.directory.stride
        np.testing.assert_array_equal(file.get("x")[:, 0], np.arange(file.steps))
    assert checksbf(path).sound
