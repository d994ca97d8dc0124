"""What a flight's log must hold for the flight to be replayed, and how it is written there.

Two attached files, the scenario and the lab, complete, and a record a tick under `TOPIC`; see
docs/flight-replay.md. Everything else in a log is for people.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import ArrayLike

from multilift.flight.estimate.state import BodyState, Estimate
from multilift.flight.lab import Lab
from multilift.flight.link.setpoint import SetPoint
from multilift.flight.log import Log
from multilift.flight.supervisor import State

#: The topic of `tick`, and the names of the attached files.
TOPIC = "flight"
SCENARIO, LAB = "scenario.toml", "lab.toml"


def begin(log: Log, lab: Lab, now: float) -> None:
    """Puts into a log what was to be flown with what.

    Args:
        log: new.
        lab: of the flight.
        now: by the log's clock, s.
    """
    log.attach(SCENARIO, now, lab.scenario.to_toml())
    log.attach(LAB, now, tomli_w.dumps(_lab(lab)))


def tick(
    log: Log,
    now: float,
    state: State,
    estimate: Estimate,
    points: Sequence[SetPoint | None],
    drag_estimate: ArrayLike | None = None,
    problems: Sequence[str] = (),
) -> None:
    """Puts one tick of the flight loop into a log.

    Args:
        log: of the flight.
        now: by the log's clock, s.
        state: of the supervisor.
        estimate: of all bodies, now.
        points: what was sent to each vehicle; None where nothing was.
        drag_estimate: what the law has learnt, shape (n, 3), N s/m.
        problems: what is wrong, in words.
    """
    drag = None if drag_estimate is None else np.asarray(drag_estimate).tolist()
    log.write(TOPIC, now, {
        "state": state.value,
        "bodies": {name: _body(body) for name, body in estimate.bodies.items()},
        "set_points": [None if p is None else {"attitude": p.attitude, "thrust": p.thrust}
                       for p in points],
        "drag_estimate": drag,
        "problems": list(problems),
    })  # fmt: skip


def _body(body: BodyState) -> dict[str, Any]:
    return {
        "position": body.position,
        "attitude": body.attitude,
        "velocity": body.velocity,
        "rate": body.rate,
        "age": body.standing.age,
        "quality": body.standing.quality.name,
    }


def _lab(lab: Lab) -> Mapping[str, Any]:
    """The lab as its file would say it, defaults included; no keys of signatures."""
    vehicles = [
        {**{k: v for k, v in vars(vehicle).items() if k not in ("address", "mass")},
         "address": str(vehicle.address or "")}
        for vehicle in lab.vehicles
    ]  # fmt: skip
    return {
        "name": lab.name,
        "title": lab.title,
        "scenario": lab.scenario.name,
        "vehicle": vehicles,
        "motion_capture": dict(lab.motion_capture),
        "rates": dict(lab.rates),
        "limits": asdict(lab.limits),
        "security": {**lab.security, "key_file": ""},
    }
