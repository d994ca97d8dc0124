"""What the sensors aboard a vehicle tell: the truth with biases and noise, seeded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from multilift.flight.link import frames
from multilift.flight.sitl import geodesy
from multilift.flight.sitl.autopilot import Pose, Sample, Vector
from multilift.flight.sitl.physics import Motion, to_body


@dataclass(frozen=True)
class Noise:
    """How far sensors are off; the values of common flight controllers' parts.

    A density is that of white noise; what a sample of it has over a period is the density divided
    by the period's root. A bias is constant over a flight, drawn anew for each vehicle and axis.

    Attributes:
        gyro: density, rad/s/sqrt(Hz). 0.004 deg/s/sqrt(Hz): InvenSense ICM-20602 data sheet.
        gyro_bias: standard deviation, rad/s. What is left of 1 deg/s after a calibration at rest.
        accel: density, m/s^2/sqrt(Hz). 100 ug/sqrt(Hz): ICM-20602 data sheet.
        accel_bias: standard deviation, m/s^2. What is left of 25 mg after a calibration on six
            sides.
        mag: standard deviation of a sample, gauss. 2 mG: Honeywell HMC5883L data sheet.
        mag_bias: standard deviation, gauss; after calibration.
        pressure: standard deviation of a sample, hPa. 0.012 hPa: MEAS MS5611 data sheet.
        pressure_bias: standard deviation, hPa; a metre of height.
    """

    gyro: float = 7.0e-5
    gyro_bias: float = 1.0e-3
    accel: float = 9.8e-4
    accel_bias: float = 0.02
    mag: float = 2.0e-3
    mag_bias: float = 5.0e-3
    pressure: float = 0.012
    pressure_bias: float = 0.12


#: Sensors that tell the truth.
IDEAL = Noise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Capture:
    """How motion capture sees the vehicles.

    Attributes:
        period: between two poses, s.
        delay: from the instant it sees to the sample that tells it, s.
        position_noise: standard deviation, m.
        angle_noise: standard deviation of roll, pitch and yaw, rad.
    """

    period: float = 0.02
    delay: float = 0.01
    position_noise: float = 0.5e-3
    angle_noise: float = math.radians(0.2)


#: Sums of steps may lie this far before the instant that is meant, s.
_ROUNDING = 1e-6


class Sensors:
    """Those of one vehicle. Equal seeds, vehicles and instants give equal noise."""

    def __init__(
        self, seed: int, index: int, noise: Noise | None = None, capture: Capture | None = None
    ) -> None:
        """Draws the biases.

        Args:
            seed: of the flight.
            index: of the vehicle, from 0.
            noise: how far off; left out, as of common parts.
            capture: motion capture, if there is any.
        """
        self.noise = noise or Noise()
        self._capture = capture
        self._random = np.random.default_rng([seed, index])
        n = self.noise
        self._gyro_bias, self._accel_bias, self._mag_bias = (
            self._draw(3) * size for size in (n.gyro_bias, n.accel_bias, n.mag_bias)
        )
        self._pressure_bias = float(self._draw(1)[0] * n.pressure_bias)
        # Motion capture has a stream of its own, so that its rate changes no other noise.
        self._capture_random = np.random.default_rng([seed, index, 1])
        self._due = 0.0
        self._under_way: list[tuple[float, Pose]] = []

    def _draw(self, count: int) -> NDArray[np.float64]:
        return self._random.standard_normal(count)

    def read(self, time: float, elapsed: float, motion: Motion) -> Sample:
        """The sensors at an instant.

        Args:
            time: since the start, s.
            elapsed: since the last sample, s, > 0.
            motion: how the vehicle moves.
        """
        n = self.noise
        drawn = self._draw(10)
        root = 1.0 / math.sqrt(elapsed)
        field = to_body(motion.quaternion, geodesy.FIELD)
        altitude = geodesy.HOME.altitude - motion.position[2]
        pressure = geodesy.pressure(altitude) + self._pressure_bias + n.pressure * float(drawn[9])
        return Sample(
            time,
            _sum(motion.mean_rate, self._gyro_bias + n.gyro * root * drawn[0:3]),
            _sum(motion.mean_force, self._accel_bias + n.accel * root * drawn[3:6]),
            _sum(field, self._mag_bias + n.mag * drawn[6:9]),
            pressure,
            geodesy.pressure_altitude(pressure),
            geodesy.temperature(altitude),
            motion.position,
            motion.velocity,
            motion.quaternion,
            motion.rate,
            self._see(time, motion) if self._capture else None,
        )

    def _see(self, time: float, motion: Motion) -> Pose | None:
        """Takes a pose when one is due; gives the newest that has arrived."""
        capture = self._capture
        assert capture is not None
        now = time + _ROUNDING
        if now >= self._due:
            self._due = max(self._due + capture.period, time)
            drawn = self._capture_random.standard_normal(6)
            pose = Pose(
                _sum(motion.position, capture.position_noise * drawn[:3]),
                _sum(frames.euler(motion.quaternion), capture.angle_noise * drawn[3:]),
            )
            self._under_way.append((time + capture.delay, pose))
        arrived = None
        while self._under_way and self._under_way[0][0] <= now:
            arrived = self._under_way.pop(0)[1]
        return arrived


def _sum(truth: Vector, error: NDArray[np.float64]) -> Vector:
    a, b, c = error.tolist()
    return (truth[0] + a, truth[1] + b, truth[2] + c)
