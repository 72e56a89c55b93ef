"""One vocabulary of options: all `--help` are held against the table, and a former spelling is told the new one."""

import re
from collections.abc import Iterator

import click
import pytest
from spacar_cli.command_table import COMMANDS
from spacar_cli.main import program
from spacar_cli.vocabulary import FORMER, VOCABULARY

from spacar.modes import MODES
from tests.command_line import call
from tests.examples import DATA

SPELLINGS = re.compile(r"^  (-\S.*?)(?:  +|$)(.*)$")


def commands() -> Iterator[tuple[str, click.Command]]:
    """Every mode, command and subcommand, by the words that call it."""
    root = click.Context(program, info_name="spacar")
    for name in (*map(str, MODES), *(str(-n) for n in MODES if n), *COMMANDS):
        found = program.get_command(root, name)
        assert found is not None
        if isinstance(found, click.Group):
            yield from ((f"{name} {below}", found.commands[below]) for below in found.commands)
        else:
            yield name, found


def printed(name: str, command: click.Command) -> dict[str, str]:
    """The options in the help of a command: how they are spelled, with what value, and their text."""
    context = click.Context(command, info_name=name, help_option_names=["-h", "--help"], terminal_width=400)
    options: dict[str, str] = {}
    for line in command.get_help(context).partition("Options:\n")[2].splitlines():
        match = SPELLINGS.match(line)
        if match:
            options[match[1]] = match[2]
        elif line.startswith("   ") and options:
            options[list(options)[-1]] += f" {line.strip()}"
    return {left: text for left, text in options.items() if "--help" not in left}


HELPS = {name: printed(name, command) for name, command in commands()}


def test_all_helps_speak_the_vocabulary():
    """Each option of each help is a row: its spellings together, its value of the same kind, its sentence."""
    rows = {(*w.spelled.replace("/", " ").split(), bool(w.value)): w for w in VOCABULARY.values()}
    assert len(rows) >= len(VOCABULARY) - 3  # --elements, --substeps and --compiled have two forms
    for name, options in HELPS.items():
        assert options, name
        for left, text in options.items():
            spelled = re.findall(r"(?<![\w-])--?[a-z][a-z-]*", left)
            value = re.sub(r"--?[a-z-]+|[,/ ]", "", left)
            rows_of_it = [w for w in VOCABULARY.values() if w.spelled.replace("/", " ").split() == spelled]
            assert rows_of_it, (name, left)
            assert any(bool(w.value) == bool(value) and text.strip().startswith(w.means) for w in rows_of_it), left


def test_a_spelling_has_one_meaning():
    """A short one belongs to one long one, in the table and so everywhere; nothing but these is -q and -v."""
    seen: dict[str, set[str]] = {}
    for word in VOCABULARY.values():
        long = word.spelled.split()[-1]
        for spelled in word.spelled.split():
            seen.setdefault(spelled, set()).add(long)
    assert all(len(longs) == 1 for longs in seen.values()), seen
    rows = [word.spelled for word in VOCABULARY.values()]
    twice = {spelled for spelled in rows if rows.count(spelled) > 1}
    # the same with and without a list or a file; --force is a load of a flexure, and a run that the disk cannot hold
    assert twice == {"--elements", "--substeps", "--rigid", "--release", "--force"}
    for name, options in HELPS.items():
        assert any(left.startswith("-q, --quiet") for left in options), name
        assert any(left.startswith("-v, --verbose") for left in options), name


@pytest.mark.parametrize(
    ("spelled", "value"), [("-o, --output", "FILE"), ("--csv", "PATH"), ("--steps", "N"), ("-n, --node", "NODE")]
)
def test_values_are_called_the_same_everywhere(spelled, value):
    found = {left for options in HELPS.values() for left in options if left.startswith(f"{spelled} ")}
    assert found == {f"{spelled} {value}"}


