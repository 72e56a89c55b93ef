"""Orthographic projection: the same for both kinds of mechanisms, so that all axes have the same scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from spacar.arrays import Array
from spacar.errors import UsageError

NAMED = {"iso": (-55.0, 24.0), "xy": (-90.0, 90.0), "xz": (-90.0, 0.0), "yz": (0.0, 0.0), "top": (-90.0, 90.0)}


@dataclass(frozen=True)
class Camera:
    """Axes of the picture in space: right, up, and towards the viewer; each (3,). `metre`: unit on the axes [m]."""

    right: Array
    up: Array
    near: Array
    planar: bool
    metre: float = 1.0

    @classmethod
    def plane(cls) -> Camera:
        """Looks at the plane z = 0 from above."""
        x, y, z = np.eye(3)
        return cls(x, y, z, True)

    @classmethod
    def towards(cls, azimuth: float, elevation: float) -> Camera:
        """From the direction of these angles [degrees]: azimuth in the xy plane from x, elevation above it."""
        a, b = np.radians(azimuth), np.radians(elevation)
        near = np.array([np.cos(b) * np.cos(a), np.cos(b) * np.sin(a), np.sin(b)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        return cls(right, np.cross(near, right), near, False)

    def project(self, points: Array) -> Array:
        """(..., 2) places in the picture [m] of points (..., 3)."""
        return points @ np.stack((self.right, self.up), axis=1)

    def depth(self, points: Array) -> Array:
        """Distance towards the viewer [m]."""
        return points @ self.near


def view_angles(text: str) -> tuple[float, float]:
    """`iso`, `xy`, `xz`, `yz`, or azimuth and elevation in degrees as `-60,25`. Raises UsageError."""
    if text.lower() in NAMED:
        return NAMED[text.lower()]
    try:
        azimuth, elevation = (float(w) for w in text.split(","))
    except ValueError:
        raise UsageError(f"--view {text}: write iso, xy, xz, yz or azimuth,elevation in degrees as -60,25") from None
    if not (abs(azimuth) <= 360 and abs(elevation) <= 90):
        raise UsageError(f"--view {text}: azimuth within 360 and elevation within 90 degrees")
    return azimuth, elevation
