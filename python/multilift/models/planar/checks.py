"""What a planar scenario's tables must satisfy together, beyond the range of each key.

Every function raises ScenarioError with file, key, value, permitted range and what to do.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from multilift import _core, pushes
from multilift.errors import ScenarioError
from multilift.models.planar import geometry


def check_limits(values: dict[str, Any], where: str) -> None:
    """Actuator limits that contradict each other or cannot hold the load."""
    limits = values["actuators"]
    if limits["thrust_min"] >= limits["thrust_max"]:
        raise ScenarioError(
            "is not below thrust_max",
            where=where,
            key="actuators.thrust_min",
            value=limits["thrust_min"],
            permitted=f"< {limits['thrust_max']:g} N",
        )
    if limits["tilt_max"] > np.pi / 2 + 1e-12:
        raise ScenarioError(
            "is more than a quarter turn",
            where=where,
            key="actuators.tilt_max",
            value=limits["tilt_max"],
            permitted="0 < tilt_max <= pi/2 rad",
        )
    share = [
        (m + 0.5 * values["plant"]["bar_mass"]) * values["plant"]["gravity"]
        for m in values["plant"]["vehicle_mass"]
    ]
    if max(share) > limits["thrust_max"]:
        raise ScenarioError(
            "cannot hold a vehicle and its half of the bar",
            where=where,
            key="actuators.thrust_max",
            value=limits["thrust_max"],
            permitted=f">= {max(share):.6g} N",
        )


def check_goal(values: dict[str, Any], where: str) -> None:
    """Goals that break (17) unless asked for, or that no cables reach."""
    goal = np.array(values["goal"]["vehicle_position"])
    along, up = geometry.goal_mismatch(values["plant"], goal)
    if max(abs(along), abs(up)) > 1e-6 and not values["goal"]["allow_mismatch"]:
        raise ScenarioError(
            f"breaks (17): y2 - y1 misses the bar's length by {along:.6g} m, the cables' lower "
            f"ends differ by {up:.6g} m in height",
            where=where,
            key="goal.vehicle_position",
            value=values["goal"]["vehicle_position"],
            permitted="y2 - y1 = plant.bar_length and z1 - l1 = z2 - l2",
            advice="mend the goal, or set goal.allow_mismatch = true to fly it anyway",
        )
    problem = geometry.linkage_problem(values["plant"], goal)
    if problem:
        raise ScenarioError(
            f"is impossible: {problem}",
            where=where,
            key="goal.vehicle_position",
            value=values["goal"]["vehicle_position"],
        )


def check_reference(values: dict[str, Any], where: str) -> None:
    """Parts that are no parts."""
    for key in ("tolerance", "damping_ratio"):
        if values["reference"][key] >= 1.0:
            raise ScenarioError(
                "is no part",
                where=where,
                key=f"reference.{key}",
                value=values["reference"][key],
                permitted="< 1",
            )


def check_pushes(values: dict[str, Any], where: str) -> None:
    """Profiles that are not complete, and torques on vehicles, which are point masses."""
    for k, push in enumerate(values["push"]):
        key = f"push[{k}]"
        if push["torque"] and push["body"] != "bar":
            raise ScenarioError(
                "acts on a point mass", where=where, key=f"{key}.torque", value=push["torque"],
                advice="torques act on the bar only",
            )  # fmt: skip
        pushes.check_profile(push, key, where)


def check_capacity(values: dict[str, Any], counts: Mapping[str, int], where: str) -> None:
    """Delays that keep more commands or measurements under way than the core has room for.

    Args:
        values: complete, as ``Scenario.values``.
        counts: from `multilift.validation.check_timing`.
        where: for errors.
    """
    step = float(values["simulation"]["step"])
    control = counts["controller.rate"]
    sample = counts["sensors.period"] or control
    capacity = _core.planar_delay_capacity - 2
    # Commands arrive at every step, measurements are fetched at control instants only.
    for key, wait, every in (
        ("actuators.command_delay", 0, control),
        ("sensors.delay", control, sample),
    ):
        if counts[key] + wait > capacity * every:
            raise ScenarioError(
                "keeps too many values under way",
                where=where,
                key=key,
                value=counts[key] * step,
                permitted=f"at most {(capacity * every - wait) * step:g} s at these rates",
            )