def test_former_spellings_are_gone_and_told():
    """None of them is an option of its command, but where it means something else now; the message has the new one."""
    again = {("stress", "--at"), ("eigen", "--csv"), ("bode", "--csv"), ("sensitivity", "-q")}
    again.add(("symbolic simulate", "--plot"))
    for name, former in FORMER.items():
        for old in former:
            options = HELPS[name.replace("MODE", "1")]
            spelled = {s for left in options for s in re.findall(r"--?[a-z-]+", left)}
            assert (old in spelled) == ((name, old) in again), (name, old)
            assert not former[old].startswith("--") or former[old].split()[0] in spelled, (name, old)


@pytest.mark.parametrize(
    ("words", "new"),
    [
        (["draw", "crank", "-s", "3"], "-s is now --at"),
        (["draw", "crank", "--steps", "3"], "--steps is now --at"),
        (["1", "crank", "--plot"], "--plot is now --show"),
        (["sim", "robotsim", "--picture", "a.png"], "--picture is now -o FILE"),
        (["eigen", "lever", "--csv"], "--csv is now --csv PATH (- prints)"),
        (["bode", "lever", "--csv", "-o", "a.png"], "--csv is now --csv PATH (- prints)"),
        (["stress", "leafguide", "--at", "0.5", "-o", "a.png"], "--at is now --place"),
        (["sensitivity", "leafguide", "-p", "X.4[3]", "-q", "frequency[1]"], "-q is now --of"),
        (["flexure", "leafguide", "--report", "a.html"], "--report is now -o PAGE.html"),
        (["symbolic", "simulate", "a.toml", "--plot"], "--plot is now --plot NAME (or all)"),
    ],
)
def test_an_old_command_line_is_told_the_new_one(words, new, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, _, err = call(*words)
    assert (status, new in err) == (2, True), err


def test_quiet_and_verbose(tmp_path):
    """-q: neither summaries nor warnings; -v: a summary; what was asked for is printed."""
    assert call("1", DATA / "crank.dat", "--output-dir", tmp_path, "-q") == (0, "", "")
    out = call.done("1", DATA / "crank.dat", "--output-dir", tmp_path, "-v").out
    assert "forward dynamics" in out
    assert call("plot", tmp_path / "crank", "x[6,1]", "-o", tmp_path / "a.png", "-q") == (0, "", "")
    status, out, _ = call("getfrsbf", tmp_path / "crank", "t", "--at", "-1", "-q")
    assert (status, len(out.split())) == (0, 1)


WARNED = "OUTLEVEL 9 9\nPLTRUSS 1 1 2\nX 2 1. 0.\nFIX 1\nFIX 2 2\nDYNE 1\nEND HALT\nXM 2 1.\nESTIFF 1 8.\nEND END\n"


@pytest.mark.parametrize("words", [["7"], ["check"], ["check", "--expand"], ["flexure", "--move", "2x=0.1"]])
@pytest.mark.parametrize("broken", [False, True])
def test_warnings_are_told_once_on_standard_error_unless_quiet(words, broken, tmp_path, monkeypatch):
    """Also those beside an error of the input, of which quiet leaves the error."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.dat").write_text(WARNED.replace("ESTIFF", "ESTUFF") if broken else WARNED)
    status, out, err = call(words[0], "m", *words[1:])
    assert (status, err.count("warning: m.dat:1: OUTLEVEL"), err.count("error: "), "warning:" in out) == (
        2 * broken, 1, broken, False
    )  # fmt: skip
    _, out, err = call(words[0], "m", *words[1:], "-q")
    assert (err.count("warning"), err.count("error: ")) == (0, broken)
    assert ("% plain statements of m.dat, numbers in m, kg, s, N, rad\n" in out) == ("--expand" in words and not broken)


def test_expanded_input_tells_that_its_unit_changed():
    first = call("check", DATA / "leafguide.dat", "--expand")[1].partition("\n")[0]
    assert first == "% plain statements of leafguide.dat, numbers in m, kg, s, N, rad; UNITS of the file is converted"
