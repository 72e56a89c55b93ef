"""Completion, manual page, and what helps somebody who does not know the words."""

import ast
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from spacar_cli.command_table import COMMANDS, TOPICS
from spacar_cli.commands.completion import SHELLS, source
from spacar_cli.main import program
from spacar_cli.man_page import command_section, page
from spacar_cli.vocabulary import FORMER, VOCABULARY

from spacar.modes import MODES
from tests.command_line import call
from tests.examples import DATA

HOUSE = Path(__file__).parents[2]
SPACAR = Path(sys.executable).parent / "spacar"


def completed(line: str, folder: Path) -> list[str]:
    """What bash gets for a line whose last word is completed: type,value."""
    more = {"COMP_WORDS": line, "COMP_CWORD": str(line.count(" ")), "_SPACAR_COMPLETE": "bash_complete"}
    done = subprocess.run([SPACAR], env=os.environ | more, cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.split()


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("spacar pl", ["plain,plot"]), ("spacar 1", ["plain,1", "plain,10"]), ("spacar 1 cr", ["file,cr"]),
        ("spacar plot cr", ["file,cr"]), ("spacar 1 crank --integ", ["plain,--integrator"]),
        ("spacar completion z", ["plain,zsh"]),
    ],
)  # fmt: skip
def test_completion(line, found, tmp_path):
    assert completed(line, tmp_path) == found


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_the_script_works_in_bash(tmp_path):
    (tmp_path / "script").write_text(source("bash"))
    text = "source ./script; COMP_WORDS=(spacar chec); COMP_CWORD=1; _spacar_completion spacar; echo ${COMPREPLY[@]}"
    done = subprocess.run(
        ["bash", "-c", text], cwd=tmp_path, env=in_front(tmp_path), capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["check", "checksbf"], done.stderr


def test_the_script_of_zsh_completes_at_every_call():
    """As the test below, without a shell: what click writes has the condition that `source` widens."""
    assert "[-1] == (loadautofunc|shfunc) ]]" in source("zsh")


@pytest.mark.skipif(shutil.which("fish") is None, reason="there is no fish")
def test_the_script_works_in_fish(tmp_path):
    (tmp_path / "crank.dat").write_text("")
    (tmp_path / "script").write_text(source("fish"))
    text = 'source script; complete -C "spacar chec"; complete -C "spacar 1 cran"'
    done = subprocess.run(
        ["fish", "--no-config", "-c", text], cwd=tmp_path, env=in_front(tmp_path), capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    assert [line.split()[0] for line in done.stdout.splitlines()] == ["check", "checksbf", "crank.dat"], done.stderr


ZSH = """
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell "PS1=; fpath=($1 \\$fpath); autoload -Uz compinit; compinit -u -D; print ready"
zpty -r -m shell text '*
ready*'
zpty -w -n shell "spacar comb"$'\\t'
zpty -r -m shell text '*combsbd*'
zpty -w -n shell "cran"$'\\t'
zpty -r -m shell text '*crank.dat*' && print complete
"""


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("zsh") is None, reason="there is no zsh")
def test_the_script_works_in_zsh_at_the_second_tab_too(tmp_path):
    (tmp_path / "crank.dat").write_text("")
    (tmp_path / "functions").mkdir()
    (tmp_path / "functions" / "_spacar").write_text(source("zsh"))
    (tmp_path / "keys.zsh").write_text(ZSH)
    done = subprocess.run(
        ["zsh", "-f", "keys.zsh", tmp_path / "functions"], cwd=tmp_path, env=in_front(tmp_path), capture_output=True,
        text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.stdout.split() == ["complete"], done.stderr


def in_front(home: Path) -> dict[str, str]:
    """An environment of its own for a shell, in which `spacar` is the one that is tested."""
    return os.environ | {"PATH": f"{SPACAR.parent}{os.pathsep}{os.environ['PATH']}", "HOME": str(home)}


@pytest.mark.parametrize("shell", SHELLS)
def test_completion_is_installed_by_one_command(shell, tmp_path):
    """Where the documentation of the shells says; printed without --install."""
    done = call.done("completion", "--install", HOME=str(tmp_path), SHELL=f"/usr/bin/{shell}")
    path = Path(done.out.strip())
    assert path.is_relative_to(tmp_path)
    assert path.read_text() == source(shell)
    assert "_SPACAR_COMPLETE" in path.read_text()
    assert "new shell" in done.err
    status, printed, _ = call("completion", shell)
    assert (status, printed.strip()) == (0, source(shell).strip())


def test_the_manual_page_has_every_mode_command_and_option():
    """Each by the words of its help, whatever version of click laid it out; `make man` writes it anew."""
    text = (HOUSE / "docs" / "man" / "spacar.1").read_text(encoding="utf-8")
    context = click.Context(program, info_name="spacar")
    for name in [*map(str, MODES), *COMMANDS]:
        command = program.get_command(context, name)
        made = "\n".join(command_section(name, command, context))
        sections = re.findall(r"^\.SS .*$", made, re.MULTILINE)
        options = re.findall(r"^\.B (\\-\S+?)[, \n]", made, re.MULTILINE)
        begin = text.index(f'.SS "spacar {name}"\n')
        part = text[begin : begin + 2 * len(made)]
        assert all(s in text for s in sections), f"{name}: run `make man`"
        assert all(o in part for o in options), f"{name}: run `make man`"


@pytest.mark.skipif(shutil.which("man") is None, reason="there is no man")
def test_man_reads_the_page(tmp_path):
    (tmp_path / "spacar.1").write_text(page())
    done = subprocess.run(["man", "--warnings", "-l", "spacar.1"], cwd=tmp_path, capture_output=True, text=True,
                          env=os.environ | {"MANPAGER": "cat", "MANWIDTH": "80"}, check=True)  # fmt: skip
    assert done.stdout.startswith("SPACAR(1)")
    assert not done.stderr


def test_check_says_what_moves_and_names_overconstraints(tmp_path):
    """As mode 0, which the first steps of the README promise."""
    out = call.done("check", DATA / "crank.dat", "-v").out
    assert "1 degree of freedom: node 2 phi" in out
    assert "the mechanism is neither over- nor under-constrained" in out
    assert len(call("check", DATA / "crank.dat")[1].splitlines()) == 1
    text = (DATA / "crank.dat").read_text().upper().replace("FIX 6 2", "FIX 6 2\nFIX 4")
    (tmp_path / "over.dat").write_text(text)
    assert "over-constrained" in call.done("check", tmp_path / "over", "-v").out


def test_a_step_is_an_option_everywhere(tmp_path):
    assert call(9, DATA / "lever.dat", "--output-dir", tmp_path)[0] == 0
    name = tmp_path / "lever"
    assert call("getss", name, "--at", 1)[1] == call("getss", name, 1)[1] == call("getss", name)[1]
    assert call("getfrsbf", name, "X", "--at", 1)[1] == call("getfrsbf", name, "X", 1)[1]
    assert call("getss", name, 1, "--at", 1)[0] == 2
    for command in ("draw", "visual", "eigen", "bode", "stress", "compliance", "getss", "getfrsbf", "repinsbf"):
        assert "--at" in call(command, "--help")[1]


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("plott", "crank"), "did you mean 'plot'?"),
        (("1", "crank", "--outputdir", "x"), "Did you mean --output-dir?"),
        (("completion",), "say for which shell: bash, zsh, fish"),
    ],
)
def test_hints(words, hint):
    said = call.refused(*words)
    assert hint in said.replace("'--output-dir'", "--output-dir")  # click 8.2 has no quotes


