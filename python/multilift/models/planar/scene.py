"""What a planar run looks like in space: the plane x = 0, y to the right, z up."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from multilift.models.planar.run import PlanarRun
from multilift.pushes import heights
from multilift.replay.scene import Body, Cable, Craft, Event, Push, Scene

Array = NDArray[np.float64]

_BODIES = {"bar": -1, "vehicle_1": 0, "vehicle_2": 1}


def scene(run: PlanarRun) -> Scene:
    """The run as `multilift.replay` draws it; vehicles are symbols, for they have no size."""
    plant = run.scenario.values["plant"]
    l0, half = plant["bar_length"], plant["bar_half_thickness"]
    goal = run.scenario.goal_vector().reshape(2, 2)
    thrusts = run.thrust_attitude()
    arm = float(np.clip(0.13 * l0, 0.08, 0.3))
    angle = (np.arange(4) + 0.5) * 0.5 * np.pi
    rotors = arm * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(4)])
    vehicles, cables = [], []
    for k in (1, 2):
        length, theta = plant["cable_length"][k - 1], run[f"theta{k}"]
        place = _in_space(run[f"y{k}"], run[f"z{k}"])
        side = 1.0 if k == 1 else -1.0  # theta1 and theta2 count outwards
        foot = place + length * _in_space(side * np.sin(theta), -np.cos(theta))
        thrust, lean = thrusts[f"thrust{k}_applied"], thrusts[f"attitude{k}_applied"]
        cables.append(
            Cable(foot=foot, length=length, tension=run[f"tension{k}"], swing=np.abs(theta))
        )
        vehicles.append(
            Craft(
                name=f"vehicle {k}",
                position=place,
                attitude=_about_x(-lean),
                target=np.broadcast_to([0.0, *goal[k - 1]], place.shape),
                thrust=thrust[:, None] * _in_space(np.sin(lean), np.cos(lean)),
                rotors=rotors,
                radius=0.56 * arm,
            )
        )
    across = cables[1].foot - cables[0].foot
    below = goal.mean(axis=0) - [0.0, float(np.mean(plant["cable_length"])) + half]
    events = [
        Event(push["start"], "push", f"push of {np.linalg.norm(push['force']):.3g} N on "
              f"{push['body'].replace('_', ' ')}")
        for push in run.scenario["push"]
    ]  # fmt: skip
    if not run.finished:
        reason = run.scenario.model.reason(run.status, run.culprit)
        events.append(Event(run.end_time, "end", reason))
    return Scene(
        name=run.scenario.name,
        title=run.scenario.title,
        law=run.controller_title,
        ending=run.ending,
        t=run.t,
        payload=Body(
            kind="bar",
            points=np.array([[0.0, -0.5 * l0, 0.0], [0.0, 0.5 * l0, 0.0]]),
            radius=max(half, 0.01),
        ),
        payload_position=_in_space(run["bar_y"], run["bar_z"]),
        payload_attitude=_about_x(np.arctan2(across[:, 2], across[:, 1])),
        payload_target=np.broadcast_to([0.0, *below], (len(run.t), 3)),
        payload_yaw=np.zeros_like(run.t),
        vehicles=vehicles,
        cables=cables,
        pushes=[
            Push(
                body=_BODIES[push["body"]],
                force=heights(push, run.t)[:, None] * np.array([0.0, *push["force"]]),
                start=push["start"],
                duration=push["duration"],
            )
            for push in run.scenario["push"]
        ],
        events=sorted((e for e in events if e.time <= run.end_time), key=lambda e: e.time),
    )


def _in_space(y: Array, z: Array) -> Array:
    return np.stack([np.zeros_like(y), y, z], axis=1)


def _about_x(angle: Array) -> Array:
    zero = np.zeros_like(angle)
    return np.stack([np.cos(angle / 2), np.sin(angle / 2), zero, zero], axis=1)
