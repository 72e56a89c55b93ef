"""`spacar completion SHELL`: what lets the TAB key complete modes, commands, options and files."""

from pathlib import Path

import click
from click.shell_completion import get_completion_class

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell

SHELLS = ("bash", "zsh", "fish")


@words.command("completion")
@click.argument("shell", type=click.Choice(SHELLS), required=False)
@words.option("install")
def command(environment: Environment, shell: str | None, install: bool) -> None:
    """Print or install the completion of the command line for SHELL (default: that of $SHELL).

    After `spacar completion --install`, in a new shell, the TAB key completes modes, commands, options and file names.
    """
    from spacar_formats.safety import write_text

    if shell is None:
        shell = Path(environment.variables.get("SHELL", "")).name
        if shell not in SHELLS:
            raise UsageError(f"say for which shell: {', '.join(SHELLS)}", "usage.shell")
    script = source(shell)
    if not install:
        environment.say(script.rstrip("\n"))
        return
    target, advice = place(shell, environment)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot make the folder {target.parent}: {error.strerror}", "files.open") from None
    write_text(target, script)
    environment.wrote(target)
    tell(environment, "information", advice)


def source(shell: str) -> str:
    from spacar_cli.main import COMPLETING, program

    maker = get_completion_class(shell)
    assert maker is not None
    completion = maker(program, {}, "spacar", COMPLETING)
    script = completion.source_template % completion.source_vars()  # source() would ask for the version of bash
    # From its second call on an autoloaded function of zsh is a plain one: click's script would only register itself
    # then, and the second TAB of a shell would find nothing.
    return script.replace("[-1] == loadautofunc ]]", "[-1] == (loadautofunc|shfunc) ]]")


def place(shell: str, environment: Environment) -> tuple[Path, str]:
    """Where the script of a shell belongs, and what else has to be done."""
    variables = environment.variables
    home = Path(variables.get("HOME") or Path.home())
    data = Path(variables.get("XDG_DATA_HOME") or home / ".local" / "share")
    if shell == "bash":
        folder = Path(variables.get("BASH_COMPLETION_USER_DIR") or data / "bash-completion") / "completions"
        return folder / "spacar", (
            f"open a new shell; without the package bash-completion add to ~/.bashrc: source {folder / 'spacar'}"
        )
    if shell == "zsh":
        folder = data / "zsh" / "site-functions"
        return folder / "_spacar", (
            f"open a new shell; once, before compinit in ~/.zshrc: fpath+=({folder}); autoload -Uz compinit && compinit"
        )
    folder = Path(variables.get("XDG_CONFIG_HOME") or home / ".config") / "fish" / "completions"
    return folder / "spacar.fish", "open a new shell"