def test_check_reads_standard_input():
    model = (DATA / "crankfl.dat").read_text()
    said = call.done("check", "-v", "-", stdin=model).out
    assert said.startswith("stdin.dat: 0 errors, 0 warnings\n13 coordinates, 9 deformations, 5 degrees")
    _, said, wrong = call("check", "-", stdin=model + "VISUALIZATION\nBEAMVIZ 1 2\n")
    assert "stdin.dat: 0 errors, 1 warning" in said
    assert "BEAMVIZ" in wrong
    assert "stdin:1: X 1: second argument 'a' is not a number" in call.refused("check", "-", stdin="X 1 a\n")


@pytest.mark.parametrize(("name", "command"), [("spadraw", "draw"), ("spavisual", "visual"), ("spasim", "sim")])
def test_names_of_the_manual(name, command):
    """The same command, with its own name in the usage, and a hint for slips."""
    assert call(name, "--help")[1].replace(name, command) == call(command, "--help")[1].replace(name, command)
    assert f"did you mean '{name}'" in call(f"{name}l", "x")[2]


HELPED = re.compile(r"spacar\s+help\s+(\w+)")


@pytest.mark.parametrize("word", [*map(str, MODES), *COMMANDS])
def test_help_points_to_pages_that_an_installation_has(word):
    """`spacar help TOPIC`: docs/ is not installed."""
    context = click.Context(program, info_name="spacar")
    command = program.get_command(context, word)
    text = "\n".join(command_section(word, command, context)) + command.get_help(click.Context(command, context, word))
    assert "docs/" not in text
    assert ".md" not in text
    assert set(HELPED.findall(text)) <= {*TOPICS, *COMMANDS, *map(str, MODES), "TOPIC"}


def test_no_message_names_a_page_that_an_installation_has_not():
    """Every text in the sources but docstrings of modules, and the head of a page that is made from a table."""
    for path in (p for room in ("spacar", "formats", "cli") for p in (HOUSE / room).rglob("*.py")):
        text = path.read_text("utf-8")
        if "docs/" not in text and "spacar help" not in text:
            continue
        tree = ast.parse(text)
        for node in ast.walk(ast.Module(tree.body[1:] if ast.get_docstring(tree) else tree.body, [])):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                assert "docs/" not in node.value or "> docs/" in node.value, f"{path}: {node.value}"
                assert set(HELPED.findall(node.value)) <= {*TOPICS, *COMMANDS}, f"{path}: {node.value}"


@pytest.mark.parametrize("topic", TOPICS)
def test_the_page_of_a_topic(topic):
    done = call("help", topic)
    assert done == (0, (HOUSE / "docs" / TOPICS[topic]).read_text("utf-8").rstrip() + "\n", "")


# One vocabulary of options: all `--help` are held against the table, and a former spelling is told the new one.
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
