"""What a firmware in the loop is to the physics: it answers each sample with motor commands."""

from __future__ import annotations

import socket
from typing import NamedTuple, Protocol

from multilift.errors import MultiliftError

#: Physics and firmware talk on this machine only.
LOOPBACK = "127.0.0.1"

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
#: Commands of motors 1 to 4 in the firmware's order, each the part of a rotor's greatest speed.
Motors = tuple[float, float, float, float]

STOPPED: Motors = (0.0, 0.0, 0.0, 0.0)


class SitlError(MultiliftError):
    """A firmware that cannot be started, does not answer or speaks otherwise than it should."""


class Pose(NamedTuple):
    """What motion capture says of a vehicle: place in NED, m, and roll, pitch, yaw, rad."""

    position: Vector
    euler: Vector


class Sample(NamedTuple):
    """What one vehicle's sensors tell at an instant, and how it truly moves; NED and FRD.

    Attributes:
        time: of the physics since its start, s.
        gyro: measured angular rate, rad/s.
        accel: measured acceleration less gravity, m/s^2.
        mag: measured magnetic field, gauss.
        pressure: measured, hPa.
        pressure_altitude: that goes with it in the standard atmosphere, m.
        temperature: of the air, degrees Celsius.
        position: true, m.
        velocity: true, m/s.
        quaternion: true, scalar first.
        rate: true, rad/s.
        pose: of motion capture, where one has come since the last sample.
    """

    time: float
    gyro: Vector
    accel: Vector
    mag: Vector
    pressure: float
    pressure_altitude: float
    temperature: float
    position: Vector
    velocity: Vector
    quaternion: Quaternion
    rate: Vector
    pose: Pose | None = None


class Autopilot(Protocol):
    """The link to one firmware.

    Attributes:
        name: whose it is, such as vehicle_1.
        motors: what it last commanded.
        period: how far it wants the physics to go before it is sent a sample, s.
        answered: whether commands have come since the last sample.
    """

    name: str
    motors: Motors
    period: float
    answered: bool

    @property
    def connected(self) -> bool:
        """Whether it has been heard."""
        ...

    @property
    def free_running(self) -> bool:
        """Whether it need not answer yet, because it is still starting."""
        ...

    def fileno(self) -> int:
        """Of what tells when to `receive`."""
        ...

    def receive(self) -> None:
        """Takes what has come, without waiting."""
        ...

    def send(self, sample: Sample) -> None:
        """Tells it a sample."""
        ...

    def close(self) -> None:
        """Frees its ports."""
        ...


def bound(kind: socket.SocketKind, name: str, port: int) -> socket.socket:
    """A socket at a port of loopback that never makes anyone wait; 0 for any that is free.

    Raises:
        SitlError: naming whose port is taken.
    """
    made = socket.socket(socket.AF_INET, kind)
    made.setblocking(False)
    if kind == socket.SOCK_STREAM:
        # The last simulation's connections may linger; they take nothing away.
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((LOOPBACK, port))
    except OSError as error:
        made.close()
        protocol = "TCP" if kind == socket.SOCK_STREAM else "UDP"
        raise SitlError(
            f"{name}: {protocol} port {port} cannot be had: {error.strerror}\n"
            "  what to do: end the other simulation that listens there"
        ) from None
    return made
