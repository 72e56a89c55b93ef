"""The container against its description: the vector that two other programs agreed on, round trips."""

import string
import struct
import tracemalloc
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from spacar_formats.checksbf import checksbf
from spacar_formats.locate import incomplete_note
from spacar_formats.sbf import SbfError, SbfFile, SbfWriter

from spacar.errors import UsageError
from tests.fuzz.cases import repaired

from .samples import LNP, VECTOR, M, sbd, sbm, vector_file

IDS = st.text(string.ascii_uppercase + string.digits + "_", min_size=1, max_size=15).filter(
    lambda s: s not in ("TDEF", "TDAT")
)
MATRICES = array_shapes(min_dims=2, max_dims=2, min_side=0, max_side=4)
LINES = st.lists(st.text(max_size=8).map(lambda s: s.encode("utf-8", "replace").decode().rstrip(" ")), max_size=3)
VALUES = arrays(np.int64, MATRICES) | arrays(np.float64, MATRICES) | LINES


def test_the_test_vector_is_reproduced_byte_for_byte(tmp_path):
    assert vector_file(tmp_path / "v.sbd").read_bytes() == VECTOR


def test_the_test_vector_is_read(tmp_path):
    (tmp_path / "v.sbd").write_bytes(VECTOR)
    with SbfFile(tmp_path / "v.sbd") as file:
        assert (file.kind, file.state, file.steps, file.complete) == ("sbd", 1, 2, True)
        assert file.ids == ("NX", "LNP", "TITLE", "T", "X")
        assert file.header["title"] == ["demo"]
        np.testing.assert_array_equal(file.get("lnp"), [[1, 2], [0, 0]])
        np.testing.assert_array_equal(file.get("X"), [[1, -2.5], [1.25, -2]])
        np.testing.assert_array_equal(file.get("TDEF"), [[2]])


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_whatever_is_written_is_read_back(tmp_path_factory, data):
    ids = data.draw(st.lists(IDS, unique=True, max_size=8))
    split = data.draw(st.integers(0, len(ids)))
    header = {ident: data.draw(VALUES) for ident in ids[:split]}
    shapes = {ident: data.draw(st.tuples(st.integers(0, 3), st.integers(0, 3))) for ident in ids[split:]}
    n = data.draw(st.integers(0, 3))
    written = [{i: data.draw(arrays(np.float64, shape)) for i, shape in shapes.items()} for _ in range(n)]
    path = tmp_path_factory.getbasetemp() / "round.sbm"
    with SbfWriter(path, "sbm", header, shapes) as out:
        for values in written:
            out.append(values)
    with SbfFile(path) as file:
        assert file.ids == tuple(ids)
        assert (file.steps, file.complete, file.surplus) == (n, True, 0)
        for ident, value in header.items():
            got = file.get(ident)
            if isinstance(value, list):
                assert got == value
            else:
                assert got.dtype == value.dtype
                np.testing.assert_array_equal(got, value)
        for ident, shape in shapes.items():
            for k in range(n):
                np.testing.assert_array_equal(file.get(ident, k + 1), written[k][ident].reshape(shape))
            if n > 1:
                rows = [values[ident].ravel(order="F") for values in written]
                np.testing.assert_array_equal(file.get(ident), rows)


def test_one_step_has_its_native_shape_and_several_steps_are_rows_in_column_order(tmp_path):
    with SbfFile(sbd(tmp_path / "a.sbd")) as file:
        dx = np.arange(6.0).reshape(3, 2)
        assert file.get("x", 2).shape == (3, 1)
        assert file.get("t").shape == (3, 1)
        np.testing.assert_array_equal(file.get("dx", 2), dx + 10)
        np.testing.assert_array_equal(file.get("dx")[2], (dx + 20).ravel(order="F"))
        np.testing.assert_array_equal(file.get("dx")[2].reshape(3, 2, order="F"), dx + 20)
        np.testing.assert_array_equal(file.get("dx", [3, 1])[:, 0], [20, 0])
        np.testing.assert_array_equal(file.get("lnp"), LNP)
    with SbfFile(sbm(tmp_path / "a.sbm")) as file:
        np.testing.assert_array_equal(file.get("m0"), M)


@pytest.mark.parametrize(
    ("name", "ident"),
    [("t", "T"), ("Time", "T"), ("TIME", "T"), ("fxtot", "FXT"), ("fxt", "FXT"), ("estiff", "STIF"), ("stif", "STIF")],
)
def test_both_names_are_accepted_in_any_case(tmp_path, name, ident):
    with SbfFile(sbd(tmp_path / "a.sbd")) as file:
        assert file.variable(name).id == ident
        assert file.has(name)


def test_short_name_finds_a_variable_stored_under_its_long_name(tmp_path):
    path = sbd(tmp_path / "a.sbd", KDFORM=np.array([1, 0]), RXYZQ=np.eye(3).reshape(1, 9))
    with SbfFile(path) as file:
        np.testing.assert_array_equal(file.get("kdef"), [[1], [0]])
        assert file.get("rq").shape == (1, 9)
        assert "kdef" in file.header


