"""Parameters of the compiled element functions from the element families, in the order of `definitions`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from spacar.arrays import Array
from spacar.elements.family import Family

# What guards must be above: cosines of angles (45 degrees pass) or, for lengths, the part that is left plus LEFT.
GUARD, LEFT = 0.71, 0.7


def _plbeam(f: Family) -> Array:
    start = getattr(f, "start", np.zeros((3, f.n)))  # of tubes
    rotation = getattr(f, "rotary", f.lumped)  # type: ignore[attr-defined]  # of the angle measure the whole
    own = f.length, f.angle, 0.5 * f.A2, f.B, start, f.unit, rotation  # type: ignore[attr-defined]
    rows = np.empty((10, f.n), np.result_type(*own))
    rows[0], rows[1:3], rows[3], rows[4], rows[5:8], rows[8], rows[9] = own
    return rows


def _flow(f: Family) -> Array:
    """Mass flow and thrust a G U/l0 of a fluid; both again where it leaves at p, at q."""
    flow, fluid, shape = f.flow, f.fluid, f.shape_factor  # type: ignore[attr-defined]
    thrust = shape * flow**2 / (np.where(flow == 0.0, 1.0, fluid) * f.length)
    jets = f.jet_p, f.jet_q  # type: ignore[attr-defined]
    return np.stack([flow, *(flow * jet for jet in jets), thrust, *(thrust * jet for jet in jets)])


def _pltube(f: Family) -> Array:
    return np.vstack((_plbeam(f), _flow(f)))


def _plwheel(f: Family) -> Array:
    return np.stack([f.radius, f.angle])  # type: ignore[attr-defined]


def _plbelt(f: Family) -> Array:
    return np.stack([f.length, *f.radii, *f.u0, f.unit, *f.wound])  # type: ignore[attr-defined]


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


def _ends(f: Family, more: int = 0) -> Array:
    """Length, start frames at the ends, the turn between them, constants of strain, mass, shear; more rows."""
    assert f.frame_p is not None
    assert f.frame_q is not None
    assert f.data is not None
    second, unit, shear = f.second, f.unit, f.shear  # type: ignore[attr-defined]
    rows = np.zeros((28 + more, f.n), np.result_type(f.length, f.frame_p, f.data, second, unit, shear))
    rows[0] = f.length
    rows[1:10] = f.frame_p.T
    rows[10:19] = f.frame_q.T
    rows[19] = 1.0
    if f.frame_q is not f.frame_p and not np.array_equal(f.frame_p, f.frame_q):
        from spacar.elements.rotation import parameters_of_frame  # curved tubes only

        own = np.flatnonzero((f.frame_p != f.frame_q).any(1))
        frames = (of[own].reshape(-1, 3, 3) for of in (f.frame_q, f.frame_p))
        turned = parameters_of_frame(np.einsum("nai,naj->ijn", *frames))
        rows[19:23, own] = np.where(turned[0] < 0.0, -turned, turned)
    rows[23] = f.data[:, 0]
    rows[24] = second
    rows[25] = unit
    rows[26:28] = shear
    return rows


def _beam(f: Family) -> Array:
    rows = _ends(f, 6)
    start = getattr(f, "start", None)  # of tubes
    if start is not None:
        rows[28:] = start
    return rows


def _beam_angle(f: Family) -> Array:
    a = f.angles  # type: ignore[attr-defined]
    return np.vstack((_beam(f), a.ratio, a.start))


def _tube(f: Family) -> Array:
    return np.vstack((_beam(f), _flow(f)))


def _tube_angle(f: Family) -> Array:
    return np.vstack((_beam_angle(f), _flow(f)))


def _screw(f: Family) -> Array:
    return np.vstack((_frame(f), f.r, f.pitch))  # type: ignore[attr-defined]


def _wheel(f: Family) -> Array:
    from spacar.elements.wheel import LEFT as HEIGHT  # spatial only

    assert f.frame_p is not None
    radius, rho = f.radius, f.rho  # type: ignore[attr-defined]
    return np.vstack((f.frame_p[:, 6:].T, radius, rho, HEIGHT * (radius + rho)))


def _pinbody(f: Family) -> Array:
    return np.vstack((_frame(f), f.r))  # type: ignore[attr-defined]


def _body(f: Family) -> Array:
    J = f.J  # type: ignore[attr-defined]
    return np.stack([J[0, 0], J[0, 1], J[0, 2], J[1, 1], J[1, 2], J[2, 2]])


# form of the family (keyword and measure) -> kind (name of its definition), parameters (n_parameters, n)
SUPPORTED: dict[str, tuple[str, Callable[[Family], Array]]] = {
    "PLBEAM": ("plbeam", _plbeam),
    "PLBEAM angle": ("plbeam_angle", _plbeam),
    "PLTUBE": ("pltube", _pltube),
    "PLTUBE angle": ("pltube_angle", _pltube),
    "PLTRUSS": ("pltruss", _length),
    "PLTOR": ("pltor", _none),
    "PLPINBOD": ("plpinbod", _plpinbod),
    "PLRBEAM": ("plpinbod", _plpinbod),
    "PLWHEEL": ("plwheel", _plwheel),
    "PLBELT": ("plbelt", _plbelt),
    "BEAM": ("beam", _beam),
    "BEAM angle": ("beam_angle", _beam_angle),
    "TUBE": ("tube", _tube),
    "TUBE angle": ("tube_angle", _tube_angle),
    "BEAMW": ("beamw", _ends),
    "BEAMW angle": ("beamw_angle", _ends),
    "TRUSS": ("truss", _length),
    "HINGE": ("hinge", _frame),
    "PINBODY": ("pinbody", _pinbody),
    "RBEAM": ("pinbody", _pinbody),
    "SCREW": ("screw", _screw),
    "WHEEL": ("wheel", _wheel),
    "TWHEEL": ("wheel", _wheel),
    "normalization": ("normalization", _none),
    "rigid body": ("body", _body),
}


def kinds() -> tuple[str, ...]:
    """All kinds in the order of their numbers in C."""
    return tuple(dict.fromkeys(kind for kind, _ in SUPPORTED.values()))
