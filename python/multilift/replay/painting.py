"""One picture of a scene for animations, with Pillow: what page and recording show, smaller."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from multilift.replay import cables, colours
from multilift.replay.camera import Camera
from multilift.replay.scene import Scene

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw as Canvas

Array = NDArray[np.float64]
Ink = str | tuple[int, int, int]

_WIDTH, _PICTURE, _STRIP = 480, 350, 80  # px
_SHARP = 2  # times finer than it is shown
_INK, _MUTED, _LINE, _FLOOR = "#1c2126", "#66707a", "#d5dbe0", "#eef1f3"
_BODY, _SIDE, _UNDER = "#c9b896", "#ad9c75", "#96875f"
_THRUST, _ALARM, _BAND, _SHADOW = "#0a8f5b", "#c92a2a", "#dff1ea", "#d8dde1"
_DISC = np.column_stack([f(np.linspace(0, 2 * np.pi, 21)) for f in (np.cos, np.sin)])
_TRAIL = 3.0  # s

#: Every colour that a picture is made of, but for what its smooth edges mix from them.
PLAIN = (_INK, _MUTED, _LINE, _FLOOR, _BODY, _SIDE, _UNDER, _THRUST, _ALARM, _BAND, _SHADOW,
         colours.SLACK, *colours.VEHICLES, *colours.ramp(20))  # fmt: skip


class Painter:
    """Draws a scene's rows; a run shown `faster` than it was says so."""

    def __init__(self, scene: Scene, faster: float) -> None:
        from PIL import ImageFont  # noqa: PLC0415

        self.scene, self.faster = scene, faster
        self.width, self.height = _SHARP * _WIDTH, _SHARP * _PICTURE
        box = scene.box + np.array([[-1.0], [1.0]]) * 0.3 * scene.arrow_length
        box[1, 2] += 0.85 * scene.arrow_length
        if scene.floor is not None:
            box[0, 2] = max(box[0, 2], scene.floor)  # targets may lie below it
        flat = box[1, 0] - box[0, 0] < 0.6 * scene.arrow_length + 1e-9
        yaw, pitch = (0.0, 0.06) if flat else (-1.05, 0.32)
        self.camera = Camera(box, yaw, pitch, self.width, self.height)
        self.font = ImageFont.load_default(13 * _SHARP)
        self.small = ImageFont.load_default(11 * _SHARP)

    def draw(self, row: int) -> Image:
        """One picture."""
        from PIL import Image as Images  # noqa: PLC0415
        from PIL import ImageDraw  # noqa: PLC0415

        image = Images.new("RGB", (self.width, self.height + _SHARP * _STRIP), "white")
        self.on: Canvas = ImageDraw.Draw(image)
        self.items: list[tuple[float, tuple[Array, Ink, float, Ink | None]]] = []
        self._floor(row)
        self._trails(row)
        self._payload(row)
        for k in range(len(self.scene.vehicles)):
            self._vehicle(k, row)
            self._cable(k, row)
        for _, (points, ink, width, fill) in sorted(self.items, key=lambda item: -item[0]):
            self._put(points, ink, width, fill)
        self._pushes(row)
        self._texts(row)
        self._strip(row)
        return image.resize((_WIDTH, _PICTURE + _STRIP), Images.Resampling.LANCZOS)

    def _put(self, points: Array, ink: Ink, width: float, fill: Ink | None = None) -> None:
        """A line through places, or a face where there is something to fill it with."""
        flat = [(float(x), float(y)) for x, y, _ in self.camera.project(points)]
        if fill is not None:
            self.on.polygon(flat, fill=fill)
        if width > 0:
            self.on.line(flat, fill=ink, width=max(1, round(width * _SHARP)), joint="curve")

    def _later(self, points: Array, ink: Ink, width: float, fill: Ink | None = None) -> None:
        depth = float(self.camera.project(points.mean(axis=0)[None])[0, 2])
        self.items.append((depth, (points, ink, width, fill)))

    def _floor(self, row: int) -> None:
        scene, z = self.scene, self.scene.resting_height()
        low, high = scene.box[:, :2] + np.array([[-1.0], [1.0]]) * 0.5 * scene.arrow_length
        step = 0.5 if float((high - low).max()) < 6.0 else 1.0
        low, high = np.floor(low / step) * step, np.ceil(high / step) * step
        if scene.floor is not None:
            corners = [[low[0], low[1], z], [high[0], low[1], z], [high[0], high[1], z],
                       [low[0], high[1], z]]  # fmt: skip
            self._put(np.array(corners), _LINE, 0, _FLOOR)
        for x in np.arange(low[0], high[0] + 1e-9, step):
            self._put(np.array([[x, low[1], z], [x, high[1], z]]), _LINE, 0.7)
        for y in np.arange(low[1], high[1] + 1e-9, step):
            self._put(np.array([[low[0], y, z], [high[0], y, z]]), _LINE, 0.7)
        for vehicle in scene.vehicles:
            disc = 1.6 * vehicle.radius * _DISC + vehicle.position[row, :2]
            self._put(np.column_stack([disc, np.full(len(disc), z)]), _LINE, 0, _SHADOW)
        shadow = self._payload_points(row).copy()
        shadow[:, 2] = z
        self._put(shadow, _SHADOW, 2, _SHADOW if len(shadow) > 2 else None)

    def _payload_points(self, row: int) -> Array:
        attitude = self.scene.payload_attitude[row]
        return np.asarray(
            self.scene.payload_position[row] + turned(attitude, self.scene.payload.points)
        )

    def _trails(self, row: int) -> None:
        scene = self.scene
        first = int(np.searchsorted(scene.t, scene.t[row] - _TRAIL * self.faster**0.5))
        for k, vehicle in enumerate(scene.vehicles):
            if row - first > 1:
                self._put(vehicle.position[first : row + 1 : 5], _pale(k), 1)
        if row > 1:
            self._put(scene.payload_position[: row + 1 : 5], _MUTED, 1)
        if row - first > 1:
            self._put(scene.payload_position[first : row + 1 : 3], _INK, 1.6)

    def _payload(self, row: int) -> None:
        body, points = self.scene.payload, self._payload_points(row)
        if body.kind == "bar":
            for part in np.linspace(0, 1, 7)[:-1]:
                piece = points[0] + np.array([[part], [part + 1 / 6]]) * (points[1] - points[0])
                self._later(piece, _INK, 5)
            self.items += [(depth - 1e-3, (piece, _BODY, 2.6, None))
                           for depth, (piece, _, _, _) in self.items]  # fmt: skip
        elif body.kind == "point":
            self._ball(points[0], body.radius, _BODY)
        else:
            up = turned(self.scene.payload_attitude[row], np.array([[0, 0, body.radius]]))[0]
            self._plate(points + up, points - up)

    def _plate(self, top: Array, bottom: Array) -> None:
        """Its faces towards the eye, as if at its middle."""
        middle = 0.5 * (top.mean(axis=0) + bottom.mean(axis=0))
        depth = float(self.camera.project(middle[None])[0, 2])
        after = np.roll(np.arange(len(top)), -1)
        faces = [(top, _BODY), (bottom, _UNDER)]
        faces += [(np.array([top[k], top[j], bottom[j], bottom[k]]), _SIDE)
                  for k, j in enumerate(after)]  # fmt: skip
        for face, fill in faces:
            normal = np.cross(face[1] - face[0], face[2] - face[1])
            normal = normal * (1.0 if normal @ (face[0] - middle) > 0 else -1.0)
            if normal @ (self.camera.eye - face[0]) > 0:
                self.items.append((depth, (np.vstack([face, face[:1]]), _INK, 0.8, fill)))

    def _ball(self, place: Array, radius: float, fill: Ink) -> None:
        disc = radius * _DISC
        self._later(place + disc[:, :1] * self.camera.right + disc[:, 1:] * self.camera.up,
                    _INK, 0.8, fill)  # fmt: skip

    def _vehicle(self, k: int, row: int) -> None:
        scene, vehicle = self.scene, self.scene.vehicles[k]
        place, ink = vehicle.position[row], colours.vehicle_colour(k)
        lost = scene.t[row] >= vehicle.lost
        r = vehicle.radius
        if vehicle.attitude is not None:
            for rotor in vehicle.rotors:
                hub, lift = turned(vehicle.attitude[row], np.array([rotor, [0, 0, 0.25 * r]]))
                self._later(np.array([place, place + hub]), _INK, 1.6)
                disc = np.column_stack([r * _DISC, np.zeros(len(_DISC))])
                self._later(place + hub + lift + turned(vehicle.attitude[row], disc),
                            _ALARM if lost else ink, 1, None if lost else _pale(k))  # fmt: skip
        self._ball(place, 0.42 * r if len(vehicle.rotors) else r, ink)
        if not lost:
            self._arrow(place, scene.arrow_length / scene.usual_thrust * vehicle.thrust[row],
                        _THRUST)  # fmt: skip

    def _arrow(self, tail: Array, along: Array, ink: Ink) -> None:
        if np.linalg.norm(along) < 1e-6:
            return
        tip = tail + along
        self._later(np.array([tail, tip - 0.12 * along]), ink, 1.8)
        side = np.cross(along, self.camera.ahead)
        side *= 0.05 * self.scene.arrow_length / max(float(np.linalg.norm(side)), 1e-9)
        head = tip - along * min(1.0, 0.17 * self.scene.arrow_length / float(np.linalg.norm(along)))
        self._later(np.array([tip, head + side, head - side, tip]), ink, 0, ink)

    def _cable(self, k: int, row: int) -> None:
        scene, cable = self.scene, self.scene.cables[k]
        foot, top = cable.foot[row], scene.vehicles[k].position[row]
        loose = bool(scene.slack(k)[row])
        if scene.t[row] >= cable.cut:
            points = cables.hanging(top, cable.length, scene.floor)
        else:
            points = cables.sagging(foot, top, cable.length if loose else 0.0, 16 if loose else 6)
        if scene.floor is not None:
            points[:, 2] = np.maximum(points[:, 2], scene.floor)
        ink: Ink = colours.SLACK
        if not loose:
            red, green, blue = colours.tension_colours(cable.tension[row], *scene.usual_tension)
            ink = (int(red), int(green), int(blue))
        for piece in pairwise(points):
            self._later(np.array(piece), ink, 1.4 if loose else 3)

    def _pushes(self, row: int) -> None:
        self.items = []
        strongest = max((float(np.linalg.norm(p.force, axis=1).max()) for p in self.scene.pushes),
                        default=0.0)  # fmt: skip
        for push in self.scene.pushes:
            force = push.force[row]
            size = float(np.linalg.norm(force))
            if size > 0:
                bodies = [self._payload_points(row)] + [
                    v.position[row : row + 1] for v in self.scene.vehicles
                ]
                points = bodies[push.body + 1]
                tip = points[np.argmin(points @ force)]
                along = 1.2 * self.scene.arrow_length / strongest * force
                self._arrow(tip - along, along, _ALARM)
        for _, (points, ink, width, fill) in self.items:
            self._put(points, ink, 1.6 * width, fill)

    def _texts(self, row: int) -> None:
        scene, s = self.scene, _SHARP
        self.on.text((10 * s, 8 * s), scene.title, fill=_INK, font=self.font)
        speed = "" if self.faster < 1.05 else f", {self.faster:.1f} times as fast"
        clock = f"{scene.t[row]:.1f} s{speed}"
        self.on.text((self.width - 10 * s, 8 * s), clock, fill=_MUTED, font=self.font, anchor="ra")
        shown = [e for e in scene.events if e.time <= scene.t[row]
                 and (e.kind != "push" or scene.t[row] - e.time < 1.5)]  # fmt: skip
        for k, event in enumerate(shown):
            self.on.text((10 * s, (26 + 16 * k) * s), event.text, fill=_ALARM, font=self.small)
        for k, vehicle in enumerate(scene.vehicles):
            x, y, _ = self.camera.project(vehicle.position[row : row + 1])[0]
            self.on.text((x + 9 * s, y - 9 * s), str(k + 1), fill=_INK, font=self.small,
                         anchor="mm", stroke_width=s, stroke_fill="white")  # fmt: skip
        low, high = scene.usual_tension
        left, top, wide = self.width - 168 * s, self.height - 20 * s, 60 * s
        for x, colour in enumerate(colours.ramp(wide)):
            self.on.line([(left + x, top), (left + x, top + 7 * s)], fill=colour)
        self.on.text((left - 5 * s, top + 3 * s), f"tension {low:.1f}", fill=_MUTED,
                     font=self.small, anchor="rm")  # fmt: skip
        self.on.text((left + wide + 5 * s, top + 3 * s), f"{high:.1f} N, grey: slack",
                     fill=_MUTED, font=self.small, anchor="lm")  # fmt: skip

    def _strip(self, row: int) -> None:
        """Swing of the cables up to now, deg, over the whole time."""
        scene, s = self.scene, _SHARP
        left, right = 34 * s, self.width - 10 * s
        self.on.rectangle([0, self.height, self.width, self.height + _STRIP * s], fill="white")
        top, bottom = self.height + 14 * s, self.height + (_STRIP - 8) * s
        swing = np.degrees(np.array([cable.swing for cable in scene.cables]))
        finite = swing[np.isfinite(swing)]
        most = max(float(np.quantile(finite, 0.998)) if finite.size else 0.0, 1.5)
        x = left + (scene.t - scene.t[0]) / max(float(np.ptp(scene.t)), 1e-9) * (right - left)

        def y(value: Array) -> Array:
            return bottom - np.minimum(value / most, 1.05) * (bottom - top)

        self.on.rectangle([left, float(y(np.array(1.0))), right, bottom], fill=_BAND)
        self.on.line([(left, bottom), (right, bottom)], fill=_LINE, width=s)
        text = "swing of the cables in deg; band: below 1"
        self.on.text((left, self.height), text, fill=_MUTED, font=self.small)
        tick = 10.0 ** math.floor(math.log10(most))
        tick *= max(m for m in (1, 2, 5) if m * tick <= most)
        at = float(y(np.array(tick)))
        self.on.text((left - 4 * s, at), f"{tick:g}", fill=_MUTED, font=self.small, anchor="rm")
        self.on.text((left - 4 * s, bottom), "0", fill=_MUTED, font=self.small, anchor="rm")
        stride = max(1, len(x) // 400)
        for k, values in enumerate(swing):
            taken = slice(0, row + 1, stride)
            for part in _runs(np.isfinite(values[taken])):
                line = np.column_stack([x[taken][part], y(values[taken][part])])
                if len(line) > 1:
                    self.on.line([(float(a), float(b)) for a, b in line],
                                 fill=colours.vehicle_colour(k), width=s)  # fmt: skip
        self.on.line([(float(x[row]), top - 4 * s), (float(x[row]), bottom)], fill=_INK, width=s)


def turned(attitude: Array, points: Array) -> Array:
    """A body's points in the world's axes; a unit quaternion, scalar first."""
    w, u = attitude[0], attitude[1:]
    t = 2.0 * np.cross(u, points)
    return np.asarray(points + w * t + np.cross(u, t))


def _pale(k: int) -> Ink:
    """A vehicle's colour mixed with white."""
    red, green, blue = (255 - (255 - c) // 3 for c in colours.rgb(colours.vehicle_colour(k)))
    return red, green, blue


def _runs(wanted: NDArray[np.bool_]) -> list[slice]:
    """The stretches in which something holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], wanted, [False]]).astype(int)))
    return [slice(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
