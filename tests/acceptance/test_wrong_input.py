"""Every situation of reference/input-language.md section 10 through the real command line: status, one line each,
no traceback.

The decks are those of tests/deck/rows.py; all rows share one process for speed.
"""

import re

import pytest

from tests.deck import rows

from .processes import many, spacar

MESSAGE = re.compile(r"(error|warning|information): \S+\.dat(:\d+)?: .+|\.\.\. and \d+ more")


def file_name(row) -> str:
    return re.sub(r"\W+", "_", row.name) + ".dat"


def command_line(row) -> list[str]:
    """Errors of a mode are provoked by a run in it, the rest by `check`, which knows all severities."""
    name = file_name(row)
    if row.severity == "error" and row.mode is not None:
        return [str(row.mode), name]
    mode = [] if row.mode is None else ["--mode", str(row.mode)]
    return ["check", name, *mode]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("rows")
    for row in rows.ROWS:
        (path / file_name(row)).write_text(row.text)
    return path


@pytest.fixture(scope="module")
def outcomes(folder):
    return dict(zip((r.name for r in rows.ROWS), many([command_line(r) for r in rows.ROWS], folder), strict=True))


@pytest.mark.parametrize("row", rows.ROWS, ids=lambda r: r.name)
def test_row(row, outcomes):
    done = outcomes[row.name]
    assert done.status == (2 if row.severity == "error" else 0), done.err
    assert "Traceback" not in done.err
    lines = done.err.splitlines()
    assert all(MESSAGE.fullmatch(line) for line in lines), done.err
    fragments = [f.replace("<deck>", file_name(row)) for f in row.fragments]
    found = [x for x in lines if x.startswith(f"{row.severity}: ") and all(f in x for f in fragments)]
    assert found, (fragments, done.err)


def test_errors_of_a_run_are_in_the_log_with_their_code(folder, outcomes):
    checked = 0
    for row in rows.ROWS:
        if row.severity == "error" and row.mode is not None:
            log = (folder / file_name(row)).with_suffix(".log").read_text()
            for line in outcomes[row.name].err.splitlines():
                if line.startswith("error: "):
                    assert re.search(re.escape(line) + r" \[[a-z]+[a-z.-]*\]$", log, re.MULTILINE), log
                    checked += 1
            assert "nothing was analysed" in log
    assert checked


def test_twenty_errors_are_printed_and_the_rest_is_counted(folder):
    text = "PLTRUSS 1 1 2\nX 2 1. 0.\n" + "RLSE 9\n" * 30 + "END END\n"
    (folder / "many.dat").write_text(text)
    done = spacar("0", "many", folder=folder)
    lines = done.err.splitlines()
    assert done.status == 2
    assert len(lines) == 21
    assert lines[-1] == "... and 10 more"
    log = (folder / "many.log").read_text()
    assert log.count("error: many.dat:") == 30  # the log has them all


FUNCTIONS = {  # name of the function: body (none: there is no file), status, fragments of the message
    "nothere": ("", 2, ("withnothere.dat:7: USERSIG", "nothere.py")),
    "raises": ("raise ZeroDivisionError('by hand')", 1, ("raises", "t = 0", "ZeroDivisionError: by hand")),
    "shape": ("return t, [[1, 1]], []", 1, ("shape", "t = 0", "3 or 5 numbers")),
    "nan": ("return t, [[1, 1, float('nan')]], []", 1, ("nan", "t = 0", "row 1", "not finite")),
    "syntax": ("return (", 2, (":7: USERSIG", "syntax", "SyntaxError")),
}
SPRING = "PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nFIX 2 2\nDYNE 1 1\nEND HALT\n{line}XM 2 1.\nTIMESTEP 1. 2\nEND END\n"


def test_user_functions_that_misbehave(folder):
    for name, (body, _, _) in FUNCTIONS.items():
        if body:
            (folder / f"{name}.py").write_text(f"def {name}(t, ne, le, e, ep, nx, lnp, x, xp):\n    {body}\n")
        (folder / f"with{name}.dat").write_text(SPRING.format(line=f"USERSIG {name}\n"))
    ended = many([["1", f"with{name}"] for name in FUNCTIONS], folder)
    for (name, (_, status, fragments)), done in zip(FUNCTIONS.items(), ended, strict=True):
        assert done.status == status, done.err
        assert all(f in done.err for f in fragments), done.err
        assert "Traceback" not in done.err
        assert not (folder / f"with{name}.sbd").exists()


def test_counts_that_do_not_match_are_a_failure_of_the_analysis(folder):
    """A triangle of bars with one node too few supports: more coordinates to calculate than deformations."""
    (folder / "loose.dat").write_text("PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nEND HALT\nXM 2 1.\nEND END\n")
    done = spacar("1", "loose", folder=folder)
    assert done.status == 1
    assert "Traceback" not in done.err
    log = (folder / "loose.log").read_text()
    assert "[mechanism.count]" in log
    assert not (folder / "loose.sbd").exists()


def test_mode_0_takes_nothing_from_the_dynamics_block(folder):
    """Its errors are no more than a warning in this mode; numbers that mean nothing must not reach the arrays."""
    wrong = "INPUTE 1 1 2.\nINPUTX 9 9 1.\nXM 77 1.\nESTIFF 99 1. 2.\nSTARTDE 1 9 1.\nXF 50 1.\nUSERSIG nothere\n"
    (folder / "zero.dat").write_text(f"PLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nFIX 2\nRLSE 1\nEND HALT\n{wrong}END END\n")
    done = many([["0", "zero"]], folder)[0]
    assert done.status == 0
    assert [line.split(":")[0] for line in done.err.splitlines()] == ["warning"]
    assert many([["1", "zero"]], folder)[0].status == 2
