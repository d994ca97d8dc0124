"""Where a bar on two cables can hang: closure, reach and rest of the planar plant."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift import _core
from multilift.errors import ScenarioError

Vector = NDArray[np.float64]

#: How far given start coordinates may miss the closure before they count as a mistake, m and m/s.
CLOSURE_TOLERANCE = 1e-6


def linkage_problem(plant: dict[str, Any], vehicles: Vector) -> str:
    """Why no taut cables can join these vehicles to the bar, or "".

    The vehicles' distance, the cables and the bar are the four sides of a closed polygon, so the
    longest may not exceed the sum of the others.

    Args:
        plant: normalised ``[plant]`` table.
        vehicles: positions (y, z) of both vehicles, shape (2, 2), m.
    """
    distance = float(np.hypot(*(vehicles[1] - vehicles[0])))
    sides = {
        "the distance between the vehicles": distance,
        "cable 1": plant["cable_length"][0],
        "cable 2": plant["cable_length"][1],
        "the bar": plant["bar_length"],
    }
    longest = max(sides, key=lambda k: sides[k])
    others = sum(sides.values()) - sides[longest]
    if sides[longest] > others:
        return (
            f"{longest} measures {sides[longest]:.6g} m, more than the other three of vehicles' "
            f"distance, cables and bar together ({others:.6g} m)"
        )
    return ""


def rest_angles(plant_values: list[float], vehicles: Vector) -> Vector:
    """Angles at which the load hangs at rest below fixed vehicles, shape (3,), rad.

    Args:
        plant_values: the plant's numbers in the core's order.
        vehicles: positions (y, z) of both vehicles, shape (2, 2), m.

    Raises:
        ValueError: if no rest with all angles inside +-pi/2 was found.
    """
    angles = _core.planar_rest_angles(plant_values, vehicles.ravel().tolist())
    if angles is None:
        raise ValueError("no rest with all angles inside +-90 degrees was found")
    return np.array(angles)


def goal_mismatch(plant: dict[str, Any], goal: Vector) -> tuple[float, float]:
    """By how much goals miss (17): y2 - y1 - l0 and (z1 - l1) - (z2 - l2), m."""
    l1, l2 = plant["cable_length"]
    return (
        float(goal[1, 0] - goal[0, 0] - plant["bar_length"]),
        float((goal[0, 1] - l1) - (goal[1, 1] - l2)),
    )


def start_coordinates(
    plant: dict[str, Any], plant_values: list[float], start: dict[str, Any], where: str
) -> tuple[Vector, Vector]:
    """The seven coordinates and rates of a ``[start]`` table, each shape (7,).

    Raises:
        ScenarioError: for a linkage that cannot close, angles or rates off the closure.
    """
    vehicles = np.array(start["vehicle_position"])
    problem = linkage_problem(plant, vehicles)
    if problem:
        raise ScenarioError(
            f"is impossible: {problem}",
            where=where,
            key="start.vehicle_position",
            value=start["vehicle_position"],
            advice="move the vehicles or change plant.bar_length or plant.cable_length",
        )
    if start["angle"] is None:
        try:
            angle = rest_angles(plant_values, vehicles)
        except ValueError as error:
            raise ScenarioError(
                f"gives no start at rest: {error}",
                where=where,
                key="start.vehicle_position",
                value=start["vehicle_position"],
                advice="move the vehicles, or give start.angle",
            ) from None
    else:
        angle = np.array(start["angle"])
    if (np.abs(angle) >= math.pi / 2).any():
        raise ScenarioError(
            "is outside the model",
            where=where,
            key="start.angle",
            value=angle.tolist(),
            permitted="-pi/2 < angle < pi/2 (assumption 3)",
        )
    q = np.concatenate([vehicles.ravel(), angle])
    gap = np.array(_core.planar_closure(plant_values, q.tolist()))
    if np.abs(gap).max() > CLOSURE_TOLERANCE:
        raise ScenarioError(
            f"is off the closure: with these angles the cables' ends are not the bar's ends, by "
            f"{gap[0]:.3g} m along y and {gap[1]:.3g} m along z",
            where=where,
            key="start.angle",
            value=angle.tolist(),
            permitted=f"at most {CLOSURE_TOLERANCE:g} m off",
            advice="leave start.angle out to start at rest below the vehicles",
        )
    q_dot = _start_rates(plant_values, q, start, where)
    return q, q_dot


def _start_rates(plant_values: list[float], q: Vector, start: dict[str, Any], where: str) -> Vector:
    velocity, rate = start["vehicle_velocity"], start["angle_rate"]
    q_dot = np.zeros(7)
    q_dot[:4] = np.ravel(velocity) if velocity is not None else 0.0
    q_dot[4:] = rate if rate is not None else 0.0
    # The closure's rate along q_dot, by a central difference: c is smooth, of metres' size.
    h = 1e-6
    ahead = np.array(_core.planar_closure(plant_values, (q + h * q_dot).tolist()))
    behind = np.array(_core.planar_closure(plant_values, (q - h * q_dot).tolist()))
    gap = (ahead - behind) / (2 * h)
    if np.abs(gap).max() > CLOSURE_TOLERANCE:
        raise ScenarioError(
            f"is off the closure: these rates part the cables' ends from the bar's ends at "
            f"({gap[0]:.3g}, {gap[1]:.3g}) m/s",
            where=where,
            key="start.angle_rate" if rate is not None else "start.vehicle_velocity",
            value=rate if rate is not None else velocity,
            permitted=f"at most {CLOSURE_TOLERANCE:g} m/s off",
            advice="give rates that keep the bar's length, or leave both out to start at rest",
        )
    return q_dot
