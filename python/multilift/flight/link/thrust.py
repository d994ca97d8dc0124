"""From newtons to an autopilot's normalised thrust and back, per vehicle, as its battery sags.

Thrust is ``full`` times a share that follows from the command; ``full`` falls with the square of
the battery's voltage and is estimated while the vehicle hovers alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

#: How far the estimate may go from what the lab file says; beyond, something else is wrong.
_MOST_CHANGE = 1.5

#: Below this share of the full thrust rotors idle and motion says nothing of them.
_LEAST_SHARE = 0.005

#: Of thrust with voltage: rotor speed follows voltage, thrust the square of speed.
_VOLTAGE_POWER = 2.0

#: Time constant of the voltage, s: slower than a manoeuvre, faster than a battery empties.
_VOLTAGE_SMOOTHING = 2.0


def command(share: float, curve: float) -> float:
    """The command whose thrust is a share of the full one; see `share`."""
    speed = math.sqrt(share)
    return curve * share + (1.0 - curve) * speed


def share(u: float, curve: float) -> float:
    """The share of the full thrust that a command gives.

    Flight stacks solve ``u = curve * w^2 + (1 - curve) * w`` for the rotors' signal w; thrust goes
    with its square.
    """
    straight = 1.0 - curve
    if straight == 0.0:
        return u
    # In the form that loses no digits for a small curve.
    return (2.0 * u / (straight + math.sqrt(straight**2 + 4.0 * curve * u))) ** 2


@dataclass
class ThrustMap:
    """One vehicle's thrust over command.

    Attributes:
        weight: with which hover was measured, N.
        hover: command that holds it, at `voltage`.
        curve: PX4's THR_MDL_FAC, ArduPilot's MOT_THST_EXPO.
        voltage: of the battery at that time, V; 0 where it is not compensated.
    """

    weight: float
    hover: float
    curve: float = 0.0
    voltage: float = 0.0
    _full: float = field(init=False)
    _said: float = field(init=False)
    _variance: float = field(init=False, default=0.01)
    _volts: float | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self._said = self.weight / share(self.hover, self.curve)
        self._full = self._said

    @property
    def full(self) -> float:
        """Thrust at full command now, N."""
        if not self.voltage or self._volts is None:
            return self._full
        return self._full * float((self._volts / self.voltage) ** _VOLTAGE_POWER)

    @property
    def hover_now(self) -> float:
        """Command at which the vehicle hovers alone now."""
        return command(min(self.weight / self.full, 1.0), self.curve)

    def to_command(self, newton: float) -> tuple[float, bool]:
        """The command, 0 to 1, for a thrust along the rotors, and whether a bound cut it."""
        wanted = newton / self.full
        if not wanted >= 0.0:  # nan too
            return 0.0, True
        return (1.0, True) if wanted > 1.0 else (command(wanted, self.curve), False)

    def to_newton(self, u: float) -> float:
        """The thrust that a command gives, N."""
        return self.full * share(u, self.curve)

    def sees_voltage(self, volts: float, elapsed: float) -> None:
        """Takes in the battery's voltage; numbers that no battery has are passed over.

        Args:
            volts: as measured, V.
            elapsed: since the last one, s.
        """
        if not self.voltage or not 0.5 * self.voltage < volts < 1.5 * self.voltage:
            return
        if self._volts is None:
            self._volts = volts
            return
        self._volts += (volts - self._volts) * min(elapsed / _VOLTAGE_SMOOTHING, 1.0)

    def sees_hover(self, u: float, newton: float, elapsed: float) -> None:
        """One step of a scalar Kalman filter on the full thrust, while the vehicle flies alone.

        Args:
            u: the command that acted.
            newton: thrust that the motion shows: mass times (acceleration along the rotors plus
                gravity's part), N.
            elapsed: since the last one, s.
        """
        if not (0.0 <= u <= 1.0 and math.isfinite(newton)):
            return
        part = share(u, self.curve)
        if part < _LEAST_SHARE:
            return
        # As shares of the full thrust: it drifts by 1 % in ten seconds; motion shows it to 10 %.
        self._variance += 1e-5 * elapsed
        seen = newton / (part * self.full) - 1.0
        gain = self._variance / (self._variance + 0.1**2)
        self._variance *= 1.0 - gain
        change = self._full * (1.0 + gain * max(-0.3, min(seen, 0.3)))
        self._full = min(max(change, self._said / _MOST_CHANGE), self._said * _MOST_CHANGE)
