"""`spacar compliance FILE NODE [ORIENTATION]`: the compliance matrix of a node."""

import click

from spacar.deck.length_unit import shown_in
from spacar_cli import vocabulary as words
from spacar_cli.environment import Environment, tell_notes
from spacar_cli.vocabulary import Whole


@words.command("compliance")
@click.argument("node", type=Whole())
@click.argument("orientation", type=Whole(), required=False)
@words.option("at", default=1)
@words.option("as_json")
def command(environment: Environment, file: str, node: int, orientation: int | None, at: int, as_json: bool) -> None:
    """Compliance of a position node and its orientation node in a result of mode 7, 8, 9 or 10.

    The displacements and small rotations (6, planar 3) by unit forces and moments at the loaded state, along the global
    axes and along the axes of the orientation node. Needs dx in the result (OUTLEVEL 0 1, the default of these modes),
    or of a large model its sparse tangent ktan. The tables are in the unit of length of the input (UNITS), JSON in SI.
    """
    import numpy as np
    from spacar_drawing.picture_source import open_source
    from spacar_formats.compliance import node_compliance
    from spacar_formats.log.text_layout import matrix

    found, warnings = node_compliance(file, node, orientation, at)
    tell_notes(environment, warnings)
    rows, columns = found.labels
    if as_json:
        environment.say_json({
            "t": found.t, "position": found.position, "orientation": found.orientation, "rows": rows,
            "columns": columns, "global": found.fixed.tolist(), "body": found.body.tolist(),
        })  # fmt: skip
        return
    metre = open_source(file, stale_ok=True).scene.metre
    power = np.array([name.startswith("u") for name in rows], float)  # C_ij has the unit of i times that of j by N m
    factor = metre ** (1.0 - power[:, None] - power)
    unit = shown_in("m", metre)[1]
    where = f"position node {found.position}, orientation node {found.orientation}"
    for title, value in (("global axes", found.fixed), ("axes of the body", found.body)):
        environment.say(f"Compliance of {where}, {title}, in {unit} and rad by N and N {unit}")
        environment.say(*matrix(value * factor, rows, columns, width=6))
