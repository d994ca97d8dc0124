"""Where a twin's flight begins: all stand on the floor, the vehicles beside their places."""

from __future__ import annotations

import numpy as np

from multilift.flight.plan import lead_time
from multilift.models.spatial.scenario import SpatialScenario

#: How far outwards of its place at the load a vehicle stands, and of the load's centre at least, m.
_BESIDE = 0.4
_LEAST = 0.8

#: The heights at which vehicles and load stand, as the floor holds them up, m.
_VEHICLE_CLEARANCE = 0.15
_LOAD_CLEARANCE = 0.02

_PLACES = ("payload_position", "vehicle_position")

#: From the first vehicle armed to the order to take off: all must have said so, s.
_ARMING = 0.5


def standing(flown: SpatialScenario) -> SpatialScenario:
    """The scenario with a floor, its load and vehicles on it and their rotors stopped.

    One that has a floor and stopped rotors stays as it is.
    """
    if flown.values["ground"]["present"] and flown.values["start"]["rotors"] == "stopped":
        return flown
    load = np.array(flown.values["start"]["payload_position"])
    sink = float(flown.values["ground"]["sink"])
    load[2] = _LOAD_CLEARANCE - sink
    place = flown.rest.offset[0].copy()
    place[:, 2] = 0.0
    far = np.linalg.norm(place, axis=1)
    angle = 2 * np.pi * np.arange(flown.count) / flown.count
    around = np.stack([np.cos(angle), np.sin(angle), np.zeros(flown.count)], axis=1)
    out = np.where(far[:, None] > 1e-3, place / np.maximum(far, 1e-9)[:, None], around)
    vehicles = load + out * np.maximum(far + _BESIDE, _LEAST)[:, None]
    vehicles[:, 2] = _VEHICLE_CLEARANCE - sink
    placed = flown.with_values({
        "ground.present": True,
        "ground.height": 0.0,
        "ground.vehicle_clearance": _VEHICLE_CLEARANCE,
        "ground.payload_clearance": _LOAD_CLEARANCE,
        "start.payload_position": load.tolist(),
        "start.vehicle_position": vehicles.tolist(),
        "start.rotors": "stopped",
    })  # fmt: skip
    assert isinstance(placed, SpatialScenario)
    return placed


def plant_of(flown: SpatialScenario) -> SpatialScenario:
    """The plant of a twin: standing, and what pushes it at the scenario's times of the flight.

    The plant's time begins at arming, the scenario's where the load hangs at its start; the plan
    takes about `lead_time` from the one to the other.
    """
    placed = standing(flown)
    if placed is flown:
        return flown
    load, vehicles = (placed.values["start"][key] for key in _PLACES)
    # To a tenth: a whole number of integration steps.
    lead = round(_ARMING + lead_time(flown, np.array(load), np.array(vehicles)), 1)
    later = {
        f"push[{k}].start": push["start"] + lead for k, push in enumerate(placed.values["push"])
    }
    duration = float(placed.values["simulation"]["duration"]) + lead
    moved = placed.with_values({"simulation.duration": duration, **later})
    assert isinstance(moved, SpatialScenario)
    return moved
