"""Where on Earth the simulated hall stands, and what air and magnetic field it has.

A hall is small: the field is one vector, and the Earth is flat about home.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from multilift.flight.sitl.autopilot import Vector


class Place(NamedTuple):
    """Degrees and metres above the sea."""

    latitude: float
    longitude: float
    altitude: float


#: Home of both firmwares' simulations as we start them; PX4's own default, in Zurich.
HOME = Place(47.397742, 8.545594, 488.0)

#: The Earth's field at home, NED, gauss: 0.48 in all, dipping 63.3 degrees, 3 degrees east of
#: north; the World Magnetic Model of 2025 in two digits.
FIELD: Vector = (0.2154, 0.0113, 0.4288)

#: Mean radius of the Earth, m (IUGG).
EARTH_RADIUS = 6371008.8

#: International standard atmosphere (ISO 2533) up to 11 km.
_SEA_PRESSURE = 1013.25  # hPa
_SEA_TEMPERATURE = 288.15  # K
_LAPSE = 0.0065  # K/m
_EXPONENT = 9.80665 * 0.0289644 / (8.31447 * _LAPSE)


def place(position: Vector) -> Place:
    """Where a position in NED from home is, m."""
    north, east, down = position
    metre = math.degrees(1.0 / EARTH_RADIUS)
    return Place(
        HOME.latitude + north * metre,
        HOME.longitude + east * metre / math.cos(math.radians(HOME.latitude)),
        HOME.altitude - down,
    )


def pressure(altitude: float) -> float:
    """Of the standard atmosphere, hPa."""
    return float(_SEA_PRESSURE * (1.0 - _LAPSE * altitude / _SEA_TEMPERATURE) ** _EXPONENT)


def pressure_altitude(hectopascal: float) -> float:
    """Where the standard atmosphere has a pressure, m."""
    ratio = float((hectopascal / _SEA_PRESSURE) ** (1.0 / _EXPONENT))
    return (1.0 - ratio) * _SEA_TEMPERATURE / _LAPSE


def temperature(altitude: float) -> float:
    """Of the standard atmosphere, degrees Celsius."""
    return _SEA_TEMPERATURE - _LAPSE * altitude - 273.15
