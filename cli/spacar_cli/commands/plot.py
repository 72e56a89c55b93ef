"""`spacar plot FILE EXPR...`: time histories, or one expression against another."""

from __future__ import annotations

from pathlib import Path

import click

from spacar_cli.drawing_options import OUTPUT
from spacar_cli.environment import Environment
from spacar_cli.number_types import Real
from spacar_cli.status import tell


@click.command("plot")
@click.argument("file")
@click.argument("expressions", metavar="EXPR...", nargs=-1, required=True)
@OUTPUT
@click.option("--against", "-x", metavar="EXPR", default="t", show_default=True, help="What the horizontal axis shows.")
@click.option(
    "--csv",
    "csv_file",
    type=click.Path(path_type=Path, allow_dash=True),
    help="Write the numbers as csv ('-': print them); no picture then, unless --output is given.",
)
@click.option("--title", help="Text above the plot, instead of the name of the result.")
@click.option(
    "--dpi",
    type=Real(20, 1200),
    default=150.0,
    show_default=True,
    help="Resolution of png [dots per inch].",
)
@click.option("--show", is_flag=True, help="Open a window. Without this option no window is opened.")
@click.option("--stale-ok", is_flag=True, help="Plot a result although its input file has changed since.")
@click.pass_obj
def command(
    environment: Environment,
    /,
    file: str,
    expressions: tuple[str, ...],
    output: tuple[Path, ...],
    against: str,
    csv_file: Path | None,
    title: str | None,
    dpi: float,
    show: bool,
    stale_ok: bool,
) -> None:
    """Plot expressions of the variables of a result file (NAME.sbd) over time.

    Variables of nodes x, xd, xdd, fx, fxgrav, fxtot, xcompl as x[NODE,COORDINATE]; of elements e, ed, edd, sig as
    e[ELEMENT,MODE]; t. With + - * / ** and pi, functions such as max mean abs sqrt sin deg hypot atan2, and one step
    as x[6,1]@end (docs/expressions.md). Example:

    spacar plot crank 'x[6,1]' 'xdd[6,1]' 'sig[1,1]'

    Results of spacar sim and ltv have their signals too, by block or scope and number, also in expressions:
    spacar plot robotsim_sim robot:10-12 error 'robot[10] - y0[10]'

    Results of spacar symbolic have states, inputs and outputs by their names: spacar plot manipulator q1 'q4 - q1'

    Without --output the picture is NAME_plot.png beside the result.
    """
    from spacar_drawing.curves import curves_of, evaluate, in_units, warnings
    from spacar_drawing.files import check_name, save
    from spacar_drawing.history import csv_text, history_figure
    from spacar_drawing.picture_source import open_source
    from spacar_formats.safety import write_text

    source = open_source(file, stale_ok, drawn=False)
    curves = [curve for text in expressions for curve in curves_of(source, text)]
    across = evaluate(source, against)
    for warning in warnings([*curves, across]):
        tell(environment, "warning", warning)
    outputs = list(output)
    if not outputs and csv_file is None and not show:
        outputs = [Path(source.name).parent / f"{source.scene.title}_plot.png"]
    for path in outputs:
        check_name(path, film=False)
    if csv_file is not None:
        text = csv_text(curves, across)
        if str(csv_file) == "-":
            environment.stdout.write(text)
        else:
            write_text(csv_file, text)
            environment.say(str(csv_file))
    if not outputs and not show:
        return
    metre = source.scene.metre
    curves, across = [in_units(c, metre) for c in curves], in_units(across, metre)
    figure = history_figure(
        curves, across, source.scene.title if title is None else title, source.scene.analysis.stationary
    )
    for path in outputs:
        save(figure, path, dpi)
        environment.say(str(path))
    if show:
        from spacar_drawing.window import still_window

        still_window(figure)
