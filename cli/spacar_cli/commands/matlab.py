"""`spacar matlab`: the folder of the files for MATLAB and Octave, and a copy of it with the MEX file."""

from pathlib import Path

from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment


@words.command("matlab")
@words.option(
    "build", ", default spacar-matlab, and copies of the files; put that on the path instead.", is_flag=False,
    flag_value="spacar-matlab",
)  # fmt: skip
def command(environment: Environment, build: Path | None) -> None:
    """Print the folder that MATLAB and Octave need on their path: addpath('FOLDER').

    It has spacar(mode, file) and the readers of results, getfrsbf and the others; `help spacar` there says more. For
    callers who ask for spacar as a MEX file, --build makes a folder of your choice with it (needs mkoctfile or mex).
    """
    from spacar_formats import mex

    if build is None:
        environment.say(str(mex.FOLDER))
        return
    for path in mex.build(build):
        environment.tell(f"built {path.name}")
    environment.say(str(build.resolve()))
