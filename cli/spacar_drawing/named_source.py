"""Results of `spacar symbolic`: quantities by name over time, without nodes and elements."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError
from spacar_drawing.scene import Scene
from spacar_drawing.settings import Settings
from spacar_drawing.source import Source, open_source

GROUPS = {"Q": "QNAME", "S": "SNAME", "U": "UNAME", "Y": "YNAME"}


def open_plotted(name: str | Path, stale_ok: bool = False) -> Source:
    """The `.sbd` of this name for curves: one of a mode as `open_source` gives it, or one of `spacar symbolic`.

    Raises UsageError when there is no result or when it has no steps.
    """
    from spacar_formats.locate import open_result

    wanted = Path(name)
    symbolic = wanted.with_suffix("") if wanted.suffix.lower() in (".toml", ".py") else wanted
    try:
        return open_source(symbolic, stale_ok)
    except UsageError as error:
        if error.code != "draw.symbolic":
            raise
    file = open_result(symbolic, "sbd")
    if not file.steps:
        raise UsageError(f"{file.path} contains no steps: the run stopped before the first one", "draw.empty")
    named: dict[str, Array] = {}
    for letter, names in GROUPS.items():
        if file.has(letter):
            values = np.asarray(file.get(letter)).reshape(file.steps, -1)
            named |= dict(zip((str(n) for n in file.header[names]), values.T, strict=True))
    time = np.asarray(file.get("T"), float).reshape(file.steps)

    def read(variable: str, k: int | None) -> Array | None:
        if variable.lower() != "t":
            return None
        return time if k is None else time[k - 1 : k]

    header = dict(file.header.items())
    stem = file.path.name.removesuffix(".part").removesuffix(".bak").removesuffix(".sbd")
    return Source(_nothing(stem), Settings(), file.steps, str(file.path), None, read, header, file.complete, named)


def _nothing(title: str) -> Scene:
    """A moving scene without elements: mode 1 says that the steps are times."""
    none, whole = np.zeros((0, 0)), np.zeros((0, 0), int)
    return Scene(
        planar=True, mode=1, title=title, keywords=(), lnp=whole, le=whole, ln=whole, frame_p=none, frame_q=none,
        length=none, data=none, stiffness=none, damping=none, quadratic=whole, nxp=whole, nep=whole,
    )  # fmt: skip
