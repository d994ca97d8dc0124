"""All firmwares and one joint model: wait for every command, step once, answer all."""

from __future__ import annotations

import select
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from multilift.flight.sitl.autopilot import Autopilot, SitlError
from multilift.flight.sitl.physics import Physics
from multilift.flight.sitl.sensors import Sensors

#: How long firmwares may be silent, s: they rest for seconds while they start.
PATIENCE = 30.0


@dataclass
class Progress:
    """How far a flight has come.

    Attributes:
        steps: how often all were answered.
        simulated: time of the physics, s.
        wall: time that it took, s.
    """

    steps: int = 0
    simulated: float = 0.0
    wall: float = 0.0

    @property
    def speed(self) -> float:
        """How much faster than real time it went."""
        return self.simulated / self.wall if self.wall > 0.0 else 0.0


class Lockstep:
    """Steps the joint model as its firmwares ask for it."""

    def __init__(
        self,
        physics: Physics,
        sensors: Sequence[Sensors],
        autopilots: Sequence[Autopilot],
        *,
        patience: float = PATIENCE,
        speed: float | None = None,
        watch: Callable[[], None] | None = None,
    ) -> None:
        """Takes what there is, one of each for a vehicle.

        Args:
            physics: the joint model.
            sensors: of each vehicle.
            autopilots: links to each vehicle's firmware.
            patience: how long a firmware may keep all others waiting, s.
            speed: not faster than so many times real time; left out, as fast as all can.
            watch: called once a second while somebody is waited for; raises if nobody will come.
        """
        self._physics, self._sensors, self._autopilots = physics, sensors, autopilots
        self._patience, self._speed, self._watch = patience, speed, watch
        self.progress = Progress()

    def connect(self) -> None:
        """Waits until every firmware has been heard.

        Raises:
            SitlError: naming those that were not.
        """
        self._wait(lambda a: not a.connected, "has not been heard")

    def run(
        self,
        duration: float = float("inf"),
        each: Callable[[Physics], bool | None] | None = None,
    ) -> Progress:
        """Flies for a time.

        Args:
            duration: of the physics, s.
            each: called after every step; the flight is over when it gives True.

        Raises:
            SitlError: naming the vehicle whose firmware does not answer, or what ended the world.
        """
        begun, since = self._physics.time, time.monotonic()
        wall, steps = self.progress.wall, self.progress.steps
        simulated = self.progress.simulated
        while self._physics.time - begun < duration:
            self._await_commands()
            self._step()
            flown = self._physics.time - begun
            if self._speed is not None:
                ahead = flown / self._speed - (time.monotonic() - since)
                if ahead > 0.0:
                    time.sleep(ahead)
            steps += 1
            self.progress = Progress(steps, simulated + flown, wall + time.monotonic() - since)
            if each is not None and each(self._physics):
                break
        return self.progress

    def _await_commands(self) -> None:
        self._wait(_holds_up, "does not answer")
        # Who is starting yet is sent samples at about the speed of its clock.
        if any(a.free_running and not a.answered for a in self._autopilots):
            self._hear(min(a.period for a in self._autopilots))

    def _step(self) -> None:
        period = min(a.period for a in self._autopilots)
        before = self._physics.time
        self._physics.advance([a.motors for a in self._autopilots], period)
        now = self._physics.time
        # All are told at once, so that firmwares work side by side.
        samples = [
            sensors.read(now, now - before, motion)
            for sensors, motion in zip(self._sensors, self._physics.motions, strict=True)
        ]
        for autopilot, sample in zip(self._autopilots, samples, strict=True):
            autopilot.send(sample)

    def _wait(self, missing: Callable[[Autopilot], bool], how: str) -> None:
        until = time.monotonic() + self._patience
        while waiting := [a for a in self._autopilots if missing(a)]:
            left = until - time.monotonic()
            if left <= 0.0:
                names = ", ".join(a.name for a in waiting)
                raise SitlError(
                    f"{names}: the firmware {how}; {self._patience:g} s waited at "
                    f"t = {self._physics.time:.3f} s\n  what to do: look into its output"
                )
            if not self._hear(min(left, 1.0)) and self._watch is not None:
                self._watch()

    def _hear(self, most: float) -> bool:
        """Takes what comes within a time; whether anything did."""
        ready, _, _ = select.select(self._autopilots, [], [], most)
        for autopilot in ready:
            autopilot.receive()
        return bool(ready)


def _holds_up(autopilot: Autopilot) -> bool:
    return not autopilot.connected or not (autopilot.answered or autopilot.free_running)
