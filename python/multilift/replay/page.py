"""A run as one page that turns, plays and needs nothing but itself."""

from __future__ import annotations

import html
import math
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.packed import encoded, resource, safe_json, script, stride_of, thinned
from multilift.replay import colours
from multilift.replay.scene import SLACK_PART, Cable, Craft, Scene

_HERE = "multilift.replay"
_SCRIPTS = ("track.js", "camera.js", "drawing.js", "picture.js", "plots.js", "replay.js")


def render(scene: Scene, *, max_points: int = 1500) -> str:
    """Makes the page.

    Args:
        scene: what to show.
        max_points: about how many records are drawn; straight lines between.

    Returns:
        A complete HTML document that loads nothing. The same scene gives the same text.
    """
    grid = _grid(scene)
    sources = [resource("multilift", "packed.js"), *(resource(_HERE, name) for name in _SCRIPTS)]
    floor = "on the floor" if scene.floor is not None else f"at z = {grid['height']:g} m"
    texts = {name: html.escape(getattr(scene, name)) for name in ("title", "law", "ending")}
    return Template(resource(_HERE, "page.html")).substitute(
        **texts,
        thrust=f"{scene.usual_thrust:.1f}",
        grid=f"{grid['step']:g}",
        grid_height=floor,
        symbols="payload" if scene.payload.kind == "point" else "payload's thickness",
        style=resource(_HERE, "replay.css"),
        scripts="\n".join(f"<script>\n{script(text)}</script>" for text in sources),
        data=safe_json(_data(scene, grid, max_points)),
    )


def _data(scene: Scene, grid: dict[str, Any], max_points: int) -> dict[str, Any]:
    strongest = max((float(np.linalg.norm(p.force, axis=1).max()) for p in scene.pushes), default=0)
    box = scene.box + np.array([[-1.0], [1.0]]) * 0.3 * scene.arrow_length
    box[1, 2] += 0.85 * scene.arrow_length  # thrust arrows
    if scene.floor is not None:
        box[0, 2] = max(box[0, 2], scene.floor)
    flat = box[1] - box[0]
    return {
        "view": "end" if flat[0] < 0.6 * scene.arrow_length + 1e-9 else "corner",
        "box": _rounded(box),
        "grid": grid,
        "floor": scene.floor,
        "ramp": colours.ramp(),
        "slackColour": colours.SLACK,
        "tension": [float(f"{x:.6g}") for x in scene.usual_tension],
        "slack": float(f"{SLACK_PART * scene.usual_tension[1]:.3g}"),
        "thrustScale": scene.arrow_length / scene.usual_thrust,
        "pushScale": 1.2 * scene.arrow_length / (strongest or 1.0),
        "payload": {
            "kind": scene.payload.kind,
            "points": _rounded(scene.payload.points),
            "radius": scene.payload.radius,
        },
        "vehicles": [
            {
                "rotors": _rounded(v.rotors),
                "radius": v.radius,
                "lost": _time(v.lost),
                "colour": colours.vehicle_colour(k),
            }
            for k, v in enumerate(scene.vehicles)
        ],
        "cables": [{"length": c.length, "cut": _time(c.cut)} for c in scene.cables],
        "pushes": [
            {"index": k, "body": p.body, "start": p.start, "duration": p.duration}
            for k, p in enumerate(scene.pushes)
        ],
        "events": [{"time": e.time, "kind": e.kind, "text": e.text} for e in scene.events],
        "columns": _columns(scene, max_points),
    }


def _columns(scene: Scene, max_points: int) -> dict[str, Any]:
    """All that changes over time, packed, in a tree that track.js reads."""
    stride = stride_of(len(scene.t), max_points)

    def one(column: NDArray[np.float64]) -> dict[str, Any]:
        return encoded(thinned(np.ascontiguousarray(column), stride), diverged=False)

    def several(columns: NDArray[np.float64]) -> list[dict[str, Any]]:
        return [one(column) for column in columns.T]

    def vehicle(v: Craft) -> dict[str, Any]:
        return {
            "position": several(v.position),
            "attitude": None if v.attitude is None else several(v.attitude),
            "target": several(v.target),
            "thrust": several(v.thrust),
        }

    def cable(c: Cable) -> dict[str, Any]:
        return {"foot": several(c.foot), "tension": one(c.tension), "swing": one(c.swing)}

    return {
        "t": one(scene.t),
        "payload": several(scene.payload_position),
        "attitude": several(scene.payload_attitude),
        "target": several(scene.payload_target),
        "yaw": one(scene.payload_yaw),
        "error": one(scene.payload_error),
        "vehicles": [vehicle(v) for v in scene.vehicles],
        "cables": [cable(c) for c in scene.cables],
        "pushes": [several(p.force) for p in scene.pushes],
    }


def _grid(scene: Scene) -> dict[str, Any]:
    """The grid under the scene: about ten squares of 1, 2 or 5 times a power of ten, m."""
    low, high = scene.box[:, :2] + np.array([[-1.0], [1.0]]) * scene.arrow_length
    wanted = float((high - low).max()) / 10.0
    power = 10.0 ** math.floor(math.log10(wanted))
    step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= wanted * 0.8)
    corners = [np.floor(low / step) * step, np.ceil(high / step) * step]
    return {
        "height": scene.resting_height(),
        "step": step,
        "corners": _rounded(np.array(corners)),
        "solid": scene.floor is not None,
    }


def _rounded(array: NDArray[np.float64]) -> list[Any]:
    return np.round(array, 6).tolist()  # type: ignore[no-any-return]


def _time(x: float) -> float:
    """A time for JSON, which has no infinity."""
    return x if math.isfinite(x) else 1e9
