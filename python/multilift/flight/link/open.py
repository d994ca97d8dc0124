"""The links of a lab."""

from __future__ import annotations

from multilift.flight.lab import Lab
from multilift.flight.link.firmware import BY_NAME
from multilift.flight.link.setpoint import Freshness
from multilift.flight.link.thrust import ThrustMap
from multilift.flight.link.vehicle import Peer, Tap, Transport, VehicleLink


def link_to(
    lab: Lab, k: int, transport: Transport, key: bytes | None, unix: float, tap: Tap | None = None
) -> VehicleLink:
    """The link to vehicle k of a lab, over a transport.

    Args:
        lab: which vehicles there are.
        k: which, from 0.
        transport: to it.
        key: that signs; None without.
        unix: time of day, s.
        tap: sees every datagram.
    """
    vehicle = lab.vehicles[k]
    weight = vehicle.mass * float(lab.scenario.values["plant"]["gravity"])
    return VehicleLink(
        Peer(vehicle.system, vehicle.component, int(lab.security["system"]),
             BY_NAME[vehicle.firmware], key),
        transport,
        ThrustMap(weight, vehicle.hover_thrust, vehicle.thrust_curve, vehicle.battery_voltage),
        Freshness(lab.limits.state_age),
        True,
        unix,
        tap,
    )  # fmt: skip
