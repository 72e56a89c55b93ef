"""Completion, manual page, and what helps somebody who does not know the words."""

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import click
import pytest
from spacar_cli.command_table import COMMANDS, TOPICS
from spacar_cli.commands.completion import SHELLS, source
from spacar_cli.main import program
from spacar_cli.man_page import command_section, page

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
