"""What a spatial scenario's tables must satisfy together.

Every function raises ScenarioError with file, key, value, permitted range and what to do.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from multilift import pushes
from multilift.errors import ScenarioError
from multilift.models.spatial import tables
from multilift.models.spatial.formation import BALANCE_TOLERANCE, Rest

#: The greatest mass of a vehicle per payload mass. Tensions under heavy vehicles are small
#: differences of large numbers, in equations whose condition is this ratio too: their rounding
#: goes with its square, 1e-6 of a tension here and all of it a thousand times further on.
MOST_MASS_RATIO = 1e5


def check_kind(values: dict[str, Any], where: str) -> None:
    """A quadrotor needs all of its numbers."""
    if values["vehicle"]["kind"] == "ideal":
        return
    for field in tables.VEHICLE_NUMBERS:
        if values["vehicle"][field.name] is None:
            raise ScenarioError(
                "is missing", where=where, key=f"vehicle.{field.name}",
                advice=f"quadrotors need it: {field.doc}; or name a vehicle.type that has it",
            )  # fmt: skip
    _check_below(values, where, "autopilot.thrust_curve", 1.0)
    _check_below(values, where, "autopilot.yaw_weight", 1.0)
    step = values["simulation"]["step"]
    ratio = 1.0 / values["autopilot"]["rate"] / step
    if ratio < 1 - 1e-6 or abs(ratio - round(ratio)) > 1e-6 * ratio:
        raise ScenarioError(
            f"has a period of {ratio:.6g} integration steps, not a whole number",
            where=where,
            key="autopilot.rate",
            value=values["autopilot"]["rate"],
            permitted=f"1/(k {step:g} s) for whole k",
        )


def check_limits(values: dict[str, Any], where: str) -> None:
    """Limits that contradict each other, parts that are no parts, a floor without gravity."""
    limits = values["limits"]
    if (np.array(limits["thrust_min"]) >= np.array(limits["thrust_max"])).any():
        raise ScenarioError(
            "is not below thrust_max", where=where, key="limits.thrust_min",
            value=limits["thrust_min"], permitted=f"< {limits['thrust_max']} N",
        )  # fmt: skip
    if max(limits["tilt_max"]) > np.pi / 2 + 1e-12:
        raise ScenarioError(
            "is more than a quarter turn", where=where, key="limits.tilt_max",
            value=limits["tilt_max"], permitted="0 < tilt_max <= pi/2 rad",
        )  # fmt: skip
    _check_below(values, where, "plant.cable_restitution", 1.0)
    for key in ("link.loss", "motion_capture.dropout"):
        _check_below(values, where, key, 0.999)
    if values["plant"]["gravity"] == 0.0:
        raise ScenarioError(
            "is 0, but rotors and cables hold weight here", where=where, key="plant.gravity",
            value=0.0, permitted="> 0 m/s^2",
        )  # fmt: skip


def _check_below(values: dict[str, Any], where: str, key: str, most: float) -> None:
    table, name = key.split(".")
    value = values[table][name]
    if np.max(value) > most:
        raise ScenarioError(
            "is too large", where=where, key=key, value=value, permitted=f"0 to {most:g}"
        )


def check_payload(values: dict[str, Any], where: str) -> None:
    """A mass or an inertia that no load has, or a point with cables that are not at its centre."""
    plant = values["plant"]
    inertia, attachment = np.array(plant["payload_inertia"]), np.array(plant["attachment"])
    point = (inertia == 0).all()
    if point and np.abs(attachment).max() > 0:
        raise ScenarioError(
            "turns a point mass",
            where=where,
            key="plant.attachment",
            value=plant["attachment"],
            permitted="all 0 where plant.payload_inertia is 0",
            advice="give the payload its moments of inertia; a thin bar has a small one about "
            "itself",
        )
    heaviest = max(plant["vehicle_mass"])
    if not heaviest <= MOST_MASS_RATIO * plant["payload_mass"]:
        raise ScenarioError(
            f"is so light beside a vehicle of {heaviest:g} kg that tensions are lost in rounding",
            where=where,
            key="plant.payload_mass",
            value=plant["payload_mass"],
            permitted=f">= {heaviest / MOST_MASS_RATIO:g} kg",
            advice="leave out what weighs nothing, or make the vehicles lighter",
        )
    largest = inertia.max()
    if not point and ((inertia <= 0).any() or 2 * largest > inertia.sum() * (1 + 1e-9)):
        raise ScenarioError(
            "is no body's",
            where=where,
            key="plant.payload_inertia",
            value=plant["payload_inertia"],
            permitted="three moments > 0, none above the sum of the others; or all 0",
        )


def check_formation(values: dict[str, Any], rest: Rest, where: str) -> None:
    """Cables that cannot hold the payload level as they lean."""
    if max(values["formation"]["tilt"]) >= np.pi / 2:
        raise ScenarioError(
            "does not lift", where=where, key="formation.tilt",
            value=values["formation"]["tilt"], permitted="0 <= tilt < pi/2 rad",
        )  # fmt: skip
    if not rest.unbalanced[0] <= BALANCE_TOLERANCE:
        raise ScenarioError(
            f"leaves a wrench of {rest.unbalanced[0]:.3g} payload weights that no tensions balance",
            where=where,
            key="formation.tilt",
            value=values["formation"]["tilt"],
            permitted="directions and attachments that can hold the payload level",
            advice="attach cables around the centre of mass, and lean them outwards evenly",
        )
    if rest.least_tension[0] <= 0.0:
        raise ScenarioError(
            f"asks a cable to push ({rest.least_tension[0]:.3g} N)",
            where=where,
            key="formation.tilt",
            value=values["formation"]["tilt"],
            permitted="formations in which every cable pulls",
            advice="move plant.attachment so that every cable carries",
        )


def check_start(lengths: np.ndarray[Any, Any], values: dict[str, Any], where: str) -> None:
    """Rigid cables that would have to be longer than they are."""
    if values["plant"]["cables"] == "elastic":
        return
    excess = lengths - np.array(values["plant"]["cable_length"])
    worst = int(np.argmax(excess))
    if excess[worst] > 1e-6:
        raise ScenarioError(
            f"stretches cable {worst + 1} by {excess[worst]:.6g} m",
            where=where,
            key="start.vehicle_position",
            value=values["start"]["vehicle_position"],
            permitted=f"within {values['plant']['cable_length'][worst]:g} m of its attachment",
            advice="move the vehicle, or leave start.vehicle_position out to start in formation",
        )


def check_happenings(values: dict[str, Any], where: str) -> None:
    """Pushes that turn a point, profiles that lack something, rotors that are not there."""
    for k, push in enumerate(values["push"]):
        if any(push["torque"]) and push["body"] != "payload":
            raise ScenarioError(
                "acts on a vehicle", where=where, key=f"push[{k}].torque", value=push["torque"],
                advice="torques act on the payload only",
            )  # fmt: skip
        pushes.check_profile(push, f"push[{k}]", where)
    for k, event in enumerate(values["event"]):
        if event["kind"] == "rotor_stopped" and values["vehicle"]["kind"] == "ideal":
            raise ScenarioError(
                "stops a rotor that ideal vehicles do not have", where=where,
                key=f"event[{k}].kind", value=event["kind"],
                advice='use vehicle_lost, or vehicle.kind = "quadrotor"',
            )  # fmt: skip
