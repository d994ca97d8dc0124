"""PX4's simulator interface: MAVLink over TCP, at which the physics is the server.

Instance i of PX4 connects to port 4560 + i and says so by a HEARTBEAT. HIL_SENSOR then sets its
clock, and it answers each with HIL_ACTUATOR_CONTROLS once it has started its outputs; until then
sensors go on without it (PX4, src/modules/simulation/simulator_mavlink). Poses of motion capture
take the same way, so that they arrive in step.
"""

from __future__ import annotations

import socket
from typing import Any, NamedTuple

from multilift.flight.sitl import geodesy, mavlink, motors, vision
from multilift.flight.sitl.autopilot import STOPPED, Sample, SitlError, bound

FIRST_PORT = 4560

#: Between two HIL_SENSOR, s.
SENSOR_PERIOD = 0.004
#: Between two HIL_GPS, s.
GPS_PERIOD = 0.2
#: The least time between two HIL_STATE_QUATERNION, s; PX4 asks for more than its log keeps.
TRUTH_PERIOD = 0.02

#: Bits of HIL_SENSOR.fields_updated: accelerometer, gyroscope, magnetometer, barometer (pressure,
#: its altitude, temperature).
ACCEL, GYRO, MAG, BARO = 0b111, 0b111000, 0b111000000, 0b1101000000000
#: Every which HIL_SENSOR has new numbers of the slower sensors: 62.5 Hz and 31.25 Hz.
_MAG_EVERY, _BARO_EVERY = 4, 8

_ARMED = 128
_LOCKSTEP = 1
_MOST_BYTES = 65536
#: How long a firmware may leave what it is sent unread, s.
_PATIENCE = 10.0


class Actuators(NamedTuple):
    """One HIL_ACTUATOR_CONTROLS.

    Attributes:
        microseconds: PX4's time.
        controls: of 16 outputs, 0 to 1; not a number where an output is off.
        armed: whether motors may run.
        lockstep: whether PX4 waits for the physics.
    """

    microseconds: int
    controls: tuple[float, ...]
    armed: bool
    lockstep: bool


class Heard(NamedTuple):
    """What a piece of PX4's stream held."""

    actuators: Actuators | None
    wants_truth: bool
    messages: int
    malformed: int


class Decoder:
    """Reads PX4's stream; what is no message of its own is passed over and counted."""

    def __init__(self) -> None:
        self._dialect = mavlink.dialect()
        self._mav = mavlink.parser()

    def feed(self, data: bytes) -> Heard:
        """Takes the next bytes; of several actuator messages the last one counts."""
        actuators, wants_truth, good, bad = None, False, 0, 0
        for m in self._mav.parse_buffer(data) or []:
            kind = m.get_msgId()
            if kind == -1:
                bad += 1
                continue
            good += 1
            if kind == self._dialect.MAVLINK_MSG_ID_HIL_ACTUATOR_CONTROLS:
                actuators = Actuators(
                    m.time_usec, tuple(m.controls), bool(m.mode & _ARMED), bool(m.flags & _LOCKSTEP)
                )
            elif kind == self._dialect.MAVLINK_MSG_ID_COMMAND_LONG:
                wants_truth |= (
                    m.command == self._dialect.MAV_CMD_SET_MESSAGE_INTERVAL
                    and m.param1 == self._dialect.MAVLINK_MSG_ID_HIL_STATE_QUATERNION
                    and m.param2 >= 0.0
                )
        return Heard(actuators, wants_truth, good, bad)


class Encoder:
    """Writes what PX4 is told, one bytes object a message."""

    def __init__(self) -> None:
        self._dialect = mavlink.dialect()
        self._mav = mavlink.parser()

    def sensor(self, s: Sample, fields: int) -> bytes:
        """HIL_SENSOR with the sensors of ``fields``."""
        return self._pack(
            self._dialect.MAVLink_hil_sensor_message(
                _microseconds(s), *s.accel, *s.gyro, *s.mag, s.pressure, 0.0, s.pressure_altitude,
                s.temperature, fields,
            )
        )  # fmt: skip

    def gps(self, s: Sample) -> bytes:
        """HIL_GPS with a fix in three dimensions."""
        at = geodesy.place(s.position)
        north, east, down = (_short(100.0 * v) for v in s.velocity)
        speed = min(round((north * north + east * east) ** 0.5), 65535)
        return self._pack(
            self._dialect.MAVLink_hil_gps_message(
                _microseconds(s), 3, round(at.latitude * 1e7), round(at.longitude * 1e7),
                round(at.altitude * 1e3), 100, 100, speed, north, east, down, 65535, 10,
            )
        )  # fmt: skip

    def pose(self, s: Sample) -> bytes:
        """VISION_POSITION_ESTIMATE; the sample has a pose."""
        assert s.pose is not None
        return self._pack(vision.message(self._dialect, s.pose, _microseconds(s)))

    def truth(self, s: Sample) -> bytes:
        """HIL_STATE_QUATERNION, which PX4 logs beside its estimate."""
        at = geodesy.place(s.position)
        return self._pack(
            self._dialect.MAVLink_hil_state_quaternion_message(
                _microseconds(s), s.quaternion, *s.rate, round(at.latitude * 1e7),
                round(at.longitude * 1e7), round(at.altitude * 1e3),
                *(_short(100.0 * v) for v in s.velocity), 0, 0,
                *(_short(1000.0 * a / 9.80665) for a in s.accel),
            )
        )  # fmt: skip

    def _pack(self, message: Any) -> bytes:
        packed = bytes(message.pack(self._mav))
        self._mav.seq = (self._mav.seq + 1) % 256
        return packed


