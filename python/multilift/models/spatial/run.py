"""A run of the spatial plant."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from multilift.models.spatial.scenario import SpatialScenario
from multilift.run import Run

Array = NDArray[np.float64]


class SpatialRun(Run):
    """Trajectory, metrics and audit of a spatial run; see :class:`multilift.Run`.

    ``status`` is "finished", "collision" or "diverged"; of a flight that was measured also "left",
    if it left the scenario's course.
    """

    scenario: SpatialScenario

    def vector(self, name: str) -> Array:
        """The columns ``name_x``, ``name_y``, ``name_z`` as one array, shape (rows, 3)."""
        return np.stack([self[f"{name}_{axis}"] for axis in "xyz"], axis=1)

    def attitude(self, name: str) -> Array:
        """The unit quaternions of "payload" or "vehicle1", ..., scalar first, shape (rows, 4)."""
        return np.stack([self[f"{name}_q{part}"] for part in "wxyz"], axis=1)

    def attachments(self) -> Array:
        """Where the cables are tied to the payload, world, shape (rows, n, 3), m."""
        local = np.array(self.scenario["plant.attachment"])
        turned = np.einsum("tij,nj->tni", rotation_matrices(self.attitude("payload")), local)
        return np.asarray(self.vector("payload")[:, None] + turned)

    def swing(self) -> Array:
        """Angle of each cable from its direction at rest, shape (rows, n), rad."""
        rest = self.scenario.rest.cable_force[0]
        rest = rest / np.linalg.norm(rest, axis=1)[:, None]
        yaw = self["target_yaw"]
        ahead = np.stack([np.cos(yaw), np.sin(yaw)], axis=1)
        turned = np.stack(
            [
                ahead[:, :1] * rest[:, 0] - ahead[:, 1:] * rest[:, 1],
                ahead[:, 1:] * rest[:, 0] + ahead[:, :1] * rest[:, 1],
                np.broadcast_to(rest[:, 2], (len(yaw), len(rest))),
            ],
            axis=2,
        )
        vehicles = np.stack(
            [self.vector(f"vehicle{k + 1}") for k in range(self.scenario.count)], axis=1
        )
        along = vehicles - self.attachments()
        along /= np.linalg.norm(along, axis=2)[..., None]
        chord = np.linalg.norm(along - turned, axis=2)
        return np.asarray(2.0 * np.arcsin(np.minimum(chord / 2.0, 1.0)))


def rotation_matrices(q: Array) -> Array:
    """Matrices that turn a body's coordinates into the world's, from unit quaternions.

    Args:
        q: shape (rows, 4), scalar first.

    Returns:
        Shape (rows, 3, 3).
    """
    w, x, y, z = q.T
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
