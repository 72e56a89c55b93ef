"""The options of all commands: one table, in which a spelling has one meaning wherever it stands.

A command takes its options from here by name, `@words.option("at", ...)`; its help is the sentence of the table and
what the command adds to it. Every command has -q and -v, which the environment keeps. FORMER tells who writes an
option as it was before what it is now. `tests/cli/test_finding_the_way.py` holds the table against all helps.

Types of numbers on the command line: finite, in a range, with a sentence for what is not.
"""

import math
import re
from collections.abc import Callable, Sequence
from functools import reduce
from pathlib import Path
from typing import Any, NamedTuple, get_type_hints

import click

LARGEST, SMALLEST = 1e100, 1e-100  # as in input files: squares and products of such numbers are still numbers
MOST = 10**15


class Real(click.FloatRange):
    """A finite number, of a size between 1e-100 and 1e100 or zero, inside `min` ... `max`."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        number = click.FLOAT.convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value!r} is not a finite number", param, ctx)
        if number and not SMALLEST <= abs(number) <= LARGEST:
            self.fail(f"{value} is outside of {SMALLEST:g} ... {LARGEST:g}", param, ctx)
        return super().convert(number, param, ctx)

    def _describe_range(self) -> str:
        """The range in the help; nothing where there is none."""
        return "" if self.min is None and self.max is None else super()._describe_range()


class Whole(click.IntRange):
    """A whole number inside `min` ... `max`, at most 1e15: far more than can be counted, and exact as a real."""

    def __init__(self, min: int | None = None, max: int | None = None) -> None:
        super().__init__(-MOST if min is None else min, MOST if max is None else max)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        if isinstance(value, str) and len(value) > 40:
            self.fail(f"a whole number of at most 15 digits is needed, not {len(value)} characters", param, ctx)
        number = click.INT.convert(value, param, ctx)
        if abs(number) > MOST:
            self.fail(f"a whole number of at most 15 digits is needed, not {number}", param, ctx)
        return super().convert(number, param, ctx)

    def _describe_range(self) -> str:
        """The range in the help, without the limits that nobody meets."""
        low = "" if self.min == -MOST else f"x>={self.min}"
        return low if self.max == MOST else f"{self.min}<=x<={self.max}"


class StepNumber(Whole):
    """The number of a stored step: from 1; counted from the end where it is negative, `end` the last one."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        return -1 if value == "end" else super().convert(value, param, ctx)


