"""Parameters of the firmwares: files as shipped, and what follows from a vehicle."""

from __future__ import annotations

import math
from importlib import resources

from multilift.errors import ScenarioError
from multilift.scenario import Scenario

#: How far a frame's angle may be from an X's or a +'s to be one, rad.
_FRAME_TOLERANCE = math.radians(1.0)
#: PX4's KM for a rotor: any number serves by which rotors differ in sign alone, as the allocation
#: is normalised for each axis.
_MOMENT = 0.05


def shipped(firmware: str) -> dict[str, float]:
    """A shipped file: ``px4`` or ``ardupilot``."""
    name = {"px4": "px4.params", "ardupilot": "ardupilot.parm"}[firmware]
    text = (resources.files(__package__) / name).read_text(encoding="utf-8")
    pairs = (line.split() for line in text.splitlines() if line and not line.startswith("#"))
    return {key: float(value) for key, value in pairs}


def of_vehicle(firmware: str, scenario: Scenario, index: int) -> dict[str, float]:
    """What follows from a scenario's vehicle: its rotors and its hover thrust.

    Raises:
        ScenarioError: for a vehicle that cannot hover with its share of the load, or a frame that
            ArduPilot has none for.
    """
    hover = hover_share(scenario, index)
    arm, angle = scenario["vehicle.arm_length"][index], scenario["vehicle.frame_angle"][index]
    if firmware == "ardupilot":
        return {
            "FRAME_CLASS": 1,
            "FRAME_TYPE": _frame_type(scenario, angle),
            "MOT_THST_HOVER": round(hover, 4),
        }
    values: dict[str, float] = {
        "MPC_THR_HOVER": round(hover, 4),
        "CA_AIRFRAME": 0,
        "CA_ROTOR_COUNT": 4,
    }
    # PX4's y is to the right, ours to the left; rotors of ours follow each other by quarter turns.
    for motor, (rotor, counterclockwise) in enumerate(((3, 1), (1, 1), (0, -1), (2, -1))):
        at = angle + rotor * math.pi / 2
        values[f"CA_ROTOR{motor}_PX"] = round(arm * math.cos(at), 5)
        values[f"CA_ROTOR{motor}_PY"] = round(-arm * math.sin(at), 5)
        values[f"CA_ROTOR{motor}_KM"] = counterclockwise * _MOMENT
        values[f"PWM_MAIN_FUNC{motor + 1}"] = 101 + motor
    return values


def hover_share(scenario: Scenario, index: int) -> float:
    """Part of a vehicle's greatest thrust with which it holds itself and its share of the load.

    Raises:
        ScenarioError: where that is more than all of it.
    """
    count, gravity = scenario["plant.vehicles"], scenario["plant.gravity"]
    mass = scenario["plant.vehicle_mass"][index] + scenario["plant.payload_mass"] / count
    top = scenario["vehicle.rotor_speed_max"][index]
    greatest = 4.0 * scenario["vehicle.thrust_coefficient"][index] * top * top
    if mass * gravity >= greatest:
        raise ScenarioError(
            f"does not lift {mass:g} kg at vehicle_{index + 1}",
            where=scenario.where,
            key="vehicle.rotor_speed_max",
            value=top,
            advice="take stronger rotors or a lighter load",
        )
    return float(mass * gravity / greatest)


def _frame_type(scenario: Scenario, angle: float) -> int:
    """ArduPilot's FRAME_TYPE: 1 is an X, 0 a +."""
    for wanted, kind in ((math.pi / 4, 1), (0.0, 0)):
        if abs(angle - wanted) < _FRAME_TOLERANCE:
            return kind
    raise ScenarioError(
        "is a frame that ArduPilot has none for",
        where=scenario.where,
        key="vehicle.frame_angle",
        value=angle,
        permitted="45 deg (X) or 0 (+)",
    )