def _microseconds(s: Sample) -> int:
    return round(s.time * 1e6)


def _short(x: float) -> int:
    return max(-32768, min(32767, round(x)))


class Px4Link:
    """One PX4 at the other end; see `multilift.flight.sitl.autopilot.Autopilot`."""

    period = SENSOR_PERIOD

    def __init__(self, index: int, *, port: int | None = None, gps: bool = False) -> None:
        """Listens at the port of instance ``index``, on loopback.

        Args:
            index: of the vehicle and of PX4's instance, from 0.
            port: another one; 0 for any that is free.
            gps: whether to tell a satellite receiver's fixes too.

        Raises:
            SitlError: for a port that is taken.
            MissingExtraError: without pymavlink.
        """
        self.name = f"vehicle_{index + 1}"
        self.motors = STOPPED
        self.answered = False
        self.malformed = 0
        self._gps = gps
        self._encoder = Encoder()
        self._forget()
        self._connection: socket.socket | None = None
        chosen = FIRST_PORT + index if port is None else port
        self._server = bound(socket.SOCK_STREAM, self.name, chosen)
        self._server.listen(1)

    def _forget(self) -> None:
        self._decoder = Decoder()
        self._heard = self._flying = self._truth = False
        self._sent = 0
        self._gps_at = self._truth_at = 0.0
        self.motors = STOPPED

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._server.getsockname()[1])

    @property
    def connected(self) -> bool:
        """Whether PX4 has connected and said so."""
        return self._heard

    @property
    def free_running(self) -> bool:
        """Whether PX4 has not started its outputs yet."""
        return self._heard and not self._flying

    def fileno(self) -> int:
        """Of what tells when to `receive`."""
        return (self._connection or self._server).fileno()

    def receive(self) -> None:
        """Takes what has come.

        Raises:
            SitlError: for a PX4 that does not wait for the physics.
        """
        if self._connection is None:
            self._accept()
            return
        try:
            data = self._connection.recv(_MOST_BYTES, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self._hang_up()
            return
        heard = self._decoder.feed(data)
        self.malformed += heard.malformed
        self._heard = self._heard or heard.messages > 0
        self._truth = self._truth or heard.wants_truth
        if heard.actuators is not None:
            if not heard.actuators.lockstep:
                raise SitlError(
                    f"{self.name}: PX4 does not wait for the physics\n"
                    "  what to do: build it with lockstep, as px4_sitl_default is"
                )
            self.motors = motors.from_controls(
                heard.actuators.controls, armed=heard.actuators.armed
            )
            self.answered = self._flying = True

    def _accept(self) -> None:
        try:
            self._connection, _ = self._server.accept()
        except BlockingIOError:
            return
        self._connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._connection.settimeout(_PATIENCE)

    def _hang_up(self) -> None:
        """Back to where PX4 may connect anew."""
        if self._connection is not None:
            self._connection.close()
        self._connection = None
        self.answered = False
        self._forget()

    def send(self, sample: Sample) -> None:
        """Tells it a sample; sensors that are slower have nothing new in most.

        Raises:
            SitlError: for a PX4 that reads nothing any more.
        """
        self.answered = False
        if self._connection is None or not self._heard:
            return
        fields = ACCEL | GYRO
        fields |= MAG if self._sent % _MAG_EVERY == 0 else 0
        fields |= BARO if self._sent % _BARO_EVERY == 0 else 0
        self._sent += 1
        parts = []
        if sample.pose is not None:
            parts.append(self._encoder.pose(sample))
        if self._gps and sample.time >= self._gps_at:
            self._gps_at = sample.time + GPS_PERIOD
            parts.append(self._encoder.gps(sample))
        if self._truth and sample.time >= self._truth_at:
            self._truth_at = sample.time + TRUTH_PERIOD
            parts.append(self._encoder.truth(sample))
        # Last, since it sets PX4 going.
        parts.append(self._encoder.sensor(sample, fields))
        try:
            self._connection.sendall(b"".join(parts))
        except TimeoutError:
            raise SitlError(
                f"{self.name}: PX4 has read nothing for {_PATIENCE:g} s\n"
                "  what to do: look into its output"
            ) from None
        except OSError:
            self._hang_up()

    def close(self) -> None:
        """Frees the port."""
        self._hang_up()
        self._server.close()
