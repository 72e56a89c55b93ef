"""Names and one-line helps of all modes and commands: what `spacar --help` prints without importing anything.

A command is `module:attribute` of a click command, imported when it is called. The titles of the modes repeat
`spacar.modes.MODES`, which needs NumPy; a test keeps them equal.
"""

from __future__ import annotations

MODES = {
    0: "kinematic check",
    1: "forward dynamics",
    2: "inverse dynamics",
    3: "linearization along set-points",
    4: "forward dynamics with linearization",
    7: "stationary solution, eigenvalues",
    8: "stationary solution, buckling",
    9: "stationary solution, state space",
    10: "stationary solution, eigenvalues and buckling",
}

COMMANDS = {
    "check": ("spacar_cli.commands.check:check", "read an input file and report, without running it"),
    "keywords": ("spacar_cli.commands.keywords:keywords", "the keywords of the input language"),
    "examples": ("spacar_cli.commands.examples:examples", "list or copy the example models"),
}
