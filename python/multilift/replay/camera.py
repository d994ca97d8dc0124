"""Where a picture is seen from: perspective, all of a box inside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Camera:
    """An eye that looks at a box.

    Attributes:
        eye: its place, m.
        right, up, ahead: unit vectors of the picture.
    """

    def __init__(self, box: Array, yaw: float, pitch: float, width: float, height: float) -> None:
        """Looks at `box`, shape (2, 3), m, from `yaw` about z and `pitch` above level, rad."""
        self.width, self.height = width, height
        self.focal = 1.05 * height
        c, s = np.cos(pitch), np.sin(pitch)
        self.ahead: Array = -np.array([c * np.cos(yaw), c * np.sin(yaw), s])
        self.right: Array = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
        self.up: Array = np.cross(self.right, self.ahead)
        corners = np.array(np.meshgrid(*box.T)).reshape(3, -1).T
        target = box.mean(axis=0)
        distance = 2.0 * float(np.linalg.norm(box[1] - box[0]))
        for _ in range(6):
            self.eye: Array = target - distance * self.ahead
            seen = self.project(corners)[:, :2]
            middle, size = 0.5 * (seen.min(axis=0) + seen.max(axis=0)), np.ptp(seen, axis=0)
            shift = (middle - [0.5 * width, 0.5 * height]) * distance / self.focal
            target = target + shift[0] * self.right - shift[1] * self.up
            distance *= float(max(size[0] / (0.9 * width), size[1] / (0.8 * height)))
        self.eye = target - distance * self.ahead

    def project(self, points: Array) -> Array:
        """Pixels right and down from the picture's corner, and depth in m, shape (k, 3)."""
        away = points - self.eye
        depth = np.maximum(away @ self.ahead, 0.02)
        scale = self.focal / depth
        return np.column_stack(
            [
                0.5 * self.width + scale * (away @ self.right),
                0.5 * self.height - scale * (away @ self.up),
                depth,
            ]
        )
