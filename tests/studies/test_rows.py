"""Append-only rows: whole lines, cut lines, other studies, two writers."""

import math
import os

import pytest

from spacar import locks
from spacar.errors import UsageError
from spacar.studies.runs.rows import Rows, key

COLUMNS = ("case", "k", "y", "status", "reason")


@pytest.mark.parametrize("name", ["r.csv", "r.jsonl"])
def test_rows_come_back(tmp_path, name):
    path = tmp_path / name
    row = {"case": "a", "k": 0.1, "y": 1 / 3, "status": "done", "reason": 'text, with "quotes"\nand lines'}
    with Rows(path, COLUMNS) as rows:
        rows.add(row)
    with Rows(path, COLUMNS) as rows:
        assert float(rows.done["a"]["y"]) == 1 / 3  # all digits
        assert "quotes" in rows.done["a"]["reason"]
    assert path.read_text().count("\n") == (2 if name == "r.csv" else 1)


@pytest.mark.parametrize("name", ["r.csv", "r.jsonl"])
def test_a_file_cut_anywhere_is_repaired(tmp_path, name):
    """A killed process leaves a prefix of the file: rows before it are kept, the piece disappears."""
    path = tmp_path / name
    with Rows(path, COLUMNS) as rows:
        for case in "abc":
            rows.add({"case": case, "k": 1.0, "y": 2.0, "status": "done", "reason": ""})
    data = path.read_bytes()
    lines = data.count(b"\n")
    for size in range(0, len(data), 3):
        path.write_bytes(data[:size])
        with Rows(path, COLUMNS) as rows:
            whole = max(0, (data[:size] + b"\n" * (data[size : size + 1] == b"\n")).count(b"\n") - (lines - 3))
            assert len(rows.done) == whole
            for case in "abc"[whole:]:
                rows.add({"case": case, "k": 1.0, "y": 2.0, "status": "done", "reason": ""})
        assert path.read_bytes() == data


def test_complex_numbers(tmp_path):
    with Rows(tmp_path / "r.csv", COLUMNS) as rows:
        rows.add({"case": "a", "y": 1.5 - 2j, "status": "done"})
    with Rows(tmp_path / "r.csv", COLUMNS) as rows:
        assert complex(rows.done["a"]["y"]) == 1.5 - 2j
    with Rows(tmp_path / "r.jsonl", COLUMNS) as rows:
        rows.add({"case": "a", "y": 1.5 - 2j, "status": "done"})
    with Rows(tmp_path / "r.jsonl", COLUMNS) as rows:
        assert rows.done["a"]["y"] == [1.5, -2.0]


def test_other_files_are_not_touched(tmp_path):
    (tmp_path / "r.csv").write_text("a,b\n1,2\n")
    with pytest.raises(UsageError, match=r"other columns .*a, b"), Rows(tmp_path / "r.csv", COLUMNS):
        pass
    for text in ("{}\n", "hello\n", "[1]\n"):
        (tmp_path / "r.jsonl").write_text(text)
        with pytest.raises(UsageError, match="does not hold rows"), Rows(tmp_path / "r.jsonl", COLUMNS):
            pass
        assert (tmp_path / "r.jsonl").read_text() == text


HEAD = ",".join(COLUMNS)
ROW = "a,1.0,2.0,done,"
JSON = '{"case": "a", "k": 1.0, "y": 2.0, "status": "done", "reason": ""}'