def test_the_message_for_an_unknown_variable_names_file_and_nearest(tmp_path):
    with SbfFile(sbd(tmp_path / "a.sbd")) as file:
        with pytest.raises(UsageError, match=r"ID not found: fxtt in .*a\.sbd; nearest: fxt") as caught:
            file.get("fxtt")
        assert caught.value.exit_status == 2
        with pytest.raises(UsageError, match="OUTLEVEL"):
            file.get("d2x")


@pytest.mark.parametrize("steps", [0, 4, -4, [1, 7], 10**30, 2.0])
def test_a_step_that_does_not_exist_is_refused(tmp_path, steps):
    with SbfFile(sbd(tmp_path / "a.sbd")) as file, pytest.raises(UsageError, match="steps 1 to 3"):
        file.get("x", steps)


def test_steps_of_a_header_variable_are_refused(tmp_path):
    with SbfFile(sbd(tmp_path / "a.sbd")) as file, pytest.raises(UsageError, match="one value"):
        file.get("lnp", 1)


@pytest.mark.parametrize(
    "values",
    [
        {"T": 0.0}, {"T": 0.0, "Y": [1.0, 2.0]}, {"T": 0.0, "X": [1.0]}, {"T": 0.0, "X": 1.0},
        {"T": 0.0, "X": [[1.0, 2.0], [3.0, 4.0]]}, {"T": 0.0, "X": [1.0, 2.0], "Y": 1.0},
    ],
)  # fmt: skip
def test_append_refuses_what_does_not_fit_and_writes_nothing(tmp_path, values):
    with SbfWriter(tmp_path / "a.sbd", "sbd", {}, {"T": (1, 1), "X": (2, 1)}) as out:
        with pytest.raises(ValueError, match=r"."):
            out.append(values)
        out.append({"T": 1.0, "X": np.array([[1.0], [2.0]])})
    with SbfFile(tmp_path / "a.sbd") as file:
        np.testing.assert_array_equal(file.get("x"), [[1.0], [2.0]])


@pytest.mark.parametrize(
    ("header", "variables"),
    [
        ({"TOO_LONG_TO_BE_AN_ID": 1}, {}), ({"A": 1, "a": 2}, {}), ({"A": 1}, {"A": (1, 1)}), ({"TDEF": 1}, {}),
        ({"A B": 1}, {}), ({"A": 1j}, {}), ({"A": np.zeros((1, 1, 1))}, {}),
    ],
)  # fmt: skip
def test_the_writer_refuses_what_the_container_cannot_hold(tmp_path, header, variables):
    with pytest.raises(ValueError, match=r"."):
        SbfWriter(tmp_path / "a.sbd", "sbd", header, variables)
    assert not (tmp_path / "a.sbd").exists()


def test_an_impossible_place_is_a_usage_error(tmp_path):
    with pytest.raises(UsageError, match="cannot create"):
        SbfWriter(tmp_path / "absent" / "a.sbd", "sbd", {}, {})


def test_reading_while_writing_sees_the_steps_so_far(tmp_path):
    out = SbfWriter(tmp_path / "a.sbd", "sbd", {}, {"T": (1, 1)})
    for k in range(3):
        out.append({"T": float(k)})
        with SbfFile(tmp_path / "a.sbd") as file:
            assert (file.steps, file.state, file.complete) == (k + 1, 0, False)
    out.close(complete=False)
    with SbfFile(tmp_path / "a.sbd") as file:
        assert (file.steps, file.state, file.complete) == (3, 2, False)


def test_an_exception_inside_the_writer_marks_the_file_stopped(tmp_path):
    def fail_in_the_second_step():
        with SbfWriter(tmp_path / "a.sbd", "sbd", {}, {"T": (1, 1)}) as out:
            out.append({"T": 1.0})
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail_in_the_second_step()
    with SbfFile(tmp_path / "a.sbd") as file:
        assert (file.state, file.steps) == (2, 1)


@pytest.mark.slow
def test_a_hundred_thousand_steps_need_no_memory_and_one_of_them_is_read_alone(tmp_path):
    x = np.arange(10.0)
    tracemalloc.start()
    with SbfWriter(tmp_path / "long.sbd", "sbd", {}, {"T": (1, 1), "X": (10, 1)}) as out:
        for k in range(100_000):
            out.append({"T": float(k), "X": x})
    with SbfFile(tmp_path / "long.sbd") as file:
        assert file.get("t", 77_777)[0, 0] == 77_776
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (tmp_path / "long.sbd").stat().st_size > 9_600_000
    assert peak < 1_000_000  # the file is ten times larger; the reader keeps one byte a step


# Damaged bytes: only SbfError is raised. Killed processes and full disks: tests/acceptance/test_runs.py.
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
