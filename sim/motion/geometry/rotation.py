# SPDX-License-Identifier: Apache-2.0
"""Rotation of a coordinate system about the Z axis through its origin (G10 L2 R)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sim.motion.geometry.moves import Pose

_QUARTERS = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))


class Rotation:
    """Turns X and Y of a pose counter-clockwise by an angle in degrees; quarters are exact."""

    def __init__(self, degrees: float = 0.0) -> None:
        self.degrees = degrees
        quarters, rest = divmod(degrees, 90.0)
        if rest == 0.0:
            self.cosine, self.sine = _QUARTERS[int(quarters) % 4]
        else:
            angle = math.radians(degrees)
            self.cosine, self.sine = math.cos(angle), math.sin(angle)

    def __bool__(self) -> bool:
        """Whether it turns anything."""
        return self.cosine != 1.0

    def turned(self, pose: Sequence[float]) -> Pose:
        """The pose with X and Y turned; the other axes are unchanged."""
        x, y, z, tilt, rotation = pose
        first, second = x * self.cosine - y * self.sine, x * self.sine + y * self.cosine
        return first, second, z, tilt, rotation

    def turned_rows(self, poses: NDArray[np.float64]) -> NDArray[np.float64]:
        """Poses (n, 5), or directions, with X and Y turned; a new array."""
        x, y = poses[:, 0], poses[:, 1]
        pair = [x * self.cosine - y * self.sine, x * self.sine + y * self.cosine]
        return np.column_stack([*pair, poses[:, 2:]])

    def turned_back(self, pose: Sequence[float]) -> Pose:
        """The inverse of `turned`."""
        x, y, z, tilt, rotation = pose
        first, second = x * self.cosine + y * self.sine, y * self.cosine - x * self.sine
        return first, second, z, tilt, rotation
