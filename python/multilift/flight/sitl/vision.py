"""Motion capture's poses on an autopilot's own MAVLink port.

ArduPilot takes them at a serial port that sends to us; the first packet says where from. It flies
by them once it has been told where on Earth they begin.
"""

from __future__ import annotations

import math
import socket
from typing import Any

from multilift.flight.sitl import geodesy, mavlink
from multilift.flight.sitl.autopilot import Pose, Sample, bound

FIRST_PORT = 14640

#: How often the origin is told again until the end, s: a firmware that starts again forgets it.
_ORIGIN_EVERY = 1.0
_MOST_BYTES = 65536
_MOST_AT_ONCE = 64


def message(dialect: Any, pose: Pose, microseconds: int) -> Any:
    """VISION_POSITION_ESTIMATE of a pose; its covariance is not known.

    The standard asks for a first entry that is no number; PX4's simulator interface reads each.
    """
    return dialect.MAVLink_vision_position_estimate_message(
        microseconds, *pose.position, *pose.euler, [math.nan] * 21
    )


class VisionPort:
    """Where one ArduPilot takes its poses."""

    def __init__(self, instance: int, *, port: int | None = None) -> None:
        """Binds port 14640 + instance, on loopback.

        Args:
            instance: of the firmware, from 0; its MAVLink system id is one more.
            port: another one; 0 for any that is free.

        Raises:
            SitlError: for a port that is taken.
            MissingExtraError: without pymavlink.
        """
        self._dialect = mavlink.dialect()
        self._mav = mavlink.parser()
        self._target = instance + 1
        self._peer: Any = None
        self._origin_at = 0.0
        chosen = FIRST_PORT + instance if port is None else port
        self._socket = bound(socket.SOCK_DGRAM, f"instance {instance}, vision", chosen)

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._socket.getsockname()[1])

    def send(self, sample: Sample) -> None:
        """Passes on a sample's pose, if it has one and the autopilot has been heard."""
        if sample.pose is None:
            return
        self._hear()
        if self._peer is None:
            return
        microseconds = round(sample.time * 1e6)
        if sample.time >= self._origin_at:
            self._origin_at = sample.time + _ORIGIN_EVERY
            home = geodesy.HOME
            self._put(
                self._dialect.MAVLink_set_gps_global_origin_message(
                    self._target, round(home.latitude * 1e7), round(home.longitude * 1e7),
                    round(home.altitude * 1e3), microseconds,
                )
            )  # fmt: skip
        self._put(message(self._dialect, sample.pose, microseconds))

    def _hear(self) -> None:
        for _ in range(_MOST_AT_ONCE):
            try:
                _, self._peer = self._socket.recvfrom(_MOST_BYTES)
            except (BlockingIOError, ConnectionRefusedError):
                return

    def _put(self, out: Any) -> None:
        try:
            self._socket.sendto(out.pack(self._mav), self._peer)
        except (BlockingIOError, ConnectionRefusedError):
            self._peer = None  # it is gone until it is heard again
        self._mav.seq = (self._mav.seq + 1) % 256

    def close(self) -> None:
        """Frees the port."""
        self._socket.close()
