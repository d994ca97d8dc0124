"""What a spatial run looks like."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from multilift.models.spatial.rows import body_index
from multilift.models.spatial.run import SpatialRun
from multilift.pushes import heights
from multilift.replay.scene import SLACK_PART, Cable, Craft, Event, Push, Scene, payload_body

Array = NDArray[np.float64]

#: A rotor disc's radius per arm: what an X frame has room for, less a little.
_DISC = 0.56


def scene(run: SpatialRun) -> Scene:
    """The run as `multilift.replay` draws it."""
    values = run.scenario.values
    plant = values["plant"]
    attachments = np.array(plant["attachment"])
    body = payload_body(plant["payload_mass"], np.array(plant["payload_inertia"]), attachments)
    return Scene(
        name=run.scenario.name,
        title=run.scenario.title,
        law=run.controller_title,
        ending=run.ending,
        t=run.t,
        payload=body,
        payload_position=run.vector("payload"),
        payload_attitude=run.attitude("payload"),
        payload_target=run.vector("target"),
        payload_yaw=run["target_yaw"],
        vehicles=_vehicles(run, _since(run, "vehicle_lost")),
        cables=_cables(run, _since(run, "cable_cut")),
        pushes=_pushes(run),
        events=events(run),
        floor=values["ground"]["height"] if values["ground"]["present"] else None,
    )


def shown_swing(run: SpatialRun) -> Array:
    """Swing of cables that pull on a flying vehicle, else NaN, shape (rows, n), rad."""
    tension = np.stack([run[f"tension{k + 1}"] for k in range(run.scenario.count)], axis=1)
    given_up = np.minimum(_since(run, "cable_cut"), _since(run, "vehicle_lost"))
    loose = tension <= SLACK_PART * np.maximum(np.nanmax(tension, axis=0), 1e-300)
    return np.where(loose | (run.t[:, None] >= given_up), np.nan, run.swing())


def _since(run: SpatialRun, kind: str) -> Array:
    """From when on what broke by a kind of event is broken, for every vehicle; infinity: never."""
    times = np.full(run.scenario.count, np.inf)
    for event in run.scenario["event"]:
        if event["kind"] == kind:
            who = body_index(event["vehicle"])
            times[who] = min(times[who], event["time"])
    return times


def _vehicles(run: SpatialRun, lost: Array) -> list[Craft]:
    vehicle = run.scenario.values["vehicle"]
    result = []
    for k in range(run.scenario.count):
        name = f"vehicle{k + 1}"
        rotors, radius = np.zeros((0, 3)), 0.06 * run.scenario["plant.cable_length"][k]
        if vehicle["kind"] == "quadrotor":
            angle = vehicle["frame_angle"][k] + 0.5 * np.pi * np.arange(4)
            arm = vehicle["arm_length"][k]
            rotors = arm * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(4)])
            radius = _DISC * arm
        result.append(
            Craft(
                name=f"vehicle {k + 1}",
                position=run.vector(name),
                attitude=run.attitude(name) if len(rotors) else None,
                target=run.vector(f"goal{k + 1}"),
                thrust=run.vector(f"thrust{k + 1}"),
                rotors=rotors,
                radius=radius,
                lost=float(lost[k]),
            )
        )
    return result


def _cables(run: SpatialRun, cut: Array) -> list[Cable]:
    feet, swing = run.attachments(), shown_swing(run)
    result = []
    for k in range(run.scenario.count):
        tension = run[f"tension{k + 1}"]
        result.append(
            Cable(
                foot=feet[:, k],
                length=run.scenario["plant.cable_length"][k],
                tension=np.where(run.t >= cut[k], 0.0, tension),
                swing=swing[:, k],
                cut=float(cut[k]),
            )
        )
    return result


def _pushes(run: SpatialRun) -> list[Push]:
    return [
        Push(
            body=body_index(push["body"]),
            force=heights(push, run.t)[:, None] * np.array(push["force"]),
            start=push["start"],
            duration=push["duration"],
        )
        for push in run.scenario["push"]
    ]


def events(run: SpatialRun) -> list[Event]:
    """What happened to a run, in order of time."""
    found = []
    for push in run.scenario["push"]:
        size = float(np.linalg.norm(push["force"]))
        what = f"push of {size:.3g} N" if size else "twist"
        found.append(Event(push["start"], "push", f"{what} on {push['body'].replace('_', ' ')}"))
    for event in run.scenario["event"]:
        k = body_index(event["vehicle"]) + 1
        text = {
            "cable_cut": f"cable {k} cut",
            "rotor_stopped": f"rotor {event['rotor']} of vehicle {k} stops",
            "vehicle_lost": f"vehicle {k} lost",
        }[event["kind"]]
        found.append(Event(event["time"], "broken", text))
    if not run.finished:
        found.append(Event(run.end_time, "end", run.scenario.model.reason(run.status, run.culprit)))
    return sorted((e for e in found if e.time <= run.end_time), key=lambda e: e.time)
