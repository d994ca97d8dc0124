"""What does not change during a flight: shapes and the fence, as the page's process needs them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from multilift.flight.lab import Lab
from multilift.replay.scene import payload_body

Points = list[list[float]]


@dataclass(frozen=True)
class Stage:
    """Shapes in their own frames, m; world ENU.

    Attributes:
        title: of the lab.
        body: kind of the payload's shape, see `multilift.replay.scene.Body`.
        points, radius: of that shape.
        attachments: of the cables at the payload, in its frame, one for each vehicle.
        rotors: places of each vehicle's rotors, in its frame.
        discs: radius of each vehicle's rotors.
        pulls: of each cable at rest, N.
        fence_low, fence_high: corners of the fence.
    """

    title: str
    body: str
    points: Points
    radius: float
    attachments: Points
    rotors: list[Points]
    discs: list[float]
    pulls: list[float]
    fence_low: list[float]
    fence_high: list[float]

    def to_dict(self) -> dict[str, Any]:
        """As JSON has it."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Stage:
        """What `to_dict` made."""
        return cls(**values)


def stage_of(lab: Lab) -> Stage:
    """The stage of a lab."""
    flown = lab.scenario
    plant, vehicle = flown.values["plant"], flown.values["vehicle"]
    body = payload_body(
        plant["payload_mass"], np.array(plant["payload_inertia"]), np.array(plant["attachment"])
    )
    arms = [float(arm) for arm in vehicle["arm_length"]]
    turns = [[angle + 0.5 * math.pi * k for k in range(4)] for angle in vehicle["frame_angle"]]
    pulls = np.linalg.norm(flown.rest.cable_force[0], axis=1)
    return Stage(
        lab.title or lab.name,
        body.kind,
        body.points.tolist(),
        body.radius,
        [list(point) for point in plant["attachment"]],
        [[[arm * math.cos(a), arm * math.sin(a), 0.0] for a in angles]
         for arm, angles in zip(arms, turns, strict=True)],
        [0.56 * arm for arm in arms],  # what an X frame has room for, less a little
        pulls.tolist(),
        lab.limits.fence_low,
        lab.limits.fence_high,
    )  # fmt: skip
