"""What the tables of a lab must satisfy together.

Every function raises ScenarioError with file, key, value, permitted range and what to do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from multilift.errors import ScenarioError
from multilift.flight.link.address import Address
from multilift.models.spatial.scenario import SpatialScenario

#: How far the fence of a twin lies from where its scenario starts and ends, m.
_TWIN_ROOM = 3.0

#: What a set-point may be computed from must be younger than what autopilots wait for, s.
_MOST_STATE_AGE = 0.3


def check_between(value: float, low: float, high: float, where: str, key: str) -> None:
    """Refuses a number outside [low, high]."""
    if not low <= value <= high:
        raise ScenarioError("is out of range", where=where, key=key, value=value,
                            permitted=f"{low:g} to {high:g}")  # fmt: skip


def check_ids(systems: Sequence[int], own: int, where: str) -> None:
    """Every system id is one vehicle's alone, and none the ground station's."""
    for k, system in enumerate(systems):
        if system == own or system in systems[:k]:
            raise ScenarioError(
                "is taken", where=where, key=f"vehicle[{k}].system", value=system,
                permitted="an id of its own for each vehicle and for security.system",
                advice="set MAV_SYS_ID or SYSID_THISMAV of the autopilot, and this key",
            )  # fmt: skip


def check_bodies(bodies: Sequence[str], payload: str, where: str) -> None:
    """Every body of the motion capture system is one thing's alone."""
    for k, body in enumerate(bodies):
        if body == payload or body in bodies[:k]:
            raise ScenarioError(
                "is taken", where=where, key=f"vehicle[{k}].body", value=body,
                permitted="a name of its own for each vehicle and for the payload",
            )  # fmt: skip


def check_hardware(
    addresses: Sequence[Address | None], capture: Mapping[str, Any], where: str
) -> None:
    """All is real or all is a twin; no socket is used twice."""
    for k, address in enumerate(addresses):
        if (address is None) != (addresses[0] is None):
            raise ScenarioError(
                "is real for some vehicles and left out for others", where=where,
                key=f"vehicle[{k}].address",
                advice="give every vehicle an address, or none for a twin",
            )  # fmt: skip
        if address is not None and address in addresses[:k]:
            raise ScenarioError("is taken", where=where, key=f"vehicle[{k}].address",
                                permitted="an address of its own for each vehicle")  # fmt: skip
    real = addresses[0] is not None
    system, host, kind = capture["system"], capture["host"], capture["kind"]
    if real == (system == "twin"):
        raise ScenarioError(
            "is simulated, the vehicles are not" if real else "is real, the vehicles are not",
            where=where, key="motion_capture.system", value=system,
            advice="give the vehicles' addresses and the real system, or neither for a twin",
        )  # fmt: skip
    if real and not host:
        raise ScenarioError(
            "is missing", where=where, key="motion_capture.host", permitted="a name or address",
            advice="give the computer on which the motion capture server runs",
        )  # fmt: skip
    if (system == "motioncapture") != bool(kind):
        raise ScenarioError(
            "is missing" if not kind else "belongs to system = motioncapture alone", where=where,
            key="motion_capture.kind", value=kind or None,
        )  # fmt: skip


def check_open(
    addresses: Sequence[Address | None], security: Mapping[str, Any], where: str
) -> None:
    """Beyond this machine messages are signed, unless the file says otherwise."""
    if security["key_file"] or security["allow_unsigned"]:
        return
    for k, address in enumerate(addresses):
        if address is not None and not address.is_local:
            raise ScenarioError(
                "is beyond this machine and nothing signs its messages", where=where,
                key=f"vehicle[{k}].address", value=str(address),
                advice="give security.key_file, or say security.allow_unsigned = true if the "
                "network is yours alone",
            )  # fmt: skip


def check_rates(rates: Mapping[str, Any], where: str) -> None:
    """The rates are what autopilots are known to take."""
    check_between(rates["setpoints"], 50.0, 100.0, where, "rates.setpoints")
    check_between(rates["pose"], 30.0, 50.0, where, "rates.pose")


def twin_fence(limits: Mapping[str, Any], flown: SpatialScenario) -> dict[str, list[float]]:
    """The corners of a fence around a scenario where none is given."""
    places = _places(flown)
    low, high = places.min(axis=0) - _TWIN_ROOM, places.max(axis=0) + _TWIN_ROOM
    low[2] = -0.5
    return {
        "fence_low": limits["fence_low"] or low.tolist(),
        "fence_high": limits["fence_high"] or high.tolist(),
    }


def check_limits(limits: Mapping[str, Any], flown: SpatialScenario, where: str) -> None:
    """The scenario can be flown within the limits, and they can be watched."""
    for key in ("fence_low", "fence_high"):
        if limits[key] is None:
            raise ScenarioError(
                "is missing", where=where, key=f"limits.{key}", permitted="shape 3",
                advice="give the room in which the vehicles may be, metres from its origin",
            )  # fmt: skip
    places = _places(flown)
    low, high = np.array(limits["fence_low"]), np.array(limits["fence_high"])
    for key, inside in (("fence_low", places > low), ("fence_high", places < high)):
        if not inside.all():
            raise ScenarioError(
                "leaves the scenario's start or goal outside", where=where, key=f"limits.{key}",
                value=limits[key],
                permitted=f"around {places.min(axis=0).tolist()} to {places.max(axis=0).tolist()}",
            )  # fmt: skip
    offsets = flown.rest.offset[0]
    apart = np.linalg.norm(offsets[:, None] - offsets[None], axis=2)
    least = float(apart[~np.eye(len(apart), dtype=bool)].min(initial=np.inf))
    if limits["separation"] >= least:
        raise ScenarioError(
            "is more than the formation keeps", where=where, key="limits.separation",
            value=limits["separation"], permitted=f"< {least:g} m",
        )  # fmt: skip
    check_between(limits["tilt"], 0.05, 1.4, where, "limits.tilt")
    check_between(limits["swing"], 0.05, 1.5, where, "limits.swing")
    check_between(limits["state_age"], 0.0, _MOST_STATE_AGE, where, "limits.state_age")
    check_between(limits["mocap_age"], limits["state_age"], 1.0, where, "limits.mocap_age")
    check_between(limits["link_age"], 1.0, 10.0, where, "limits.link_age")
    check_between(limits["battery"], 0.0, 1.0, where, "limits.battery")


def _places(flown: SpatialScenario) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Where the vehicles and the payload start and end, shape (2 n + 2, 3), m.

    A goal below the floor, by which a law presses what has landed onto it, is reached at the floor.
    """
    start = np.array(flown.values["start"]["payload_position"])
    goal = np.array(flown.values["goal"]["payload_position"])
    offsets = flown.rest.offset[0]
    places = np.concatenate([start + offsets, goal + offsets, [start, goal]])
    ground = flown.values["ground"]
    if ground["present"]:
        places[:, 2] = np.maximum(places[:, 2], ground["height"])
    return places
