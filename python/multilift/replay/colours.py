"""Colours of replays: tensions, vehicles, and what is drawn in neither light nor dark."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: From low tension to high: lightness rises all the way, hue from blue over purple to amber, and
#: every colour stands out from white and from black.
_STOPS = ("#2f55c4", "#7a4fc0", "#b8509f", "#e06a6c", "#f0913c", "#f2b62b")

#: Where a cable does not pull.
SLACK = "#8b949d"

#: Vehicles and their curves, after Okabe and Ito; beyond eight they begin anew.
VEHICLES = ("#1f83c9", "#d55e00", "#009e73", "#cc79a7", "#b58900", "#56b4e9", "#8b5cf6", "#7f7f7f")


def tension_colours(tension: NDArray[np.float64], low: float, high: float) -> NDArray[np.uint8]:
    """Red, green and blue, 0 to 255, shape (..., 3); outside the range its end's colour.

    Args:
        tension: N, any shape.
        low: where the range begins, N.
        high: where it ends, N.
    """
    part = np.clip((np.asarray(tension) - low) / max(high - low, 1e-300), 0.0, 1.0)
    part = np.nan_to_num(part)
    stops = np.array([rgb(colour) for colour in _STOPS], dtype=float)
    at = np.linspace(0.0, 1.0, len(stops))
    mixed = np.stack([np.interp(part, at, stops[:, k]) for k in range(3)], axis=-1)
    return np.asarray(np.rint(mixed), dtype=np.uint8)


def ramp(count: int = 33) -> list[str]:
    """The tension colours from low to high, evenly, as hexadecimal texts."""
    return [
        "#{:02x}{:02x}{:02x}".format(*c)
        for c in tension_colours(np.linspace(0.0, 1.0, count), 0.0, 1.0)
    ]


def rgb(colour: str) -> tuple[int, int, int]:
    """The parts, 0 to 255, of a colour such as "#1f83c9"."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def vehicle_colour(index: int) -> str:
    """Of a vehicle, counted from 0."""
    return VEHICLES[index % len(VEHICLES)]
