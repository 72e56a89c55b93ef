"""The files for MATLAB and Octave (`matlab/`), and a folder of them with the MEX file that a compiler makes there.

The MEX file goes to a folder of the user's choice together with copies of the .m files, because the folder of the
package may be read-only and belongs to every MATLAB and Octave of the machine: put that folder on the path instead.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from spacar.errors import AnalysisError, UsageError
from spacar_formats.safety import replacing, write_text

FOLDER = Path(__file__).resolve().parent / "matlab"
SOURCE = "spacar.c"
# Octave's compiler and that of MATLAB; the files they write have different names, so one folder may hold both.
COMPILERS = {"mkoctfile": ("--mex", "-o", "spacar.mex", SOURCE), "mex": (SOURCE,)}
COMMAND = "spacar_command.txt"  # what run_spacar.m reads


def build(target: Path) -> list[Path]:
    """Copy all files to the folder `target`, build spacar.mex* there, write which program it calls; the MEX files.

    Raises UsageError when there is no compiler (nothing is written) or the folder cannot be written, AnalysisError when
    the compiler fails; the copies are then complete and work with the plain spacar.m.
    """
    compilers = {name: found for name in COMPILERS if (found := shutil.which(name)) is not None}
    if not compilers:
        text = "neither mkoctfile (Octave; Debian: octave-dev) nor mex (MATLAB) is on the path; from within MATLAB or"
        text += f" Octave: addpath('{FOLDER}'), spacar_build('{target.resolve()}')"
        raise UsageError(text, "matlab.compiler")
    try:
        for path in sorted(FOLDER.rglob("*.[mc]")):
            copy = target / path.relative_to(FOLDER)
            copy.parent.mkdir(parents=True, exist_ok=True)
            _copy(path, copy)
    except OSError as error:
        raise UsageError(f"cannot write {target}: {error.strerror or error}", "files.open") from None
    program = _program()
    if program is not None:
        write_text(target / COMMAND, f"{program}\n")
    made, failures = [], []
    for name, compiler in compilers.items():
        with tempfile.TemporaryDirectory() as side:
            failure = _compile(compiler, COMPILERS[name], Path(side))
            for file in sorted(Path(side).glob("spacar.mex*")):
                _copy(file, target / file.name)
                made.append(target / file.name)
                failure = None
            if failure is not None:
                failures.append(failure)
    if not made:
        raise AnalysisError(f"the MEX file could not be built: {'; '.join(failures)}", "matlab.compiler")
    return made


def _copy(source: Path, target: Path) -> None:
    with replacing(target) as side:
        shutil.copyfile(source, side)


def _program() -> Path | None:
    """The command `spacar` of this installation, None when there is none."""
    name = "spacar.exe" if os.name == "nt" else "spacar"
    places = [Path(sys.argv[0]), Path(sysconfig.get_path("scripts")) / name]
    if (found := shutil.which("spacar")) is not None:
        places.append(Path(found))
    return next((p.absolute() for p in places if p.stem == "spacar" and p.is_file()), None)


def _compile(compiler: str, words: tuple[str, ...], folder: Path) -> str | None:
    """What went wrong if there is no MEX file. `mex` may also be a program of TeX: it gets no input and some time."""
    shutil.copyfile(FOLDER / SOURCE, folder / SOURCE)
    try:
        done = subprocess.run(
            [compiler, *words], cwd=folder, capture_output=True, stdin=subprocess.DEVNULL, timeout=300, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{compiler}: {error}"
    if done.returncode:
        said = (done.stderr + done.stdout).decode("utf-8", "replace").strip()
        return f"{compiler}: {said[-400:] or f'status {done.returncode}'}"
    return f"{compiler} wrote no MEX file"
