"""Help, version, colours, streams, and what happens to errors that nobody expected."""

import contextlib
import signal

import click
import numpy as np
import pytest
from spacar_cli import command_table
from spacar_cli.commands.run_mode import command_of_mode
from spacar_cli.environment import ExitStatus
from spacar_cli.main import program

import spacar
from spacar.modes import MODES


def test_every_row_of_the_table_is_a_command_and_every_parameter_is_documented():
    commands = [program.get_command(click.Context(program), name) for name in command_table.COMMANDS]
    commands += [command_of_mode(str(number)) for number in MODES]
    for command in commands:
        assert command.help, command.name
        for parameter in command.params:
            if isinstance(parameter, click.Option):
                assert parameter.help, (command.name, parameter.name)
            else:
                name = parameter.make_metavar(click.Context(command)).strip("[].")
                assert name.split("]")[0] in command.get_usage(click.Context(command)), (command.name, name)


def test_version_and_help(call):
    assert call("--version").out == f"spacar {spacar.__version__}\n"
    for word in ("--help", "-h"):
        done = call.done(word)
        assert all(name in done.out for name in command_table.COMMANDS)
        assert all(mode.title in done.out for mode in MODES.values())
    done = call.done("1", "--help")
    assert "--integrator" in done.out
    assert "--integrator" not in call("7", "--help").out


def test_exit_statuses_are_the_documented_ones():
    assert [int(s) for s in ExitStatus] == [0, 1, 2, 130]


@pytest.mark.parametrize(
    ("terminal", "variables", "coloured"),
    [
        (True, {}, True),
        (True, {"NO_COLOR": "1"}, False),
        (True, {"TERM": "dumb"}, False),
        (True, {"NO_COLOR": ""}, True),  # no-color.org: only a value that is not empty counts
        (False, {}, False),
    ],
)
def test_colours(call, terminal, variables, coloured):
    err = call.refused("1", "nofile", terminal=terminal, **variables)
    assert ("\x1b[" in err) is coloured
    assert "nofile.dat: no such file" in err


def test_a_terminal_gets_one_summary_line_a_pipe_gets_none(call, monkeypatch):
    monkeypatch.setattr("spacar_cli.progress.PATIENCE", np.inf)  # a busy machine would show a bar on stderr
    assert call("1", "crank").out == ""
    assert call("1", "crank", "--quiet", terminal=True).out == ""
    for done in (call("1", "crank", terminal=True), call("1", "crank", "--verbose")):
        assert done.err == ""
        assert len(done.out.splitlines()) == 1
        assert done.out.startswith("crank.dat: forward dynamics, 101 steps")


def test_warnings_are_told_information_only_when_asked(call, tmp_path):
    text = (tmp_path / "crank.dat").read_text()
    (tmp_path / "warn.dat").write_text(text.replace("FIX 1\n", "FIX 1\nFIX 1 1\nX 77 1. 1.\n"))
    done = call.done("0", "warn")
    assert {line.split(":")[0] for line in done.err.splitlines()} == {"warning"}
    assert "information: " in call("0", "warn", "--verbose").err
    assert call("0", "warn", "--quiet").err == ""
    assert "warning: warn.dat:" in (tmp_path / "warn.log").read_text()


def test_an_unexpected_error_is_one_line_and_a_traceback_only_with_debug(call, monkeypatch, tmp_path):
    def broken(*_, **__):
        raise ZeroDivisionError("nobody thought of this")

    monkeypatch.setattr("spacar_cli.commands.run_mode.frames", broken)
    err = call.refused("1", "crank", status=1)
    assert err.startswith("error: internal error: ZeroDivisionError: nobody thought of this")
    assert len(err.splitlines()) == 1
    assert "ZeroDivisionError: nobody thought of this [internal]" in (tmp_path / "crank.log").read_text()
    with pytest.raises(ZeroDivisionError):
        call("1", "--debug", "crank")


def test_an_interrupt_that_a_library_turns_into_an_error_of_its_own(call, monkeypatch):
    def compiled(*_, **__):  # as pybind11: matplotlib then says "Invalid bounding box"
        with contextlib.suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        raise ValueError("Invalid bounding box")

    call("0", "crank")
    monkeypatch.setattr("matplotlib.figure.Figure.savefig", compiled)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell ignores it in what runs behind
    try:
        done = call("draw", "crank", "-o", "a.png")
    finally:
        signal.signal(signal.SIGINT, before)
    assert (done.status, done.err) == (130, "error: interrupted\n")


def test_an_interrupt_before_the_first_step(call, monkeypatch, tmp_path):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("spacar_cli.commands.run_mode.frames", interrupted)
    done = call("1", "crank")
    assert done.status == 130
    assert done.err == "error: interrupted\n"
    assert "[interrupted]" in (tmp_path / "crank.log").read_text()


def test_the_progress_bar_appears_on_terminals_after_a_while(call, monkeypatch):
    monkeypatch.setattr("spacar_cli.progress.PATIENCE", 0.0)
    monkeypatch.setattr("spacar_cli.progress.REFRESH", 0.0)
    done = call.done("1", "crank", terminal=True, TERM="xterm", COLUMNS="120")
    assert "t = 0.1 s" in done.err
    assert "100%" in done.err
    assert call("1", "crank").err == ""
    assert call("1", "crank", "--quiet", terminal=True).err == ""
