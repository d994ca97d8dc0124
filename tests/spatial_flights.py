"""Spatial runs from arrays, by the rows of bindings/spatial_problem.hpp, for tests of laws."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from multilift import _core, planning
from multilift.models.spatial import formation

FIELDS = _core.spatial_fields()
LAWS = _core.spatial_laws()
GRAVITY = 9.8

#: A quadrotor of 1 to 2 kg, besides what goes with its mass.
CRAFT = {
    "arm_length": 0.225,
    "torque_ratio": 0.016,
    "rotor_speed_max": 1000.0,
    "rotor_time_constant": 0.025,
}


def pack(table, n, given):
    """Fields in order as flat numbers; what is not given is at its default."""
    left = dict(given)
    parts = []
    for name, _, _, shape, default, _ in table:
        dims = tuple(n if size == "n" else size for size in shape)
        own = tuple(1 if size == "n" else size for size in shape)
        value = left.pop(name, np.reshape(default, own))
        parts.append(np.broadcast_to(np.asarray(value, dtype=float), dims).ravel())
    assert not left, f"no fields {sorted(left)}"
    return np.concatenate(parts) if parts else np.zeros(0)


@dataclass
class Team:
    """Vehicles, payload and the formation they hang it in."""

    mass: np.ndarray
    length: np.ndarray
    attachment: np.ndarray
    payload_mass: float
    payload_inertia: np.ndarray
    tilt: np.ndarray
    azimuth: np.ndarray | None = None
    plant: dict = field(default_factory=dict)

    def __post_init__(self):
        self.n = len(self.mass)
        azimuth = np.full(self.n, np.nan) if self.azimuth is None else self.azimuth
        rest = formation.rest(
            np.array([self.payload_mass]),
            np.array([GRAVITY]),
            self.attachment[None],
            self.length[None],
            self.tilt[None],
            azimuth[None],
            None,
        )
        assert rest.unbalanced[0] < 1e-9
        assert rest.least_tension[0] > 0
        self.offset, self.cable_force = rest.offset[0], rest.cable_force[0]

    @property
    def numbers(self):
        return {
            "gravity": GRAVITY,
            "payload_mass": self.payload_mass,
            "payload_inertia": self.payload_inertia,
            "vehicle_mass": self.mass,
            "cable_length": self.length,
            "attachment": self.attachment,
            **self.plant,
        }

    def relabelled(self, order):
        azimuth = None if self.azimuth is None else self.azimuth[order]
        return Team(
            self.mass[order],
            self.length[order],
            self.attachment[order],
            self.payload_mass,
            self.payload_inertia,
            self.tilt[order],
            azimuth,
            self.plant,
        )


def team(n, rng, *, kind="platform"):
    """A random team: a platform of n attachments on a circle, a bar of two, or a point mass."""
    mass = 1.2 + 0.4 * rng.random(n)
    length = 1.0 + 0.4 * rng.random(n)
    load = 0.3 * n * (1.0 + 0.3 * rng.random())
    if kind == "point":
        tilt = np.full(n, 0.0 if n == 1 else 0.45)
        return Team(mass, length, np.zeros((n, 3)), load, np.zeros(3), tilt)
    if n == 1:
        # A box under its one cable, which hangs it at its top.
        return Team(
            mass, length, np.array([[0.0, 0.0, 0.15]]), load, load * np.array([0.02, 0.02, 0.01]),
            np.zeros(1),
        )  # fmt: skip
    if n == 2:
        half = 0.6 + 0.3 * rng.random()
        arm = load * half**2 / 3
        return Team(
            mass, length, np.array([[-half, 0, 0.05], [half, 0, 0.05]]), load,
            np.array([0.01 * arm, arm, arm]), np.full(2, 0.2 * rng.random()),
        )  # fmt: skip
    angle = 2 * np.pi * np.arange(n) / n
    radius = 0.4 + 0.3 * rng.random()
    up = 0.02 + 0.05 * rng.random()
    at = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(n, up)], axis=1)
    flat = load * radius**2 / 4
    return Team(
        mass, length, at, load, np.array([flat, flat, 2 * flat]),
        np.full(n, 0.15 + 0.25 * rng.random()),
    )  # fmt: skip


def turn(q):
    """The rotation matrix of a unit quaternion, scalar first."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion(vector):
    """The unit quaternion of a rotation vector."""
    angle = np.linalg.norm(vector)
    axis = vector / angle if angle > 0 else np.zeros(3)
    return np.append(np.cos(angle / 2), np.sin(angle / 2) * axis)


