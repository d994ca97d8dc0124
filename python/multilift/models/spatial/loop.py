"""The spatial feedback loop about rest at the goal, to first order."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from multilift import _core
from multilift.loop import Loop, StateSpace
from multilift.models.spatial import lqr, rows

if TYPE_CHECKING:
    from multilift.models.spatial.scenario import SpatialScenario

Array = NDArray[np.float64]

_AXES = "xyz"


def _cross(r: Array) -> Array:
    return np.cross(np.eye(3), r).T


def _derivatives(scenario: SpatialScenario) -> tuple[Array, Array]:
    """Along payload (12), vehicles (6n) and forces (3n): accelerations (6 + 3n), forces (3n)."""
    n = scenario.count
    frame, row, _ = rows.problem(scenario)
    out = np.zeros((12 + 9 * n, 6 + 6 * n))
    _core.spatial_linearise(_core.SpatialFrame(**frame), row, out)
    table = out.T
    return table[: 6 + 3 * n], table[6 + 3 * n :]


def _coordinates(scenario: SpatialScenario) -> tuple[tuple[str, ...], Array, Array]:
    """Free coordinates: their names, the bodies' places along them, and back.

    Places are the payload's position (world) and attitude (its own axes) and the vehicles'
    positions (world), 6 + 3n; coordinates are displacement, rotations that move a cable, and two
    tilts of each cable, in the payload's level frame.
    """
    plant, n = scenario.values["plant"], scenario.count
    yaw = np.array([scenario["goal.payload_yaw"]])
    (heading,) = rows.turn(yaw)
    attachment = np.array(plant["attachment"])
    length, force = np.array(plant["cable_length"]), scenario.rest.cable_force[0]
    plain = lqr.linearisation(
        np.array(plant["vehicle_mass"]), length, attachment, plant["payload_mass"],
        np.array(plant["payload_inertia"]), force,
    )  # fmt: skip
    k, m = len(plain.turns), plain.count
    level = np.zeros((6 + 3 * n, m))
    level[:3, :3] = np.eye(3)
    level[3:6, 3 : 3 + k] = plain.turns.T
    for i in range(n):
        across = np.linalg.svd(force[i][None])[2][1:].T
        at = slice(6 + 3 * i, 9 + 3 * i)
        level[at, :3] = np.eye(3)
        level[at, 3 : 3 + k] = -_cross(attachment[i]) @ plain.turns.T
        level[at, 3 + k + 2 * i : 5 + k + 2 * i] = length[i] * across
    turn = np.kron(np.eye(2 + n), heading)
    turn[3:6, 3:6] = np.eye(3)
    names = (
        *(f"payload {axis}" for axis in _AXES),
        *(f"payload turn {j + 1}" for j in range(k)),
        *(f"cable {i + 1} tilt {j + 1}" for i in range(n) for j in range(2)),
    )
    return names, turn @ level, plain.place @ turn.T


def _tilt(scenario: SpatialScenario, i: int, thrust: float) -> tuple[StateSpace, StateSpace, float]:
    """A quadrotor's force across its rotor axis (x, y alike if round) and along it, per command."""
    craft, autopilot = scenario.values["vehicle"], scenario.values["autopilot"]

    def of(table: dict[str, object], name: str) -> Array:
        return np.array(table[name], float)[i]

    k_f, top = of(craft, "thrust_coefficient"), of(craft, "rotor_speed_max")
    lag, curve = of(craft, "rotor_time_constant"), of(autopilot, "thrust_curve")
    hover = of(autopilot, "hover_thrust")
    weight = scenario.rest.cable_force[0][i][2]
    assumed = scenario["controller.assumed"]
    weight = weight + np.array(assumed["vehicle_mass"])[i] * assumed["gravity"]
    greatest = 4.0 * k_f * top**2
    speed = np.sqrt(thrust / (4.0 * k_f)) / top
    slope = 1.0 / (1.0 - curve + 2.0 * curve * speed)  # of the motor command, per thrust share
    per_rotor = 2.0 * k_f * top**2 * speed * slope  # N per unit of mixed torque
    gain = 1.0 if hover == 0.0 else 4.0 * per_rotor * hover / weight
    along = _lag(lag, gain)
    blocks = []
    for axis in (1, 0):  # pitch tilts along x, roll along -y
        p, integral, d = (float(of(autopilot, f"rate_{name}")[axis]) for name in "pid")
        attitude = float(of(autopilot, "attitude_gain")[axis])
        torque = 2.0 * per_rotor * float(of(craft, "arm_length")) / float(of(craft, "inertia")[axis])
        cut = 2.0 * np.pi * float(of(autopilot, "rate_filter"))
        # z = angle, rate, torque over inertia, integral of the rate's error, filtered rate's change
        # e = attitude (wanted - angle) - rate; the change is filtered from what the torque makes.
        a = np.zeros((5, 5))
        a[0, 1] = a[1, 2] = 1.0
        error = np.array([-attitude, -1.0, 0.0, 0.0, 0.0])
        mixed = p * error
        mixed[3] += integral
        mixed[4] -= d
        a[2] = torque * mixed / lag
        a[2, 2] -= 1.0 / lag
        a[3] = error
        a[4, 2], a[4, 4] = cut, -cut
        b = np.zeros((5, 1))
        b[2, 0], b[3, 0] = torque * p * attitude / lag, attitude
        c = np.zeros((1, 5))
        c[0, 0] = 1.0
        blocks.append(StateSpace(a, b, c, np.zeros((1, 1))))
    drag = 4.0 * speed * top * float(of(craft, "rotor_drag"))
    return _side_by_side(blocks), along, drag