@pytest.mark.parametrize(
    ("name", "data", "sentence"),
    [
        ("r.csv", b"a letter without an end of line", "other columns"),
        ("r.csv", b"a,b\n1,2", "other columns"),
        ("r.csv", f"{HEAD}\n{ROW}\u00e9\n".encode("latin-1"), r"is not UTF-8 \(byte 0xe9 in line 2\)"),
        ("r.csv", f"{HEAD}\n{'x' * 200_000}\n".encode(), r"cannot be read as csv \(field larger"),
        ("r.csv", f"{HEAD}\n{ROW},6\n".encode(), "6 cells under 5 columns in line 2"),
        ("r.csv", f"{HEAD.replace(',', ';')}\n".encode(), "other columns"),
        ("r.jsonl", b"a letter without an end of line", r"does not hold rows of a study \(line 1\)"),
        ("r.jsonl", b"[" * 100_000 + b"\n", "does not hold rows"),
        ("r.jsonl", f'{JSON}\n{{"n": {"9" * 5000}}}\n'.encode(), r"does not hold rows of a study \(line 2\)"),
        ("r.jsonl", f"{JSON}\n\u00e9\n".encode("latin-1"), "is not UTF-8 .*line 2"),
        ("r.jsonl", b'{"case": 1}\n', "does not hold rows"),
    ],
)
def test_what_is_not_of_the_study_is_not_touched(tmp_path, name, data, sentence):
    """Bit for bit, whatever is wrong: the last line too."""
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(UsageError, match=f"{sentence}.*not touched"), Rows(path, COLUMNS):
        pass
    assert path.read_bytes() == data


@pytest.mark.parametrize(
    ("name", "text", "done"),
    [
        ("r.csv", f"\ufeff{HEAD}\r\n{ROW}\r\n", "a"),  # saved by a spreadsheet
        ("r.csv", f"{HEAD}\n{ROW}\n\n,,,,\n", "a"),
        ("r.csv", f"{HEAD}\n{ROW}", "a"),
        ("r.csv", f"{HEAD}\nb,1.0\n{ROW}\n", "ba"),  # its case is run again
        ("r.csv", HEAD, ""),
        ("r.csv", f"\ufeff{HEAD}", ""),
        ("r.jsonl", f"\ufeff{JSON}\n\n", "a"),
        ("r.jsonl", JSON, "a"),
    ],
)
def test_a_file_that_was_edited_goes_on(tmp_path, name, text, done):
    path = tmp_path / name
    path.write_bytes(text.encode())
    with Rows(path, COLUMNS) as rows:
        assert list(rows.done) == list(done)
        rows.add({"case": "z", "k": 3.0, "status": "done"})
    with Rows(path, COLUMNS) as rows:
        assert list(rows.done) == [*done, "z"]
        assert float(rows.done["z"]["k"]) == 3.0


@pytest.mark.parametrize("flock", [True, False])
def test_one_writer(tmp_path, monkeypatch, flock):
    """Also on disks without flock, where the lock is a file that the refusal names."""
    if not flock:
        monkeypatch.setattr(locks, "fcntl", None)
    path = tmp_path / "r.csv"
    with Rows(path, COLUMNS), pytest.raises(UsageError, match="another study") as caught, Rows(path, COLUMNS):
        pass
    assert (f"its lock is {path}.lock, of process " in str(caught.value)) is not flock
    with Rows(path, COLUMNS):
        assert (tmp_path / "r.csv.lock").exists() is not flock
    assert [p.name for p in tmp_path.iterdir()] == ["r.csv"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_pipes_are_refused(tmp_path):
    os.mkfifo(tmp_path / "r.csv")
    with pytest.raises(UsageError, match=r"r\.csv is no file"), Rows(tmp_path / "r.csv", COLUMNS):
        pass


def test_keys():
    assert key("a", 1.0) == key("a", 1.0)
    assert len({key("a", 1.0), key("a", math.nextafter(1.0, 2.0)), key("b", 1.0), key("a", [1.0])}) == 4


@pytest.mark.parametrize("name", ["r.csv", "r.jsonl"])
def test_rows_that_come_together_are_written_at_once(tmp_path, name):
    path = tmp_path / name
    with Rows(path, COLUMNS) as rows:
        rows.add(*({"case": case, "k": 1.0} for case in "abc"))
        assert list(rows.done) == ["a", "b", "c"]
        assert path.read_text().count("\n") == 3 + (name == "r.csv")
