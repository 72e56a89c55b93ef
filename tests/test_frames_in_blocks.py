"""Frames that became ready together stay in columns; results are those of frames that come one by one."""

import copy
import pickle
from dataclasses import fields

import numpy as np
import pytest

import spacar
from spacar.frame import E_FIELDS, X_FIELDS, Frame, FramesInRows, JoinedFrames, StoredFrames, column, joined
from tests.examples import DATA

CRANK = DATA / "crank.dat"


def block(first: int, n: int) -> StoredFrames:
    """Frames whose numbers tell where they stand: x = (t, -t), e = (10 t,)."""
    t = np.arange(first, first + n, dtype=float)
    of_x = np.column_stack((t, -t))
    variables = dict.fromkeys(("x", "xd", "xdd", "fx", "fxgrav", "fxtot"), of_x)
    variables |= dict.fromkeys(("e", "ed", "edd", "sig"), 10.0 * t[:, None])
    return StoredFrames(t, variables, {"rhs": 2.0 * t}, [{}] * (n - 1) + [{0: f"lost at {first + n - 1}"}])


@pytest.fixture
def frames():
    """Three of one block, one alone, two of another block."""
    return joined([block(0, 3), (block(3, 1)[0],), block(4, 2)])


def test_a_frame_is_found_wherever_it_stands(frames):
    assert isinstance(frames, JoinedFrames)
    assert len(frames) == 6
    assert [f.t for f in frames] == [frames[k].t for k in range(6)] == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert frames[-1].t == 5.0
    assert [f.t for f in frames[1:-1:2]] == [1.0, 3.0]
    assert (frames[2].x == [2.0, -2.0]).all()
    assert frames[5].statistics == {"rhs": 10}
    assert [f.lost for f in frames] == [{}, {}, {0: "lost at 2"}, {0: "lost at 3"}, {}, {0: "lost at 5"}]
    for k in (6, -7):
        with pytest.raises(IndexError):
            frames[k]


def test_columns_are_joined(frames):
    assert (column(frames, "t") == np.arange(6.0)).all()
    assert (column(frames, "x") == np.column_stack((np.arange(6.0), -np.arange(6.0)))).all()
    assert column(frames, "eigval") is None
    assert (column(tuple(frames), "sig") == column(frames, "sig")).all()


def test_a_variable_that_one_frame_lacks_is_no_column(frames):
    alone = frames.blocks[1][0]
    alone.matrices["m0"] = np.eye(2)
    assert column(frames, "m0") is None
    assert (column((alone,), "m0") == np.eye(2)).all()


def test_variables_are_parts_of_rows():
    """Of x, xd, xdd, three forces, two numbers each, and e, ed, edd, sig; behind them something else."""
    rows = np.arange(51.0).reshape(3, 17)
    block = FramesInRows(np.arange(3.0), rows, (2, 1), [{}] * 3)
    assert block[1].statistics == {}
    block.statistics = dict(zip(("steps", "rhs"), np.arange(6).reshape(3, 2).T, strict=True))
    assert (column(block, "xd") == rows[:, 2:4]).all()
    assert (column(block, "sig") == rows[:, 15:16]).all()
    assert (column(block, "t") == [0.0, 1.0, 2.0]).all()
    assert column(block, "eigval") is None
    assert all((block.variables[name] == block.column(name)).all() for name in (*X_FIELDS, *E_FIELDS))
    assert block[1].statistics == {"steps": 2, "rhs": 3}
    assert (block[-1].fxtot == rows[2, 10:12]).all()


def test_one_block_stays_what_it_is():
    alone = block(0, 3)
    assert joined([alone]) is alone


def test_a_column_of_a_result_is_its_own():
    """Changing it does not change the result."""
    result = spacar.run(1, CRANK)
    for read in (lambda: result["x"], lambda: result.t, lambda: result.node(2, 1), lambda: result.element(1, 1)):
        found, kept = read(), read().copy()
        found[:] = np.nan
        assert np.array_equal(read(), kept)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda result: pickle.loads(pickle.dumps(result))])
def test_a_result_can_be_copied_and_sent(copied):
    result = spacar.run(1, CRANK)
    other = copied(result)
    assert [f.statistics for f in other.frames] == [f.statistics for f in result.frames]
    for name in ("t", *X_FIELDS, *E_FIELDS):
        assert np.array_equal(other[name], result[name])


@pytest.mark.parametrize("mode", [1, 4])
def test_a_result_has_what_its_run_gives_frame_by_frame(mode):
    result, run = spacar.run(mode, CRANK), spacar.frames(mode, CRANK)
    each = list(run)
    assert len(each) == len(result.frames) == run.n_frames
    assert result.report == tuple(run.report.lines)
    for mine, other in zip(result.frames, each, strict=True):
        for f in fields(Frame):
            a, b = getattr(mine, f.name), getattr(other, f.name)
            assert np.array_equal(a, b) if isinstance(a, np.ndarray) else repr(a) == repr(b)
    for name in ("t", "x", "xdd", "sig", "fxtot"):
        assert np.array_equal(result[name], np.array([getattr(f, name) for f in each]))