def _lag(time: float, gain: float) -> StateSpace:
    one = np.ones((1, 1))
    return StateSpace(-one / time, one / time, gain * one, 0.0 * one)


def _side_by_side(blocks: list[StateSpace]) -> StateSpace:
    def diagonal(parts: list[Array]) -> Array:
        shape = tuple(sum(p.shape[j] for p in parts) for j in range(2))
        whole, r, c = np.zeros(shape), 0, 0
        for part in parts:
            whole[r : r + part.shape[0], c : c + part.shape[1]] = part
            r, c = r + part.shape[0], c + part.shape[1]
        return whole

    return StateSpace(*(diagonal([getattr(b, name) for b in blocks]) for name in "abcd"))


def _vehicles(scenario: SpatialScenario) -> tuple[StateSpace, Array]:
    """The vehicles' answer to commanded forces, and the drag that their rotors add, (3n, 3n)."""
    n, plant = scenario.count, scenario.values["plant"]
    if scenario["vehicle.kind"] == "ideal":
        return StateSpace.through(3 * n), np.zeros((3 * n, 3 * n))
    yaw = np.array([scenario["goal.payload_yaw"]])
    (heading,) = rows.turn(yaw)
    frames, blocks, drag = [], [], np.zeros((3 * n, 3 * n))
    for i in range(n):
        force = heading @ scenario.rest.cable_force[0][i]
        force[2] += plant["vehicle_mass"][i] * plant["gravity"]
        thrust = float(np.linalg.norm(force))
        up = force / thrust
        # The shortest turn from upright to the force, after the heading.
        side = np.cross([0.0, 0.0, 1.0], up)
        tilted = np.eye(3) + _cross(side) + _cross(side) @ _cross(side) / (1.0 + up[2])
        frame = tilted @ heading
        across, along, loss = _tilt(scenario, i, thrust)
        blocks.append(_side_by_side([across, along]))
        frames.append(frame)
        at = slice(3 * i, 3 * i + 3)
        drag[at, at] = loss * (np.eye(3) - np.outer(up, up))
    whole = _side_by_side(blocks)
    turn = np.zeros((3 * n, 3 * n))
    for i, frame in enumerate(frames):
        turn[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = frame
    return StateSpace(whole.a, whole.b @ turn.T, turn @ whole.c, turn @ whole.d @ turn.T), drag


def loop(scenario: SpatialScenario) -> Loop:
    """The feedback loop about rest at the goal, by dual numbers through plant and law.

    Quadrotors' attitude and rate loops and rotors are those of the core's equations about hover,
    derived by hand. Wind and floor are left out.

    Raises:
        ValueError: if a cable is slack at rest.
    """
    n = scenario.count
    acceleration, law = _derivatives(scenario)
    names, along, back = _coordinates(scenario)
    m = len(names)
    vehicles, drag = _vehicles(scenario)
    place = np.r_[0:6, 12 : 12 + 3 * n]
    rate = np.r_[6:12, 12 + 3 * n : 12 + 6 * n]
    force = slice(12 + 6 * n, None)
    a = np.zeros((2 * m, 2 * m))
    a[:m, m:] = np.eye(m)
    a[m:, :m] = back @ acceleration[:, place] @ along
    a[m:, m:] = back @ acceleration[:, rate] @ along
    b = np.vstack([np.zeros((m, 3 * n)), back @ acceleration[:, force]])
    a[m:, m:] -= b[m:] @ drag @ along[6:]
    feedback = np.hstack([law[:, place] @ along, law[:, rate] @ along])
    link, capture = scenario.values["link"], scenario.values["motion_capture"]
    hold = 0.5 * scenario.control_period()
    stale = max(0.0, 0.5 * capture["period"] - hold)
    delay = hold + stale + capture["delay"] + link["delay"] + 0.5 * link["jitter"]
    channels = tuple(f"vehicle {i + 1}, {axis}" for i in range(n) for axis in _AXES)
    states = (*names, *(f"rate of {name}" for name in names))
    return Loop(states, channels, a, b, feedback, vehicles, delay, hold)
