"""`spacar plot FILE EXPR...`: time histories, or one expression against another."""

from pathlib import Path

import click
import numpy as np
from spacar_drawing.curves import curves_of, evaluate, in_units, warnings
from spacar_drawing.files import check_stills
from spacar_drawing.history import axis_text, history_figure
from spacar_drawing.picture_source import open_source

from spacar_cli import vocabulary as words
from spacar_cli.drawing_options import PICTURES
from spacar_cli.environment import Environment, tell_notes
from spacar_cli.row_output import put_figure, put_rows


@words.command("plot")
@click.argument("expressions", metavar="EXPR...", nargs=-1, required=True)
@words.option("output", PICTURES, multiple=True)
@words.option("against", default="t")
@words.option("csv_file", "; no picture then, unless --output is given.")
@words.option("title")
@words.option("dpi", default=150.0)
@words.option("show")
@words.option("stale_ok")
def command(
    environment: Environment, file: str, expressions: tuple[str, ...], output: tuple[Path, ...], against: str,
    csv_file: Path | None, title: str | None, dpi: float, show: bool, stale_ok: bool,
) -> None:  # fmt: skip
    """Plot expressions of the variables of a result file (NAME.sbd) over time.

    Variables of nodes x, xd, xdd, fx, fxgrav, fxtot, xcompl as x[NODE,COORDINATE]; of elements e, ed, edd, sig as
    e[ELEMENT,MODE]; t. With + - * / ** and pi, functions such as max mean abs sqrt sin deg hypot atan2, and one step
    as x[6,1]@end (`spacar help expressions`). Example:

    spacar plot crank 'x[6,1]' 'xdd[6,1]' 'sig[1,1]'

    Results of spacar sim and ltv have their signals too, by block or scope and number, also in expressions:
    spacar plot robotsim_sim robot:10-12 error 'robot[10] - y0[10]'

    Results of spacar symbolic have states, inputs and outputs by their names: spacar plot manipulator q1 'q4 - q1'

    Without --output the picture is NAME_plot.png beside the result.
    """
    source = open_source(file, stale_ok, drawn=False)
    curves = [curve for text in expressions for curve in curves_of(source, text)]
    across = evaluate(source, against)
    tell_notes(environment, warnings([*curves, across]))
    outputs = list(output)
    if not outputs and csv_file is None and not show:
        outputs = [source.beside("_plot.png")]
    check_stills(outputs)
    if csv_file is not None:
        columns = [across, *curves]
        rows = zip(*(np.asarray(c.values).tolist() for c in columns), strict=True)
        put_rows(environment, csv_file, [axis_text(c) for c in columns], rows)
    if not outputs and not show:
        return
    metre = source.scene.metre
    curves, across = [in_units(c, metre) for c in curves], in_units(across, metre)
    figure = history_figure(
        curves, across, source.scene.title if title is None else title, source.scene.analysis.stationary
    )
    put_figure(environment, figure, outputs, dpi, show)
