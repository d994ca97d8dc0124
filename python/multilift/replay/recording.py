"""A run as a Rerun recording: the same scene, to turn, scrub and take apart in Rerun's viewer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import MissingExtraError, OutputError
from multilift.replay import cables, colours
from multilift.replay.scene import Cable, Craft, Scene

Array = NDArray[np.float64]

TIMELINE = "time"
_ROWS = 1500  # about how many records are shown
_THRUST, _ALARM, _BODY, _INK = (10, 143, 91), (201, 42, 42), (201, 184, 150), (120, 128, 136)


def need_rerun() -> Any:
    """Rerun's package.

    Raises:
        MissingExtraError: without it (``multilift[view]``).
    """
    try:
        import rerun  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError(
            "rerun-sdk", "view", "a Rerun recording (unlike a page, --page FILE.html)"
        ) from None
    return rerun


def write(scene: Scene, file: Path | None) -> None:
    """Writes a recording, or opens Rerun's viewer with it.

    Args:
        scene: what to show.
        file: to write; None opens the viewer.

    Raises:
        MissingExtraError: without rerun-sdk (``multilift[view]``).
        OutputError: if the file cannot be written, or no viewer opens.
    """
    rr = need_rerun()
    recording = rr.RecordingStream("multilift", recording_id=scene.name)
    try:
        if file is None:
            recording.spawn()
        else:
            file.touch()  # Rerun itself only warns
            recording.save(str(file))
    except (OSError, RuntimeError) as error:
        what = "Rerun's viewer cannot be opened" if file is None else f"{file} cannot be written"
        raise OutputError(f"{what}: {error}") from error
    recording.send_blueprint(_blueprint(scene))
    _Log(rr, recording, scene).everything()
    recording.flush()
    recording.disconnect()


class _Log:
    def __init__(self, rr: Any, recording: Any, scene: Scene) -> None:
        self.rr, self.to, self.scene = rr, recording, scene
        self.rows = np.unique(np.linspace(0, len(scene.t) - 1, _ROWS).round().astype(int))
        self.times = scene.t[self.rows]

    def everything(self) -> None:
        """All of the scene."""
        rr, scene = self.rr, self.scene
        self.to.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        self.to.log("about", rr.TextDocument(_about(scene), media_type="text/markdown"),
                    static=True)  # fmt: skip
        self._floor()
        self._payload()
        for k, vehicle in enumerate(scene.vehicles):
            self._vehicle(k, vehicle)
            self._cable(k, scene.cables[k])
        self._curve("curves/error", "payload off its target, m", _INK, scene.payload_error)
        for k, push in enumerate(scene.pushes):
            place = scene.payload_position if push.body < 0 else scene.vehicles[push.body].position
            strongest = float(np.linalg.norm(push.force, axis=1).max()) or 1.0
            arrows = push.force[self.rows] * (1.2 * scene.arrow_length / strongest)
            self._arrows(f"world/push{k + 1}", place[self.rows] - arrows, arrows, _ALARM, 0.012)
        for event in scene.events:
            self.to.set_time(TIMELINE, duration=event.time)
            level = "INFO" if event.kind == "push" else "WARN"
            self.to.log("events", rr.TextLog(event.text, level=level))

    # Parts.

    def _columns(self, path: str, *columns: Any) -> None:
        index = self.rr.TimeColumn(TIMELINE, duration=self.times)
        every = [part for column in columns for part in column]
        self.to.send_columns(path, indexes=[index], columns=every)

    def _pose(self, path: str, place: Array, attitude: Array | None) -> None:
        more = {}
        if attitude is not None:
            more["quaternion"] = np.roll(attitude[self.rows], -1, axis=1)  # Rerun's scalar is last
        self._columns(path, self.rr.Transform3D.columns(translation=place[self.rows], **more))

    def _curve(self, path: str, name: str, colour: tuple[int, int, int], values: Array) -> None:
        rr = self.rr
        self.to.log(path, rr.SeriesLines(colors=[colour], names=[name]), static=True)
        self._columns(path, rr.Scalars.columns(scalars=values[self.rows]))

    def _arrows(
        self, path: str, origins: Array, vectors: Array, colour: tuple[int, int, int], radius: float
    ) -> None:
        rr = self.rr
        self.to.log(path, rr.Arrows3D.from_fields(colors=[colour], radii=[radius]), static=True)
        self._columns(path, rr.Arrows3D.columns(origins=origins, vectors=vectors))

    def _path(self, path: str, places: Array, colour: tuple[int, int, int]) -> None:
        """A whole path, always seen; what is past and what is to come alike."""
        strip = self.rr.LineStrips3D([places[self.rows]], colors=[(*colour, 130)], radii=[0.003])
        self.to.log(path, strip, static=True)

    def _floor(self) -> None:
        scene = self.scene
        if scene.floor is None:
            return
        middle, half = scene.box.mean(axis=0), 0.5 * np.ptp(scene.box, axis=0) + 1.0
        box = self.rr.Boxes3D(
            centers=[[middle[0], middle[1], scene.floor - 0.005]],
            half_sizes=[[half[0], half[1], 0.005]],
            colors=[(200, 205, 210)],
            fill_mode="solid",
        )
        self.to.log("world/floor", box, static=True)

    def _payload(self) -> None:
        scene, rr, body = self.scene, self.rr, self.scene.payload
        self._pose("world/payload", scene.payload_position, scene.payload_attitude)
        self._path("world/paths/payload", scene.payload_position, _INK)
        yaw = 0.5 * scene.payload_yaw
        zero = np.zeros_like(yaw)
        level = np.stack([np.cos(yaw), zero, zero, np.sin(yaw)], axis=1)
        self._pose("world/target", scene.payload_target, level)
        if body.kind == "point":
            self.to.log("world/payload", rr.Points3D([body.points[0]], radii=[body.radius],
                        colors=[_BODY]), static=True)  # fmt: skip
            self.to.log("world/target", rr.Points3D([body.points[0]], radii=[0.4 * body.radius],
                        colors=[_INK]), static=True)  # fmt: skip
            return
        outline = body.points if body.kind == "bar" else np.vstack([body.points, body.points[:1]])
        ghost = rr.LineStrips3D([outline], colors=[_INK], radii=[0.004])
        self.to.log("world/target", ghost, static=True)
        if body.kind == "bar":
            bar = rr.LineStrips3D([body.points], colors=[_BODY], radii=[body.radius])
            self.to.log("world/payload", bar, static=True)
        else:
            self.to.log("world/payload", self._plate(), static=True)

    def _plate(self) -> Any:
        """A prism over the outline; each face has corners of its own, so that edges are sharp."""
        points, half = self.scene.payload.points, np.array([0.0, 0.0, self.scene.payload.radius])
        count = len(points)
        faces = [points + half, (points - half)[::-1]]
        for k in range(count):
            a, b = points[k], points[(k + 1) % count]
            faces.append(np.array([b + half, a + half, a - half, b - half]))
        corners: list[Array] = []
        triangles, normals = [], []
        for face in faces:
            first = sum(map(len, corners))
            triangles += [[first, first + k, first + k + 1] for k in range(1, len(face) - 1)]
            normal = np.cross(face[1] - face[0], face[2] - face[1])
            normals += [normal / np.linalg.norm(normal)] * len(face)
            corners.append(face)
        return self.rr.Mesh3D(
            vertex_positions=np.vstack(corners),
            triangle_indices=triangles,
            vertex_normals=normals,
            albedo_factor=_BODY,
        )

    def _vehicle(self, k: int, vehicle: Craft) -> None:
        rr, scene = self.rr, self.scene
        path, colour = f"world/vehicle{k + 1}", colours.rgb(colours.vehicle_colour(k))
        self._pose(path, vehicle.position, vehicle.attitude)
        self._path(f"world/paths/vehicle{k + 1}", vehicle.position, colour)
        hub = 0.42 * vehicle.radius if len(vehicle.rotors) else vehicle.radius
        self.to.log(path, rr.Points3D([[0, 0, 0]], radii=[hub], colors=[colour],
                    labels=[str(k + 1)]), static=True)  # fmt: skip
        if len(vehicle.rotors):
            around = np.linspace(0.0, 2.0 * np.pi, 25)
            disc = vehicle.radius * np.column_stack([np.cos(around), np.sin(around), 0.0 * around])
            lift = np.array([0.0, 0.0, 0.25 * vehicle.radius])
            strips = [np.array([np.zeros(3), rotor]) for rotor in vehicle.rotors]
            strips += [rotor + lift + disc for rotor in vehicle.rotors]
            self.to.log(f"{path}/frame", rr.LineStrips3D(strips, colors=[colour], radii=[0.006]),
                        static=True)  # fmt: skip
        self._pose(f"world/target{k + 1}", vehicle.target, None)
        self.to.log(f"world/target{k + 1}", rr.Points3D([[0, 0, 0]], radii=[0.02], colors=[_INK]),
                    static=True)  # fmt: skip
        scale = scene.arrow_length / scene.usual_thrust
        self._arrows(f"world/thrust{k + 1}", vehicle.position[self.rows],
                     scale * vehicle.thrust[self.rows], _THRUST, 0.008)  # fmt: skip
        self._curve(f"curves/thrust/{k + 1}", f"thrust {k + 1}, N", colour,
                    np.linalg.norm(vehicle.thrust, axis=1))  # fmt: skip

    def _cable(self, k: int, cable: Cable) -> None:
        rr, scene = self.rr, self.scene
        top, loose = scene.vehicles[k].position, scene.slack(k)
        strips, inks = [], []
        shown = colours.tension_colours(cable.tension, *scene.usual_tension)
        for row in self.rows:
            if scene.t[row] >= cable.cut:
                strip = cables.hanging(top[row], cable.length, scene.floor)
            elif loose[row]:
                strip = cables.sagging(cable.foot[row], top[row], cable.length)
                if scene.floor is not None:
                    strip[:, 2] = np.maximum(strip[:, 2], scene.floor)
            else:
                strip = np.array([cable.foot[row], top[row]])
            strips.append(strip)
            inks.append(colours.rgb(colours.SLACK) if loose[row] else tuple(shown[row]))
        path = f"world/cable{k + 1}"
        self.to.log(path, rr.LineStrips3D.from_fields(radii=[0.012]), static=True)
        self._columns(path, rr.LineStrips3D.columns(strips=strips, colors=np.array(inks)))
        colour = colours.rgb(colours.vehicle_colour(k))
        self._curve(f"curves/swing/{k + 1}", f"swing {k + 1}, deg", colour,
                    np.degrees(cable.swing))  # fmt: skip
        self._curve(f"curves/tension/{k + 1}", f"tension {k + 1}, N", colour, cable.tension)


def _about(scene: Scene) -> str:
    low, high = scene.usual_tension
    return (
        f"**{scene.title}**\n\n{scene.law}; {scene.ending}.\n\n"
        f"Cables: from blue, {low:.2f} N, over purple to amber, {high:.2f} N; grey where slack. "
        f"Green arrows: thrust, at most {scene.usual_thrust:.1f} N. Red: pushes. World z up, m."
    )


def _blueprint(scene: Scene) -> Any:
    import rerun.blueprint as rrb  # noqa: PLC0415

    curves = [  # vehicles bear the curves' colours; a legend would cover half of a curve
        rrb.TimeSeriesView(
            origin=f"curves/{name}", name=title, plot_legend=rrb.PlotLegend(visible=False)
        )
        for name, title in (
            ("swing", "swing of the cables, deg"),
            ("tension", "tensions, N"),
            ("thrust", "thrusts, N"),
            ("error", "payload off its target, m"),
        )
    ]
    words: list[rrb.View] = [rrb.TextDocumentView(origin="about", name="about")]
    if scene.events:
        words.append(rrb.TextLogView(origin="events", name="events"))
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                rrb.Spatial3DView(origin="world", name=scene.title),
                rrb.Horizontal(*words),
                row_shares=[4, 1],
            ),
            rrb.Vertical(*curves),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(state="expanded", timeline=TIMELINE),
        collapse_panels=True,
    )
