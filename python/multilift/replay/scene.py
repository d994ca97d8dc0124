"""What there is to see of a run in space: shapes, places over time, and what happened when.

A model makes the scene of a run (`multilift.models.Model.scene`); page, recording and animation
draw it and know no model. World axes x, y, z (up), m; attitudes are unit quaternions, scalar first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: A cable is drawn slack where it pulls with less than this part of its usual tension.
SLACK_PART = 1e-6


@dataclass(frozen=True, kw_only=True)
class Body:
    """A payload's shape in its own frame, m.

    Attributes:
        kind: "point", a sphere; "bar", a rod between two ends; "plate", an outline with thickness.
        points: ends of a bar, shape (2, 3), or corners of a plate's outline, shape (k, 3), in its
            middle plane and in order; a point's centre, shape (1, 3).
        radius: of sphere or rod; half a plate's thickness.
    """

    kind: Literal["point", "bar", "plate"]
    points: Array
    radius: float


@dataclass(frozen=True, kw_only=True)
class Craft:
    """A vehicle.

    Attributes:
        name: for labels.
        position: shape (rows, 3), m.
        attitude: shape (rows, 4); None for a vehicle that has none, drawn as a ball.
        target: shape (rows, 3), m.
        thrust: of the rotors, world axes, shape (rows, 3), N.
        rotors: places of the rotors in its frame, shape (k, 3), m; none for a ball.
        radius: of a rotor disc, or of the ball, m.
        lost: from when on its rotors stand still, s.
    """

    name: str
    position: Array
    attitude: Array | None
    target: Array
    thrust: Array
    rotors: Array
    radius: float
    lost: float = np.inf


@dataclass(frozen=True, kw_only=True)
class Cable:
    """From the payload up to the vehicle of the same place in the list.

    Attributes:
        foot: where it is tied to the payload, world, shape (rows, 3), m.
        length: at rest, m.
        tension: shape (rows,), N.
        swing: angle from its direction at rest, shape (rows,), rad; NaN where it is slack, cut,
            or its vehicle lost.
        cut: from when on it is cut, s.
    """

    foot: Array
    length: float
    tension: Array
    swing: Array
    cut: float = np.inf


@dataclass(frozen=True, kw_only=True)
class Push:
    """An outside force.

    Attributes:
        body: -1 for the payload, else the vehicle's index.
        force: over the rows, world axes, 0 where it does not act, shape (rows, 3), N.
        start: when it begins to act, s.
        duration: for how long, s.
    """

    body: int
    force: Array
    start: float
    duration: float


@dataclass(frozen=True)
class Event:
    """Something at a time, s, that the time line marks; `kind` is "push", "broken" or "end"."""

    time: float
    kind: Literal["push", "broken", "end"]
    text: str


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A run to look at; all arrays have the rows of `t`.

    Attributes:
        name: of the scenario.
        title: one line.
        law: what flew it.
        ending: how it ended, a sentence.
        t: times, ascending, s.
        payload: its shape.
        payload_position: shape (rows, 3), m.
        payload_attitude: shape (rows, 4).
        payload_target: where it shall be, level, shape (rows, 3), m.
        payload_yaw: its target heading, rad.
        vehicles: in order.
        cables: one for each vehicle.
        pushes: outside forces.
        events: what the time line marks, in order.
        floor: height of the ground, m; None where there is none.
    """

    name: str
    title: str
    law: str
    ending: str
    t: Array
    payload: Body
    payload_position: Array
    payload_attitude: Array
    payload_target: Array
    payload_yaw: Array
    vehicles: Sequence[Craft]
    cables: Sequence[Cable]
    pushes: Sequence[Push] = ()
    events: Sequence[Event] = field(default_factory=list)
    floor: float | None = None

    @cached_property
    def payload_error(self) -> Array:
        """Distance of the payload from its target, m."""
        return np.asarray(np.linalg.norm(self.payload_position - self.payload_target, axis=1))

    @cached_property
    def usual_tension(self) -> tuple[float, float]:
        """Between which tensions colours run, in N. They are what cables pull but for rare jerks.

        At least a fifth of the greater one apart, so that a steady pull does not look restless.
        """
        pulling = np.concatenate([c.tension for c in self.cables])
        pulling = pulling[np.isfinite(pulling) & (pulling > SLACK_PART)]
        if pulling.size == 0:
            return 0.0, 1.0
        low, high = (float(x) for x in np.quantile(pulling, [0.02, 0.98]))
        spare = max(0.2 * high - (high - low), 0.0)
        return max(low - 0.5 * spare, 0.0), high + 0.5 * spare

    @cached_property
    def usual_thrust(self) -> float:
        """What a vehicle pulls at most, but for rare moments, N."""
        size = np.concatenate([np.linalg.norm(v.thrust, axis=1) for v in self.vehicles])
        size = size[np.isfinite(size)]
        return float(np.quantile(size, 0.98)) if size.size and size.max() > 0 else 1.0

    @cached_property
    def arrow_length(self) -> float:
        """How long the arrow of the usual thrust is, m."""
        return 0.5 * float(np.median([cable.length for cable in self.cables]))

    @cached_property
    def box(self) -> Array:
        """Least and greatest coordinates of bodies and targets, shape (2, 3), m.

        What leaves a hundred cable lengths behind diverged and is not waited for.
        """
        places = [self.payload_position, self.payload_target]
        places += [part for v in self.vehicles for part in (v.position, v.target)]
        every = np.concatenate(places)
        every = every[np.isfinite(every).all(axis=1)]
        middle = np.median(every, axis=0)
        reach = 100.0 * max(cable.length for cable in self.cables)
        every = every[(np.abs(every - middle) < reach).all(axis=1)]
        return np.array([every.min(axis=0), every.max(axis=0)])

    def slack(self, cable: int) -> NDArray[np.bool_]:
        """In which rows a cable hangs loose, whole or cut."""
        found = self.cables[cable]
        return np.asarray(
            ~(found.tension > SLACK_PART * self.usual_tension[1]) | (self.t >= found.cut)
        )

    def resting_height(self) -> float:
        """Of the plane on which shadows fall: the floor, or below everything, m."""
        if self.floor is not None:
            return self.floor
        low = float(self.box[0, 2]) - self.payload.radius
        return 0.0 if 0.0 <= low < 2.0 else float(np.floor(low * 2.0) / 2.0)


