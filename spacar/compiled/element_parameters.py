"""Parameters of the compiled element functions from the element families, in the order of `definitions`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import Family

# What guards must be above: cosines of angles (45 degrees pass) or, for lengths, the part that is left plus LEFT.
GUARD, LEFT = 0.71, 0.7


def _plbeam(f: Family) -> Array:
    return np.stack([f.length, f.angle[0], 0.5 * f.A2, f.B, f.unit, f.lumped])  # type: ignore[attr-defined]


def _plpinbod(f: Family) -> Array:
    a, d = f.a, f.d0  # type: ignore[attr-defined]
    return np.stack([a[0, 0], a[0, 1], d[0], a[1, 0], a[1, 1], d[1]])


def _length(f: Family) -> Array:
    return f.length[None, :]


def _none(f: Family) -> Array:
    return np.zeros((0, f.n))


def _frame(f: Family) -> Array:
    assert f.frame_p is not None
    return f.frame_p.T


def _beam(f: Family) -> Array:
    assert f.data is not None
    second = f.constants.g * f.length  # type: ignore[attr-defined]
    unit = f.line.C[0, 0] / 156.0  # type: ignore[attr-defined]
    return np.vstack((f.length, _frame(f), f.data[:, 0], second, unit))


def _beam_angle(f: Family) -> Array:
    a = f.angles  # type: ignore[attr-defined]
    unit = f.line.C[0, 0] / 156.0  # type: ignore[attr-defined]
    return np.vstack((f.length, _frame(f), a.f, a.second, unit, a.shear[:2], a.ratio))


def _pinbody(f: Family) -> Array:
    return np.vstack((_frame(f), f.r))  # type: ignore[attr-defined]


def _body(f: Family) -> Array:
    J = f.J  # type: ignore[attr-defined]
    return np.stack([J[0, 0], J[0, 1], J[0, 2], J[1, 1], J[1, 2], J[2, 2]])


# form of the family (keyword and measure) -> kind (name of its definition), parameters (n_parameters, n)
SUPPORTED: dict[str, tuple[str, Callable[[Family], Array]]] = {
    "PLBEAM": ("plbeam", _plbeam),
    "PLBEAM angle": ("plbeam_angle", _plbeam),
    "PLTRUSS": ("pltruss", _length),
    "PLTOR": ("pltor", _none),
    "PLPINBOD": ("plpinbod", _plpinbod),
    "PLRBEAM": ("plpinbod", _plpinbod),
    "BEAM": ("beam", _beam),
    "BEAM angle": ("beam_angle", _beam_angle),
    "BEAMW": ("beamw", _beam),
    "TRUSS": ("truss", _length),
    "HINGE": ("hinge", _frame),
    "PINBODY": ("pinbody", _pinbody),
    "RBEAM": ("pinbody", _pinbody),
    "normalization": ("normalization", _none),
    "rigid body": ("body", _body),
}


def kinds() -> tuple[str, ...]:
    """All kinds in the order of their numbers in C."""
    return tuple(dict.fromkeys(kind for kind, _ in SUPPORTED.values()))
