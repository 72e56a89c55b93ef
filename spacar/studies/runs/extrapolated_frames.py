"""Frames of the finest of several meshes, every variable extrapolated with the order that it shows."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from spacar.arrays import Array
from spacar.frame import Frame
from spacar.kinematics.element_sweep import ElementSweep
from spacar.mechanism import Mechanism
from spacar.studies.runs.extrapolation import extrapolate
from spacar.studies.runs.user_nodes import deform

FIELDS = ("x", "xd", "xdd", "sig", "fx", "fxtot", "xcompl")
SPECTRA = ("eigval", "lmult")


def extrapolated_frames(
    given: Mechanism, meshes: Sequence[Sequence[Frame]]
) -> list[Frame]:
    """On the nodes of the mechanism `given`; deformations follow from the coordinates."""
    fine = meshes[-1]
    found = [replace(f, matrices=dict(f.matrices)) for f in fine]
    for name in FIELDS:
        if getattr(fine[0], name) is not None:
            every = _better([np.array([getattr(f, name) for f in frames]) for frames in meshes])
            for frame, value in zip(found, every, strict=True):
                setattr(frame, name, value)
    for name in SPECTRA:
        if name in fine[0].matrices:  # what is nan has no order and stays so
            stacks = [[f.matrices[name] for f in frames] for frames in meshes]
            if len({a.shape for stack in stacks for a in stack}) == 1:
                for frame, value in zip(found, _better([np.array(s) for s in stacks]), strict=True):
                    frame.matrices[name] = value
    sweep = ElementSweep(given)
    for frame in found:
        deform(given, sweep, frame, frame)
    return found


def _better(arrays: list[Array]) -> Array:
    """Arrays (steps, ...) of the meshes, extrapolated."""
    shape = arrays[0].shape
    rows = [np.moveaxis(a, 0, -1).reshape(-1, shape[0]) for a in arrays]
    size = np.maximum(np.abs(rows[-1]).max(axis=1, initial=0.0), np.finfo(float).tiny)
    values = extrapolate(rows, size).values
    return np.moveaxis(values.reshape(*shape[1:], shape[0]), -1, 0)