def point_body(mass: float) -> Body:
    """A ball as heavy as half water, so that sizes tell masses apart."""
    radius = float(np.cbrt(3.0 * mass / (4.0 * np.pi * 500.0)))
    return Body(kind="point", points=np.zeros((1, 3)), radius=radius)


def payload_body(mass: float, inertia: Array, attachments: Array) -> Body:
    """The shape that attachments and inertia suggest.

    Args:
        mass: kg.
        inertia: principal moments, kg m^2; zeros for a point.
        attachments: in the payload's frame, shape (n, 3), m.

    Returns:
        A ball for a point mass; a rod through the centre of mass between attachments on a line; a
        plate through those that span a plane; else the block of that inertia, as a plate.
    """
    if not (inertia > 0).all():
        return point_body(mass)
    spread = attachments - attachments.mean(axis=0)
    sizes, axes = np.linalg.svd(spread, full_matrices=False)[1:]
    if sizes[0] > 1e-6 and (len(sizes) < 2 or sizes[1] <= 1e-3 * sizes[0]):
        along = spread @ axes[0]
        centre = axes[0] * (attachments.mean(axis=0) @ axes[0])
        ends = np.array([centre + along.min() * axes[0], centre + along.max() * axes[0]])
        away = float(np.linalg.norm(attachments.mean(axis=0) - centre))
        return Body(kind="bar", points=ends, radius=max(away, 0.01))
    outline = convex_outline(attachments[:, :2])
    if len(outline) >= 3:
        half = max(float(np.abs(attachments[:, 2]).max()), 0.01)
    else:
        half_sides = 0.5 * np.sqrt(np.maximum(6.0 * (inertia.sum() - 2.0 * inertia) / mass, 4e-4))
        signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        outline, half = signs * half_sides[:2], float(half_sides[2])
    return Body(
        kind="plate", points=np.column_stack([outline, np.zeros(len(outline))]), radius=half
    )


def convex_outline(points: Array) -> Array:
    """The corners of the convex hull of points in a plane, counterclockwise, shape (k, 2)."""
    ordered = sorted({(float(x), float(y)) for x, y in np.round(points, 9)})
    if len(ordered) < 3:
        return np.array(ordered).reshape(-1, 2)

    def half(side: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        chain: list[tuple[float, float]] = []
        for x, y in side:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 1e-12:
                    break
                chain.pop()
            chain.append((x, y))
        return chain[:-1]

    return np.array(half(ordered) + half(ordered[::-1]))