class TablePath(click.Path):
    """The name of a file, or - for standard output; another word that begins with - is a forgotten name."""

    def __init__(self) -> None:
        super().__init__(allow_dash=True, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if isinstance(value, str) and value.startswith("-") and value != "-":
            self.fail(f"'{value}' is no name of a file; - prints the rows", param, ctx)
        return super().convert(value, param, ctx)


POSITIVE = Real(min=0.0, min_open=True)
TOLERANCE = Real(min=0.0, min_open=True, max=1.0)
STEPS = Whole(min=1)

MODE = re.compile(r"[+-]?\d+")
FILE, TABLE = click.Path(path_type=Path), TablePath()


class OptionRow(NamedTuple):
    """An option: its spellings, what it means, and for one that takes a value what that is (none: a switch)."""

    spelled: str
    means: str
    value: str = ""
    kind: Any = None


ROWS: dict[str, tuple[Any, ...]] = {
    # what comes out
    "output": ("-o --output", "What is written", "FILE", FILE),
    "output_dir": ("--output-dir", "Folder for what is written", "FOLDER", FILE),
    "overwrite": ("--overwrite", "Replace files that exist"),
    "csv_file": ("--csv", "Write the numbers as csv (-: print them)", "PATH", TABLE),
    "as_json": ("--json", "Print in JSON"),
    "formats": ("--to", "Kind of the file", "KIND"),
    "notation": ("--notation", "How equations are written", "KIND"),
    "form": ("--format", "Text of the equations", "KIND"),
    "language": ("--language", "Language of the program", "NAME"),
    "show": ("--show", "Open a window; without it none is opened"),
    "no_browser": ("--no-browser", "Print the address of the page only"),
    "watch": ("--watch", "Draw again whenever the file changes, until Ctrl-C"),
    "quiet": ("-q --quiet", "Print errors, and what was asked for, only"),
    "verbose": ("-v --verbose", "Print warnings, information and a summary"),
    "as_list": ("--list", "Print the modes instead of drawing them"),
    "expand": ("--expand", "Print the input with plain statements for SECTION, BEAMSEC, UNITS"),
    "equations": ("--equations", "Write all equations in vector notation into the log"),
    "install": ("--install", "Write the script where the shell looks for it, instead of printing it"),
    "build": ("--build", "Make a folder with the MEX file", "[FOLDER]", FILE),
    "release": ("--release", "Solve over-constraints by releases", "[OUTPUT]"),
    "releases": ("--release", "Solve over-constraints by releases"),
    "regardless": ("--force", "Run even if the disk cannot hold the results"),
    "wait": ("--wait", "Wait when another run is writing the same results"),
    "stale_ok": ("--stale-ok", "Take a result although its input file has changed since"),
    # which, how many, what
    "at": ("--at", "Which stored step: from 1; end or -1 the last", "STEP", StepNumber()),
    "n_steps": ("--steps", "How many steps", "N", Whole(min=1)),
    "substeps": ("--substeps", "Steps between two stored ones", "N", Whole(min=1)),
    "duration": ("--time", "Length of the time interval [s]", "SECONDS", POSITIVE),
    "plot": ("--plot", "What is drawn", "EXPRESSION"),
    "against": ("-x --against", "What the horizontal axis shows", "EXPRESSION"),
    "of": ("--of", "The quantity that is meant", "EXPRESSION"),
    "variables": ("--variable", "Whose accuracy is meant", "EXPRESSION"),
    "results": ("-r --result", "Quantity to keep", "[NAME:]EXPRESSION"),
    "node": ("-n --node", "A node", "NODE", Whole(min=1)),
    "element": ("-e --element", "An element", "ELEMENT", Whole(min=1)),
    "parameters": ("-p --parameter", "A number of the input file", "TARGET[=VALUE]"),
    "assignments": ("-s --set", "A setting of the model", "TARGET=VALUES"),
    "orientation": ("--orientation", "Its orientation node, where no element has both", "NODE", Whole(min=1)),
    "mode": ("-m --mode", "Mode of the analysis", "MODE", Whole()),
    "mode_numbers": ("--mode-number", "Vibration or buckling modes", "N"),
    "modes": ("--modes", "How many modes", "N", Whole(min=1)),
    "lowest": ("--lowest", "Only the first N eigenvalues", "N", Whole(min=1)),
    "points": ("--points", "How many places or frequencies", "N", Whole(2, 100000)),
    "place": ("--place", "Place in the element: 0 p, 1 q", "FRACTION", Real(0, 1)),
    "inputs": ("--input", "Input of the system", "NAME"),
    "low": ("--low", "Lowest frequency [Hz]", "HZ", POSITIVE),
    "high": ("--high", "Highest frequency [Hz]", "HZ", POSITIVE),
    # how it is computed
    "atol": ("--atol", "Absolute error tolerance", "ERROR", POSITIVE),
    "rtol": ("--rtol", "Relative error tolerance", "ERROR", TOLERANCE),
    "integrator": ("--integrator", "Integration method", "METHOD", Whole()),
    "compiled": ("--compiled/--general", "Equations in C (default where that is possible), or in NumPy"),
    "beams": ("--beams", "Measure of the deformations of all beams, instead of ADEFORM", "KIND"),
    "elements": ("--elements", "Beams in the place of each flexible beam", "N", Whole(min=1)),
    "rigid_beams": ("--rigid", "Rigid beams: without their dynamic deformations"),
    "accuracy": ("--accuracy", "Error of the result over the amplitude of each variable", "[TARGET]"),
    "fixed_mesh": ("--fixed-mesh", "The accuracy is that of the integration: beams are not divided for it"),
    "setpoints": ("--setpoints", "Result of mode 2 to linearize along, instead of the search by name", "FILE"),
    "jobs": ("-j --jobs", "Local processes", "N", Whole(min=1)),
    "strategy": ("--strategy", "How the equations are derived: readable (held) or lean (recursive)", "KIND"),
    "jacobian": ("--jacobian", "Also the exact Jacobian (python, c, fortran)"),
    "shapes": ("--shapes", "Shapes of a beam", "N", Whole(min=2)),
    "compile": ("--compiled", "Equations in C, compiled by the system compiler"),
    "interpolation": ("--interpolation", "Of matrices and inputs between the stored times", "KIND"),
    "static_start": ("--static-start", "Start from the static answer to sigma0 instead of X0"),
    "quasi_static": ("--quasi-static", "How many of the next modes answer statically", "N", Whole(min=0)),
    "kp": ("--kp", "Proportional gain K_P", "GAIN"),
    "kd": ("--kd", "Derivative gain K_D", "GAIN"),
    "omega": ("--omega", "Frequency of the closed loop [rad/s]", "OMEGA", Real()),
    "damping": ("--damping", "Damping ratio that goes with --omega", "RATIO", Real()),
    # pictures
    "view": ("--view", "View of a spatial mechanism: iso, xy, xz, yz or azimuth,elevation in degrees", "VIEW"),
    "sections": ("--section", "Cross-section instead of BEAMVIS", "TEXT"),
    "opacity": ("--opacity", "Opacity of solids, instead of TRANSPARENCY (1: opaque)", "FRACTION", Real(0, 1)),
    "light": ("--light/--no-light", "Shade solids or not, instead of LIGHT"),
    "hide": ("--hide", "Do not draw this element (DONOTDRAW)", "ELEMENT", Whole()),
    "supports": ("--supports/--no-supports", "Ground symbols, drives and pins"),
    "numbers": ("--numbers", "Numbers of nodes and elements"),
    "node_numbers": ("--node-numbers", "Numbers of the nodes only"),
    "element_numbers": ("--element-numbers", "Numbers of the elements only"),
    "title": ("--title", "Text above the picture, instead of the name of the result", "TEXT"),
    "dpi": ("--dpi", "Resolution of png, gif and mp4 [dots per inch]", "DPI", Real(20, 1200)),
    "fps": ("--fps", "Pictures per second of an animation", "RATE", Real(1, 100)),
    "frames": ("--frames", "Most steps in an animation or a page", "N", Whole(min=2)),
    "strobe": ("--strobe", "N evenly spread steps in one picture", "N", Whole(min=2)),
    "trace": ("--trace", "Path of a node over all steps, instead of TRAJECTNODE", "NODE", Whole()),
    "no_trace": ("--no-trace", "No paths, whatever the settings say"),
    "initial": ("--initial", "Dashed outline of the first step behind the others, in the INITIAL COLOR"),
    "scale": ("--scale", "Draw the deflections from the start so many times as large", "F", Real()),
    "factor": ("--factor", "Enlargement of a mode, instead of ENLARGEFACTOR", "F", Real()),
    "symbols": ("--symbols", "Symbols: loads, reactions, masses, gravity, axes, with commas, or all", "KINDS"),
    "scopes": ("--scopes/--no-scopes", "Scopes of a simulation beside the mechanism"),
    "rest": ("--rest/--no-rest", "Dashed outline of the position at rest"),
    "stress": ("--stress", "Colour beams by a stress resultant or a stress", "QUANTITY"),
    "diagram": ("--diagram", "A stress resultant or a stress as ordinates beside the beams", "QUANTITY"),
    "over_section": ("--over-section", "The stress at every point of the surface, instead of the largest"),
    "log_lines": ("--log-lines", "Lines of the log from its beginning and end; 0: none", "N", Whole(min=0)),
    "viewer": ("--viewer", "With a picture that can be turned and played, as of spacar view (a script)"),
    # flexures
    "move": ("--move", "What is moved and how far, from the reference position", "COORDINATE=RANGE"),
    "force": ("--force", "The same with a force or moment", "COORDINATE=RANGE"),
    "loads": ("--load", "Acts all the time", "COORDINATE=FORCE"),
    "extra": ("--extra", "Does not act: its load multiplier is asked for", "COORDINATE=FORCE"),
    "pivot": ("--pivot", "Ideal pivot, instead of the pole of the undeflected state", "X,Y[,Z]"),
    "axes": ("--axes", "Directions of the stiffness", "KIND"),
    # studies
    "table_file": ("--from", "One case a row; the header holds targets", "CSV", FILE),
    "together": ("--zip", "Take the values of several --set in parallel instead of all combinations"),
    "scheduler": ("--scheduler", "Run on the Dask cluster with this scheduler, not here", "ADDRESS"),
    "retry_failed": ("--retry-failed", "Run cases again that failed earlier"),
    "batch": ("--batch/--no-batch", "Many cases at once in the lanes of the processor's vectors"),
    "integrators": ("-i --integrators", "Integration methods to compare", "CODES"),
    "tolerances": ("-t --tolerances", "Tolerances of methods with variable step", "VALUES"),
    "grids": ("--substeps", "Steps between two stored ones", "VALUES"),
    "meshes": ("--elements", "Beams in the place of each flexible beam", "VALUES"),
    "rigid": ("--rigid", "Also with rigid beams"),
    "linear": ("--linear", "Also without the non-linear strain terms (LDEFORM)"),
    "perturbation": ("--perturbation", "Also by the perturbation method, with the grids of --substeps"),
    "target": ("--target", "Error for which the cheapest setting is recommended", "ERROR", POSITIVE),
    "repeats": ("--repeats", "Runs of each setting; the median time counts", "N", Whole(min=1)),
    "judges": ("--reference", "Two methods whose agreement makes the reference", "CODES"),
    "budget": ("--budget", "Seconds for everything", "SECONDS", POSITIVE),
}
VOCABULARY = {name: OptionRow(*row) for name, row in ROWS.items()}

FIGURES = "-o FILE, by its ending (.png, .svg, .pdf)"
FORMER = {
    "MODE": {"-o": "--output-dir", "--plot": "--show"},
    "-MODE": {"-o": "--output-dir"},
    "draw": {"--steps": "--at", "--step": "--at", "-s": "--at", "-n": "--numbers"},
    "visual": {"--step": "--at", "-n": "--numbers", "-m": "--mode-number"},
    "report": {"-p": "--plot"},
    "stress": {
        "--step": "--at", "--at": "--place for a place, and which step", "--quantity": "--of", "--picture": FIGURES,
        "--npz": "-o FILE.npz",
    },
    "eigen": {"--step": "--at", "--csv": "--csv PATH (- prints)"},
    "bode": {"--step": "--at", "--csv": "--csv PATH (- prints)", "--to": "--of"},
    "compliance": {"--step": "--at"},
    "getfrsbf": {"--step": "--at", "--steps": "--at", "-s": "--at"},
    "getss": {"--step": "--at"},
    "repinsbf": {"--step": "--at"},
    "sensitivity": {"--quantity": "--of", "-q": "--of (-q is quiet)"},
    "flexure": {"--report": "-o PAGE.html", "--plot": FIGURES, "--npz": "-o FILE.npz"},
    "sim": {"--plot": "--show", "--picture": FIGURES},
    "ltv": {"--plot": "--show", "--picture": FIGURES},
    "trade": {"--plot": FIGURES, "-e": "--elements"},
    "examples": {"--to": "--output-dir", "--force": "--overwrite"},
    "combsbd": {"--force": "--overwrite"},
    "symbolic derive": {"--show": "--notation"},
    "symbolic simulate": {"--show": "--equations", "--compile": "--compiled", "--plot": "--plot NAME (or all)"},
}  # fmt: skip


Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


def parameter(name: str, more: str = "", **changes: Any) -> click.Option:
    """The option of this name for one command: `more` goes on behind what it means, `changes` to what click is told."""
    spellings, told = _told(name, more, changes)
    return click.Option(spellings, **told)


def option(name: str, more: str = "", **changes: Any) -> Decorator:
    """`parameter` as a decorator of a command."""
    spellings, told = _told(name, more, changes)
    return click.option(*spellings, **told)


def _told(name: str, more: str, changes: dict[str, Any]) -> tuple[list[str], dict[str, Any]]:
    """What click is told about an option: its spellings with its name, and the rest."""
    word = VOCABULARY[name]
    told: dict[str, Any] = {"help": f"{word.means}{more if more[:1] in ',:; ' else f'. {more}'}".rstrip(".") + "."}
    told |= {"metavar": word.value, "type": word.kind} if word.value else {"is_flag": True}
    told["show_default"] = changes.get("default") is not None and "efault" not in told["help"]
    if isinstance(changes.get("type"), click.Choice):
        del told["metavar"]  # the choices are better
    return [*word.spelled.split(), name], told | changes


def options(rows: Sequence[Decorator]) -> Decorator:
    """Options that several commands share, as one decorator."""
    return lambda function: reduce(lambda so_far, row: row(so_far), reversed(rows), function)


def _kept(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    """The environment is quiet or verbose, for errors and warnings of the input too."""
    if value:
        ctx.obj.asked.add(param.name)


class Command(click.Command):
    """A command that can be quiet and verbose."""

    def __init__(self, *args: Any, **more: Any) -> None:
        super().__init__(*args, **more)
        self.params += [parameter(name, callback=_kept, expose_value=False) for name in ("quiet", "verbose")]


def command(name: str, **settings: Any) -> Callable[[Callable[..., Any]], click.Command]:
    """The function as a command: it gets the environment, its file if it has one, and its options by name."""

    def made(function: Callable[..., Any]) -> click.Command:
        takes = get_type_hints(function)
        if "file" in takes:
            click.argument("file", type=FILE if takes["file"] is Path else None)(function)
        given = click.pass_obj(function) if "environment" in takes else function
        return click.command(name, cls=Command, **settings)(given)

    return made


def renamed(arguments: Sequence[str]) -> list[str]:
    """What to write instead of the former spellings among the words of a command line."""
    name = " ".join(arguments[: 2 if arguments[:1] == ["symbolic"] else 1])
    former = FORMER.get(re.sub(r"^\+?\d+$", "MODE", re.sub(r"^-\d+$", "-MODE", name)), {})
    spelled = {old: (f"{old}=" if old.startswith("--") else old) for old in former}  # with a value behind it
    given = [old for old, begin in spelled.items() if any(w == old or w.startswith(begin) for w in arguments)]
    return [f"{old} is now {former[old]}" for old in given]
