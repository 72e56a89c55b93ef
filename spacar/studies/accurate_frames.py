"""Where `spacar.stream.Run` finds the frames of a run whose accuracy is asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from spacar.frame import Frame
from spacar.stream import Run
from spacar.studies import accuracy, mesh_accuracy


def frames(run: Run) -> Iterator[Sequence[Frame]]:
    """Frames with `xerr`, and `header["accuracy"]`: with the error of the mesh where there are beams to divide."""
    assert run.accuracy is not None
    if run.mode.stationary:
        return mesh_accuracy.stationary(run)
    if run.accuracy.mesh and mesh_accuracy.divisible(run)[0]:
        return mesh_accuracy.motion(run)
    return accuracy.forward(run)
