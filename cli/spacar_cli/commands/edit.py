"""`spacar edit FILE`: write an input file and see it, in a browser."""

from pathlib import Path

from spacar.errors import UsageError
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment


@words.command("edit")
@words.option("no_browser")
def command(environment: Environment, file: Path, no_browser: bool) -> None:
    """Open FILE (or FILE.dat) in a page of the browser: text with help and checks, the mechanism, runs and results.

    A file that does not exist begins with a short example and is made by the first save. The page is served on this
    computer only, to whoever has its address; Ctrl-C, or End on the page, ends it. User functions (USERSIG, USERINP,
    USERTRAJ) are executed by runs only.
    """
    from spacar_cli.editor.page_server import serve

    # `crank` stands for `crank.dat`, also when there is no such file
    named = file.suffix.lower() == ".dat" or not file.name or file.is_file()
    path = file if named else file.with_name(f"{file.name}.dat")
    if path.is_dir() or not path.parent.is_dir():
        raise UsageError(f"{path}: {'it is a folder' if path.is_dir() else 'its folder does not exist'}", "files.open")
    serve(environment, path, False, not no_browser)
