"""ArduPilot's JSON back end: servo packets in, one line of JSON out, over UDP.

Instance i of ArduPilot sends its servo outputs to port 9002 + 10 i and waits for the state that
follows from them; its clock is the time in the answer. What it does not hear of it asks for again
under the same frame count, and a count that falls back to its beginning tells of a restart
(ArduPilot, libraries/SITL/examples/JSON/readme.md).
"""

from __future__ import annotations

import math
import socket
import struct
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import NamedTuple

from multilift.errors import MultiliftError
from multilift.flight.sitl import motors
from multilift.flight.sitl.autopilot import STOPPED, Sample, bound
from multilift.flight.sitl.vision import VisionPort

FIRST_PORT = 9002
PORT_STEP = 10

#: Channels by the number that a packet begins with.
CHANNELS = {18458: 16, 29569: 32}
_PACKETS = {
    struct.calcsize(f"<HHI{n}H"): (magic, struct.Struct(f"<HHI{n}H"))
    for magic, n in CHANNELS.items()
}
#: Longer than any packet, so that one too long is seen to be.
_MOST_BYTES = 128
#: The most packets taken at once, lest a flood of them holds up the others.
_MOST_AT_ONCE = 64

_LINE = (
    '\n{"timestamp":%.6f,"imu":{"gyro":[%.7f,%.7f,%.7f],"accel_body":[%.7f,%.7f,%.7f]},'
    '"position":[%.7f,%.7f,%.7f],"quaternion":[%.8f,%.8f,%.8f,%.8f],'
    '"velocity":[%.7f,%.7f,%.7f]}\n'
)


class PacketError(MultiliftError, ValueError):
    """A datagram that is no servo packet, or a state that cannot be told."""


class ServoPacket(NamedTuple):
    """What ArduPilot tells in one frame.

    Attributes:
        frame_rate: how many frames a second it wants, Hz, > 0.
        frame_count: number of the frame since its start.
        pwm: pulse width of each output, us; 16 or 32 of them.
    """

    frame_rate: int
    frame_count: int
    pwm: tuple[int, ...]


def decode(datagram: bytes) -> ServoPacket:
    """One servo packet.

    Raises:
        PacketError: for a datagram of another length, beginning or with a frame rate of 0.
    """
    kind = _PACKETS.get(len(datagram))
    if kind is None:
        raise PacketError(f"a servo packet has 40 or 72 bytes, not {len(datagram)}")
    magic, layout = kind
    begins, rate, count, *pwm = layout.unpack(datagram)
    if begins != magic:
        raise PacketError(f"a servo packet of {len(pwm)} channels begins with {magic}: {begins}")
    if rate == 0:
        raise PacketError("a servo packet with a frame rate of 0")
    return ServoPacket(rate, count, tuple(pwm))


def encode(
    time: float,
    gyro: Sequence[float],
    specific_force: Sequence[float],
    position: Sequence[float],
    quaternion: Sequence[float],
    velocity: Sequence[float],
) -> bytes:
    """The answer to a servo packet: a line of JSON that begins and ends with a new line.

    ArduPilot looks for keys by text and reads the number that follows the colon at once, so that
    there must be no space, and numbers are written without exponents.

    Args:
        time: of the physics, s.
        gyro: angular rate, FRD, rad/s.
        specific_force: acceleration less gravity, FRD, m/s^2: (0, 0, -9.81) at rest.
        position: NED, m.
        quaternion: of FRD in NED, scalar first.
        velocity: NED, m/s.

    Raises:
        PacketError: for numbers that are not finite.
    """
    numbers = (time, *gyro, *specific_force, *position, *quaternion, *velocity)
    if not all(map(math.isfinite, numbers)):
        raise PacketError(f"a state that is not finite cannot be told: {numbers}")
    return (_LINE % numbers).encode("ascii")


@dataclass
class Counts:
    """What a link met besides its packets."""

    malformed: int = 0
    alien: int = 0
    resent: int = 0
    restarts: int = 0


class ArduPilotLink:
    """One ArduPilot at the other end; see `multilift.flight.sitl.autopilot.Autopilot`."""

    free_running = False

    def __init__(
        self, index: int, *, port: int | None = None, vision: VisionPort | None = None
    ) -> None:
        """Binds the port of instance ``index``, on loopback.

        Args:
            index: of the vehicle and of ArduPilot's instance, from 0.
            port: another one; 0 for any that is free.
            vision: where motion capture's poses go.

        Raises:
            SitlError: for a port that is taken.
        """
        self.name = f"vehicle_{index + 1}"
        self.counts = Counts()
        self.motors = STOPPED
        self.period = 1.0 / 400.0
        self.answered = False
        self._vision = vision
        chosen = FIRST_PORT + PORT_STEP * index if port is None else port
        self._socket = bound(socket.SOCK_DGRAM, self.name, chosen)
        self._peer: tuple[str, int] | None = None
        self._frame = -1
        self._reply = b""

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._socket.getsockname()[1])

    @property
    def connected(self) -> bool:
        """Whether a firmware has been heard."""
        return self._peer is not None

    def fileno(self) -> int:
        """Of what tells when to `receive`."""
        return self._socket.fileno()

    def receive(self) -> None:
        """Takes what has come."""
        for _ in range(_MOST_AT_ONCE):
            try:
                datagram, sender = self._socket.recvfrom(_MOST_BYTES)
            except (BlockingIOError, ConnectionRefusedError):
                return
            try:
                packet = decode(datagram)
            except PacketError:
                self.counts.malformed += 1
                continue
            self._take(packet, sender)

    def _take(self, packet: ServoPacket, sender: tuple[str, int]) -> None:
        if sender != self._peer:
            # Only a firmware that starts again may come from elsewhere.
            if self._peer is not None and packet.frame_count > self._frame:
                self.counts.alien += 1
                return
            self.counts.restarts += self._peer is not None
            self._peer = sender
        elif packet.frame_count == self._frame:
            if not self.answered:
                self.counts.resent += 1
                self._send()
            return
        elif packet.frame_count < self._frame:
            self.counts.restarts += 1
        self._frame = packet.frame_count
        self.period = 1.0 / packet.frame_rate
        self.motors = motors.from_pwm(packet.pwm)
        self.answered = True

    def send(self, sample: Sample) -> None:
        """Answers the last packet."""
        self._reply = encode(
            sample.time,
            sample.gyro,
            sample.accel,
            sample.position,
            sample.quaternion,
            sample.velocity,
        )
        self.answered = False
        # First, so that it has come when the frame begins.
        if self._vision is not None:
            self._vision.send(sample)
        self._send()

    def _send(self) -> None:
        if self._peer is None or not self._reply:
            return
        # What is lost it asks for again.
        with suppress(BlockingIOError, ConnectionRefusedError):
            self._socket.sendto(self._reply, self._peer)

    def close(self) -> None:
        """Frees its ports."""
        self._socket.close()
        if self._vision is not None:
            self._vision.close()
