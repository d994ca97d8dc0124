"""The view in space: world ENU, x red, y green, z up blue, m."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import viser
from numpy.typing import NDArray

from multilift.flight.snapshot import Quaternion, Snapshot, Vector
from multilift.flight.web.history import History
from multilift.flight.web.stage import Points, Stage
from multilift.models.spatial.run import rotation_matrices
from multilift.replay.colours import SLACK, rgb, tension_colours, vehicle_colour

Array = NDArray[np.float64]

_LOAD, _FENCE, _STALE = (255, 240, 205), (110, 122, 140), (230, 60, 60)

#: How often trails grow, in drawings of the rest.
_TRAILS = 4


def edges(low: Sequence[float], high: Sequence[float]) -> Array:
    """The twelve edges of a box, shape (12, 2, 3)."""
    corners = list(itertools.product(*zip(low, high, strict=True)))
    return np.array([
        (a, b)
        for a, b in itertools.combinations(corners, 2)
        if sum(x != y for x, y in zip(a, b, strict=True)) == 1
    ])  # fmt: skip


def feet(position: Vector, attitude: Quaternion, attachments: Points) -> Array:
    """Where cables are tied to the payload, world, shape (n, 3), m."""
    turn = rotation_matrices(np.array([attitude]))[0]
    return np.asarray(np.array(position) + np.array(attachments) @ turn.T)


class Space:
    """Everything that there is to see from all sides."""

    def __init__(self, server: viser.ViserServer, stage: Stage) -> None:
        """Builds the scene.

        Args:
            server: that shows it.
            stage: shapes and fence.
        """
        self._stage, self._scene = stage, server.scene
        self._drawn = 0
        scene = server.scene
        low, high = np.array(stage.fence_low), np.array(stage.fence_high)
        wide = float(max(high - low))
        scene.world_axes.visible = False
        scene.add_frame("/origin", axes_length=0.5, axes_radius=0.012)
        for name, place in (("x east", (0.55, 0, 0)), ("y north", (0, 0.55, 0)),
                            ("z up", (0, 0, 0.55))):  # fmt: skip
            scene.add_label(f"/origin/{name}", name, position=place, font_screen_scale=0.8)
        scene.add_grid(
            "/floor", infinite_grid=True, cell_color=(52, 57, 65), section_color=(78, 85, 96),
            plane_color=(27, 30, 35), plane_opacity=1.0, fade_distance=3.0 * wide,
            position=(0.0, 0.0, -0.002),
        )  # fmt: skip
        self._fence = scene.add_line_segments(
            "/fence",
            edges(stage.fence_low, stage.fence_high),
            np.array(_FENCE),
            thickness=1.5,
            thickness_units="screen",
        )
        scene.add_label("/fence/name", "fence", position=(low[0], low[1], high[2]),
                        font_screen_scale=0.8)  # fmt: skip
        self._no_data = scene.add_label(
            "/no data", "NO DATA: all this is of the past", visible=False, font_screen_scale=2.0,
            position=tuple(0.5 * (low + high)), anchor="center-center",
        )  # fmt: skip
        self._vehicles = [self._craft(k) for k in range(len(stage.rotors))]
        self._load = scene.add_frame("/load", show_axes=False)
        self._add_load("/load")
        self._load_target = scene.add_icosphere(
            "/load target", 0.05, _LOAD, opacity=0.45, cast_shadow=False, visible=False
        )
        middle = 0.5 * (low + high)
        server.initial_camera.up = (0.0, 0.0, 1.0)
        server.initial_camera.look_at = (float(middle[0]), float(middle[1]), 0.3 * float(high[2]))
        server.initial_camera.position = (
            float(middle[0]) - 0.2 * wide, float(middle[1]) - 0.62 * wide,
            float(high[2]) * 0.3 + 0.3 * wide,
        )  # fmt: skip

    def draw(self, shown: Snapshot, kept: History, *, stale: bool) -> None:
        """Moves everything to where a snapshot has it.

        Args:
            shown: the snapshot.
            kept: for trails.
            stale: whether it is of the past.
        """
        load = shown.payload
        self._fence.colors = np.array(_STALE if stale else _FENCE, dtype=np.uint8)
        self._no_data.visible = stale
        self._load.position, self._load.wxyz = load.position, load.attitude
        self._load_target.visible = load.target is not None
        if load.target is not None:
            self._load_target.position = load.target
        ends = feet(load.position, load.attitude, self._stage.attachments)
        for k, (v, craft) in enumerate(zip(shown.vehicles, self._vehicles, strict=True)):
            craft.position, craft.wxyz = v.position, v.attitude
            slack = v.swing is None or not v.tension
            usual = self._stage.pulls[k]
            colour = (rgb(SLACK) if slack else
                      tension_colours(np.array(v.tension), 0.5 * usual, 1.5 * usual))  # fmt: skip
            self._scene.add_line_segments(
                f"/cable {k + 1}", np.array([[ends[k], v.position]]), np.array(colour, np.uint8),
                thickness=1.5 if slack else 4.0, thickness_units="screen",
            )  # fmt: skip
        self._drawn += 1
        if self._drawn % _TRAILS == 0:
            self._draw_trails(kept)

    def _draw_trails(self, kept: History) -> None:
        trails = [kept.trail(lambda s, k=k: s.vehicles[k].position)  # type: ignore[misc]
                  for k in range(len(self._vehicles))]  # fmt: skip
        colours = [rgb(vehicle_colour(k)) for k in range(len(trails))]
        trails.append(kept.trail(lambda s: s.payload.position))
        colours.append(_LOAD)
        for k, (trail, colour) in enumerate(zip(trails, colours, strict=True)):
            if len(trail):
                self._scene.add_line_segments(
                    f"/trail {k + 1}", trail, colour, thickness=1.5, thickness_units="screen"
                )

    def _craft(self, k: int) -> viser.FrameHandle:
        scene, rotors = self._scene, self._stage.rotors[k]
        name, colour, disc = f"/vehicle {k + 1}", rgb(vehicle_colour(k)), self._stage.discs[k]
        frame = scene.add_frame(name, show_axes=False)
        for j, place in enumerate(rotors):
            scene.add_cylinder(f"{name}/rotor {j + 1}", disc, 0.012, colour, opacity=0.85,
                               position=(place[0], place[1], 0.03))  # fmt: skip
        arms = np.array([[[0.0, 0.0, 0.0], place] for place in rotors])
        scene.add_line_segments(f"{name}/arms", arms, (225, 228, 232), thickness=0.02)
        scene.add_box(f"{name}/body", (225, 228, 232), (0.09, 0.06, 0.05))
        # Forward, so that a heading can be seen.
        scene.add_box(f"{name}/nose", (255, 210, 60), (0.05, 0.02, 0.02), position=(0.06, 0.0, 0.0))
        scene.add_label(f"{name}/name", f"{k + 1}", position=(0.0, 0.0, 0.12))
        return frame

    def _add_load(self, name: str) -> None:
        stage, scene = self._stage, self._scene
        points = np.array(stage.points)
        if stage.body == "bar":
            along = points[1] - points[0]
            length = float(np.linalg.norm(along))
            scene.add_cylinder(
                f"{name}/bar", stage.radius, length, _LOAD, position=points.mean(axis=0),
                wxyz=_upright(along / length),
            )  # fmt: skip
        elif stage.body == "plate":
            vertices, faces = plate(points, stage.radius)
            scene.add_mesh_simple(f"{name}/plate", vertices, faces, color=_LOAD,
                                  flat_shading=True, side="double")  # fmt: skip
        else:
            scene.add_icosphere(f"{name}/ball", stage.radius, _LOAD)


def plate(outline: Array, half: float) -> tuple[Array, NDArray[np.uint32]]:
    """Vertices and triangles of an outline with a thickness.

    Args:
        outline: corners of a convex outline in order, shape (k, 3), m.
        half: of the thickness, m.
    """
    n = len(outline)
    up = np.array([0.0, 0.0, half])
    vertices = np.concatenate([outline + up, outline - up])
    faces = [(0, j, j + 1) for j in range(1, n - 1)]
    faces += [(n, n + j + 1, n + j) for j in range(1, n - 1)]
    for j in range(n):
        after = (j + 1) % n
        faces += [(j, n + j, after), (after, n + j, n + after)]
    return vertices, np.array(faces, dtype=np.uint32)


def _upright(direction: Array) -> Quaternion:
    """What turns z into a direction; a unit vector."""
    x, y, z = direction.tolist()
    if z < -1.0 + 1e-9:
        return (0.0, 1.0, 0.0, 0.0)
    q = np.array([1.0 + z, -y, x, 0.0])
    w, i, j, k = (q / np.linalg.norm(q)).tolist()
    return (w, i, j, k)
