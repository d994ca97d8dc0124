"""Motor commands as firmwares give them.

PX4's and ArduPilot's quadrotors are numbered alike: 1 front right and 2 rear left turn
counterclockwise seen from above, 3 front left and 4 rear right clockwise (in + frames 1 right,
2 left, 3 front, 4 rear). `multilift.models.spatial.world.AUTOPILOT_MOTORS` puts them in the order
of our rotors.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from multilift.flight.sitl.autopilot import STOPPED, Motors

#: Pulse widths of a stopped motor and of full speed, us: MOT_PWM_MIN and MOT_PWM_MAX as shipped.
PWM_MIN, PWM_MAX = 1000, 2000

ROTORS = 4


def from_pwm(pwm: Sequence[int]) -> Motors:
    """The first four outputs, us, as parts of the greatest rotor speed; 0 is no pulse at all."""
    a, b, c, d = (_part((p - PWM_MIN) / (PWM_MAX - PWM_MIN)) for p in pwm[:ROTORS])
    return (a, b, c, d)


def from_controls(controls: Sequence[float], *, armed: bool) -> Motors:
    """The first four of PX4's controls; motors that do not run are told as not a number."""
    if not armed:
        return STOPPED
    a, b, c, d = (_part(u) for u in controls[:ROTORS])
    return (a, b, c, d)


def _part(u: float) -> float:
    return min(max(u, 0.0), 1.0) if math.isfinite(u) else 0.0
