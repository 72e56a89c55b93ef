"""The command `spacar`: finds the command or mode, imports what it needs, turns errors into exit statuses."""

from __future__ import annotations

import errno
import gc
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import replace
from importlib import import_module
from typing import TYPE_CHECKING

import click

import spacar
from spacar.errors import SpacarError, UsageError
from spacar.modes import MODES
from spacar_cli.command_table import COMMANDS, OF_RESULT_FILES, OF_THE_MANUAL
from spacar_cli.environment import (
    Environment,
    ExitStatus,
    give_up_output,
    lasting,
    open_missing_streams,
    tell,
    tell_error,
)
from spacar_cli.vocabulary import MODE, renamed

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

REFUSED = (errno.ENOSPC, errno.EBADF, errno.EIO, errno.EFBIG)  # of standard output: files are named in their errors
COMPLETING = "_SPACAR_COMPLETE"  # set by the scripts of `spacar completion`
HELP = {"help_option_names": ["-h", "--help"]}


@contextmanager
def without_collection() -> Iterator[None]:
    """Modules are loaded for good: looking for garbage among them, now and later, takes a tenth of a short run."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def with_file_names(command: click.Command) -> click.Command:
    """The command; while the TAB key completes, its arguments that are names of results are those of files."""
    if COMPLETING in os.environ:
        for parameter in command.params:
            if isinstance(parameter, click.Argument) and parameter.name in ("file", "files"):
                parameter.type = click.Path()
    return command


class CommandGroup(click.Group):
    """A group whose commands are the modes (`1`, `-1`, ...) and the rows of the table, imported on demand."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if args and MODE.fullmatch(args[0]):
            args = ["--", *args]  # -1 is a mode here, not an option
        return super().parse_args(ctx, args)

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if MODE.fullmatch(cmd_name):
            with without_collection():
                from spacar_cli.commands.run_mode import command_of_mode

            return with_file_names(command_of_mode(cmd_name))
        cmd_name = OF_THE_MANUAL.get(cmd_name, cmd_name)
        if cmd_name not in COMMANDS:
            return None
        with without_collection():
            module, name = ("stored_results", cmd_name) if cmd_name in OF_RESULT_FILES else (cmd_name, "command")
            command: click.Command = getattr(import_module(f"spacar_cli.commands.{module}"), name)
        return with_file_names(command)

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Modes and commands by name, with their titles; none is imported for that."""
        from click.shell_completion import CompletionItem

        known = {str(mode.number): mode.title for mode in MODES.values()} | COMMANDS
        found = [CompletionItem(word, help=text) for word, text in known.items() if word.startswith(incomplete)]
        return [*found, *click.Command.shell_complete(self, ctx, incomplete)]

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        word = args[0]
        if not MODE.fullmatch(word) and word not in COMMANDS | OF_THE_MANUAL:
            from difflib import get_close_matches

            near = get_close_matches(word, COMMANDS | OF_THE_MANUAL, 1)
            hint = f"did you mean '{near[0]}'?" if near else f"the modes are {', '.join(map(str, MODES))}"
            ctx.fail(f"'{word}' is neither a mode nor a command; {hint}")
        return super().resolve_command(ctx, args)

    def collect_usage_pieces(self, ctx: click.Context) -> list[str]:
        return ["MODE FILE [OPTIONS]", "|", "COMMAND ..."]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Modes (a minus sign, as in -1, means without a plot)"):
            formatter.write_dl([(str(mode.number), mode.title) for mode in MODES.values()])
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(
    cls=CommandGroup,
    no_args_is_help=False,
    context_settings=HELP,
    epilog="`spacar MODE --help` and `spacar COMMAND --help` list the options. --debug, anywhere, shows the "
    "traceback of an error. Exit status: 0 done, 1 the analysis failed, 2 wrong usage or input, 130 "
    "interrupted.",
)
@click.version_option(spacar.__version__, "--version", "-V", prog_name="spacar", message="%(prog)s %(version)s")
def program() -> None:
    """Analysis of planar and spatial mechanisms with rigid and flexible links.

    Runs FILE (or FILE.dat) in a mode; the log and the results are written beside it.
    """


def main(arguments: Sequence[str] | None = None, environment: Environment | None = None) -> int:
    """Run one command line (default: that of the process) and return its exit status. Raises only with --debug."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if environment is None:
        open_missing_streams()
    env = environment or Environment()
    if "--debug" in words:
        env = replace(env, debug=True)
        words = [word for word in words if word != "--debug"]
    else:
        warnings.simplefilter("ignore")  # of libraries; ours are messages
    with redirect_stdout(env.stdout), redirect_stderr(env.stderr), lasting() as interrupted:
        try:
            if any("\0" in word for word in words):
                raise UsageError("a word of the command line has a zero byte in it", "usage")
            outcome = program.main(words, prog_name="spacar", standalone_mode=False, obj=env)
            env.stdout.flush()
            return int(outcome or ExitStatus.DONE)
        except click.UsageError as error:
            hints = renamed(words)
            if isinstance(error, click.NoSuchOption) and error.ctx is not None and error.ctx.command is program:
                hints = [*hints, "options stand behind the mode or the command"]
            if error.ctx is not None:
                env.tell(error.ctx.get_usage())
            unknown = f"no such option: {error.option_name}" if hints and isinstance(error, click.NoSuchOption) else ""
            tell(env, "error", "; ".join([unknown or error.format_message(), *hints]))
            return ExitStatus.WRONG
        except click.ClickException as error:
            tell(env, "error", error.format_message())
            return ExitStatus.WRONG
        except (click.Abort, KeyboardInterrupt) as error:
            return tell_error(env, error)
        except SystemExit as stop:  # click: the reader of our output has gone away
            return stop.code if isinstance(stop.code, int) else ExitStatus.FAILED
        except Exception as error:
            if isinstance(error, OSError) and error.filename is None and error.errno in REFUSED:
                give_up_output()
                tell(env, "error", f"cannot write to standard output: {error.strerror or error}")
                return ExitStatus.FAILED
            if env.debug:
                raise
            if interrupted() and not isinstance(error, (SpacarError, OSError, MemoryError)):
                return tell_error(env, KeyboardInterrupt())
            return tell_error(env, error)


if __name__ == "__main__":
    sys.exit(main())