def start(team, rng=None, *, amount=1.0, goal=(0.0, 0.0, 2.0), yaw=0.0):
    """The payload's 13 numbers and the vehicles' 6 each: at rest at the goal or perturbed from it.

    Cables stay at their lengths and keep them; what is perturbed is the payload's pose and motion,
    within the directions that its cables can act on, and the cables' directions.
    """
    n = team.n
    noise = (lambda *shape: np.zeros(shape)) if rng is None else (lambda *s: rng.uniform(-1, 1, s))
    level = turn(quaternion(np.array([0.0, 0.0, yaw])))
    free = np.linalg.matrix_rank(team.attachment, tol=1e-9) >= 2
    tumble = np.array([1.0, 1.0, 1.0]) if free else np.zeros(3)
    q = quaternion(np.array([0.0, 0.0, yaw]))
    off = quaternion(amount * 0.2 * tumble * noise(3))
    w = np.array([q[0] * off[0] - q[3] * off[3], q[0] * off[1] - q[3] * off[2],
                  q[0] * off[2] + q[3] * off[1], q[0] * off[3] + q[3] * off[0]])  # fmt: skip
    r = turn(w)
    x = np.asarray(goal) + amount * 0.4 * noise(3)
    v = amount * 0.2 * noise(3)
    omega = amount * 0.2 * tumble * noise(3)
    vehicles = np.zeros((n, 6))
    for i in range(n):
        d = level @ team.cable_force[i]
        d = d / np.linalg.norm(d) + amount * 0.15 * noise(3)
        d /= np.linalg.norm(d)
        rate = amount * 0.1 * noise(3)
        rate -= d * (d @ rate)
        arm = team.attachment[i]
        vehicles[i, :3] = x + r @ arm + team.length[i] * d
        vehicles[i, 3:] = v + r @ np.cross(omega, arm) + team.length[i] * rate
    return np.concatenate([x, w, v, omega]), vehicles


def padded(coefficients):
    """A piece's polynomial with zeros up to the degree that the core takes."""
    return [*coefficients, *[0.0] * (planning.DEGREE + 1 - len(coefficients))]


def fly(
    team,
    law,
    gains,
    begin,
    *,
    seconds,
    goal=(0.0, 0.0, 2.0),
    yaw=0.0,
    pieces=(),
    path_end=0.0,
    control_steps=1,
    step=0.001,
    craft=None,
    autopilot=None,
    motion_capture=None,
    link=None,
    limits=None,
    wind=None,
    assumed=None,
    record_steps=10,
    seed=1,
    callback=None,
):
    """One run; `craft` (or {}) makes the vehicles quadrotors. Samples come by columns' names."""
    n = team.n
    quadrotors = craft is not None
    payload, vehicles = begin
    plant = pack(FIELDS["plant"], n, team.numbers)
    parts = [plant, pack(FIELDS["plant"], n, {**team.numbers, **(assumed or {})})]
    if quadrotors:
        # Rotors that lift twice the weight with the share of the load; moments as of a like craft.
        lift = 2.0 * (team.mass * GRAVITY + team.cable_force[:, 2])
        given = {
            **CRAFT,
            "inertia": np.outer(team.mass, [0.0101, 0.0101, 0.0175]),
            "thrust_coefficient": lift / 4 / CRAFT["rotor_speed_max"] ** 2,
            **craft,
        }
        parts += [
            pack(FIELDS["quadrotor"], n, given),
            pack(FIELDS["autopilot"], n, autopilot or {}),
        ]
    parts += [team.offset.ravel(), team.cable_force.ravel(), [*goal, yaw]]
    parts += [pack(FIELDS["link"], n, link or {}), pack(FIELDS["limits"], n, limits or {})]
    if motion_capture is not None:
        parts.append(pack(FIELDS["motion_capture"], n, motion_capture))
    parts += [pack(FIELDS["wind"], n, wind or {}), pack(FIELDS["safety"], n, {})]
    if callback is None:
        parts.append(pack(LAWS[law][1], n, gains))
    parts += [payload, vehicles.ravel()]
    frame = _core.SpatialFrame(
        n=n, law="" if callback else law, quadrotors=quadrotors, rigid=True, ground=False,
        motion_capture=motion_capture is not None, rotors_running=True, autopilot_steps=1,
        pieces=[(t, [padded(row) for row in rows]) for t, rows in pieces],
        path_end=path_end, pushes=[], happenings=[], step=step,
        steps=round(seconds / step), control_steps=control_steps, record_steps=record_steps,
    )  # fmt: skip
    row = np.concatenate([np.ravel(np.asarray(part, dtype=float)) for part in parts])
    result = _core.spatial_run(frame, row, seed, callback)
    names = [c[0] for c in _core.spatial_describe(n, quadrotors)["columns"]]
    result["columns"] = dict(zip(names, np.asarray(result["samples"]).T, strict=True))
    return result


def payload_error(result):
    """Distance of the payload from its target, m, over the samples."""
    c = result["columns"]
    return np.sqrt(sum((c[f"payload_{k}"] - c[f"target_{k}"]) ** 2 for k in "xyz"))


def attitude_error(result):
    """Angle of the payload's attitude from level with the target's heading, rad."""
    c = result["columns"]
    half = 0.5 * c["target_yaw"]
    w = np.cos(half) * c["payload_qw"] + np.sin(half) * c["payload_qz"]
    return 2 * np.arccos(np.clip(np.abs(w), 0, 1))
