"""One vehicle at the other end of a MAVLink 2 link.

Everything takes the time as an argument, blocks nowhere and does a bounded amount of work; times
are of the caller's monotonic clock, in seconds, which the vehicle also gets its stamps in.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Any, Protocol

from pymavlink.dialects.v20 import common as mavlink

from multilift.flight.link import frames
from multilift.flight.link.clock import ClockSync
from multilift.flight.link.commands import Command, Commands
from multilift.flight.link.firmware import ARDUPILOT, Firmware, Setting
from multilift.flight.link.guard import Guard, Signatures, is_for
from multilift.flight.link.parameters import Parameters
from multilift.flight.link.setpoint import Freshness, SetPoint
from multilift.flight.link.signing import sign_with, signature_time
from multilift.flight.link.texts import Texts
from multilift.flight.link.thrust import ThrustMap
from multilift.flight.link.udp import Source

#: Body rates are ours to leave out; attitude and thrust count.
ATTITUDE_AND_THRUST = 7

#: Our component id: MAV_COMP_ID_MISSIONPLANNER is what autopilots know a ground station by.
OWN_COMPONENT = mavlink.MAV_COMP_ID_MISSIONPLANNER

#: How often a heartbeat and a time request go out, s.
_HEARTBEAT = 0.5
_TIMESYNC = 0.1
#: Multiples of it fall evenly between whole numbers, however many there are.
_GOLDEN = 0.618034

#: How many exchanges say how long the way is.
_TRIPS = 5

#: After so long without a message another source may speak for the vehicle, s.
_PEER_LAPSES = 3.0

#: Arms or disarms whatever the autopilot thinks, so that it cuts the motors in flight.
_FORCE = 21196.0

#: Where ArduPilot's estimate is to begin, which must be somewhere: 1e-7 degrees, mm.
_ORIGIN = (473977420, 85455940, 488000)

#: Unknown, in the first entry of a covariance.
_NO_COVARIANCE = (math.nan, *[0.0] * 20)

#: Called with "in" or "out", the time and the bytes of everything that passes.
Tap = Callable[[str, float, bytes], None]


class Transport(Protocol):
    """Carries datagrams; see `multilift.flight.link.udp.Udp`."""

    peer: Source | None

    def receive(self) -> Any:
        """What has come, as (data, source)."""

    def send(self, data: bytes) -> None:
        """Sends to the peer."""

    def forget_peer(self) -> None:
        """Lets another source speak."""


def until_next_question(asked: int) -> float:
    """From a question for the time to the next, s.

    Uneven, so that questions do not keep step with the loop in which they are answered: some then
    wait for nothing, and the quickest agree.

    Args:
        asked: how many there were.
    """
    return _TIMESYNC * (0.75 + 0.5 * (asked * _GOLDEN % 1.0))


@dataclass
class Status:
    """What a vehicle last said of itself; times are -inf before it said anything.

    Attributes:
        heartbeat: when its last heartbeat came, s.
        armed: whether its motors may run.
        mode: custom mode.
        failsafe: whether it says that it is in one.
        voltage: of the battery, V; nan while unknown.
        charge: of the battery, 0 to 1; nan while unknown.
        healthy: whether every sensor that it uses is well, and its pre-arm checks pass.
        landed: whether it believes to be on the ground; None while unknown.
        attitude: body FLU in world ENU.
        attitude_time: when that came, s.
        position, velocity: its own estimate, ENU, m and m/s.
        position_time: when that came, s.
        boots: how often its clock went back.
        boot_ms: its clock.
    """

    heartbeat: float = -math.inf
    armed: bool = False
    mode: int = -1
    failsafe: bool = False
    voltage: float = math.nan
    charge: float = math.nan
    healthy: bool = False
    landed: bool | None = None
    attitude: frames.Quaternion = (1.0, 0.0, 0.0, 0.0)
    attitude_time: float = -math.inf
    position: frames.Vector = (math.nan, math.nan, math.nan)
    velocity: frames.Vector = (math.nan, math.nan, math.nan)
    position_time: float = -math.inf
    boots: int = 0
    boot_ms: int = -1


@dataclass(frozen=True)
class Peer:
    """Who is at the other end, and who we are.

    Attributes:
        system, component: of the vehicle.
        own: our system id.
        firmware: of the vehicle.
        key: that signs, 32 bytes; None without.
    """

    system: int
    component: int
    own: int
    firmware: Firmware
    key: bytes | None = None


class _Out:
    """The file that pymavlink writes to."""

    def __init__(self, send: Callable[[bytes], None]) -> None:
        self.write = send


@dataclass
class VehicleLink:
    """The link to one vehicle.

    Attributes:
        peer: both ends.
        transport: carries datagrams.
        thrust: newtons to this vehicle's command.
        freshness: decides which set-points go out.
        may_set: whether wrong parameters are set.
        unix: the time of day when it begins, s, for signatures.
        tap: sees every datagram.
        status: what the vehicle last said.
        saturated: whether the last set-point's thrust was cut.
    """

    peer: Peer
    transport: Transport
    thrust: ThrustMap
    freshness: Freshness
    may_set: bool
    unix: float
    tap: Tap | None = None
    status: Status = field(default_factory=Status)
    clock: ClockSync = field(default_factory=ClockSync)
    commands: Commands = field(default_factory=Commands)
    texts: Texts = field(default_factory=Texts)
    saturated: bool = False
    time_requests: int = 0
    _trips: deque[float] = field(default_factory=lambda: deque(maxlen=_TRIPS))
    _now: float = -math.inf
    _next_heartbeat: float = -math.inf
    _next_timesync: float = -math.inf
    _questions: int = 0
    _asked: dict[int, float] = field(default_factory=dict)
    _voltage_time: float = -math.inf
    _last_message: float = -math.inf

    def __post_init__(self) -> None:
        peer = self.peer
        signatures = None
        self._mav: Any = mavlink.MAVLink(_Out(self._write), peer.own, OWN_COMPONENT)
        if peer.key is not None:
            signatures = Signatures(peer.key, signature_time(self.unix))
            sign_with(self._mav, peer.key, self.unix)
        self.guard = Guard(peer.system, peer.component, signatures)
        self.parameters = Parameters(peer.firmware, self.may_set)

    def _write(self, data: bytes) -> None:
        self.transport.send(data)
        if self.tap is not None:
            self.tap("out", self._now, data)

    def receive(self, now: float) -> None:
        """Takes in what has come."""
        self._now = now
        for data, source in self.transport.receive():
            if self.tap is not None:
                self.tap("in", now, data)
            for message in self.guard.messages(data):
                # Only who speaks as our vehicle does becomes the one we speak to.
                self._last_message = now
                if self.transport.peer is None:
                    self.transport.peer = source
                if is_for(message, self.peer.own, OWN_COMPONENT):
                    handler = _HANDLERS.get(message.get_type())
                    if handler is not None:
                        handler(self, message, now)
        if now - self._last_message > _PEER_LAPSES:
            self.transport.forget_peer()

    def work(self, now: float) -> None:
        """Sends what is due: heartbeat, time request, commands, parameters."""
        self._now = now
        if now >= self._next_heartbeat:
            self._next_heartbeat = now + _HEARTBEAT
            self._mav.heartbeat_send(
                mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE
            )
        if now >= self._next_timesync:
            self._questions += 1
            self._next_timesync = now + until_next_question(self._questions)
            sent = int(now * 1e9)
            self._asked = {k: v for k, v in self._asked.items() if now - v < 1.0}
            self._asked[sent] = now
            self._mav.timesync_send(0, sent)
        for command in self.commands.due(now):
            self._mav.command_long_send(
                self.peer.system, self.peer.component, command.number, command.tries - 1,
                *command.parameters,
            )  # fmt: skip
        for request in self.parameters.due(now):
            name = request.name.encode("ascii")
            if request.carried is None:
                self._mav.param_request_read_send(self.peer.system, self.peer.component, name, -1)
            else:
                self._mav.param_set_send(
                    self.peer.system, self.peer.component, name, request.carried, request.kind
                )

    def send(self, point: SetPoint, now: float) -> bool:
        """Sends a set-point, if it may be sent.

        Returns:
            Whether it went out; `freshness.refused` counts why not.
        """
        self._now = now
        if not self.freshness.allows(point, now):
            return False
        u, self.saturated = self.thrust.to_command(point.thrust)
        self._mav.set_attitude_target_send(
            _milliseconds(now), self.peer.system, self.peer.component, ATTITUDE_AND_THRUST,
            frames.attitude(point.attitude), 0.0, 0.0, 0.0, u,
        )  # fmt: skip
        return True

    def send_pose(
        self,
        position: Sequence[float],
        attitude: Sequence[float],
        captured: float,
        now: float,
        *,
        odometry: bool = False,
    ) -> None:
        """Sends a captured pose, world ENU and body FLU, stamped at capture."""
        self._now = now
        place, q = frames.world(position), frames.attitude(attitude)
        stamp = int(captured * 1e6)
        if odometry:
            self._mav.odometry_send(
                stamp, mavlink.MAV_FRAME_LOCAL_FRD, mavlink.MAV_FRAME_BODY_FRD, *place, q,
                *[math.nan] * 6, _NO_COVARIANCE, _NO_COVARIANCE, 0,
                mavlink.MAV_ESTIMATOR_TYPE_MOCAP, 100,
            )  # fmt: skip
        else:
            self._mav.vision_position_estimate_send(
                stamp, *place, *frames.euler(q), _NO_COVARIANCE, 0
            )

    def arm(self, now: float) -> Command:
        """Asks it to arm."""
        return self.commands.put(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, (1.0,), now)

    def disarm(self, now: float, *, cut: bool = False) -> Command:
        """Asks it to disarm; `cut` also in flight, where it falls."""
        force = (0.0, _FORCE) if cut else (0.0,)
        return self.commands.put(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, force, now)

    def fly_mode(self, now: float) -> Command:
        """Asks it to take our set-points."""
        return self._set_mode(self.peer.firmware.fly_mode, now)

    def land_mode(self, now: float) -> Command:
        """Asks it to land by itself."""
        return self._set_mode(self.peer.firmware.land_mode, now)

    def _set_mode(self, mode: int, now: float) -> Command:
        wanted = self.peer.firmware.mode_parameters(mode)
        return self.commands.put(mavlink.MAV_CMD_DO_SET_MODE, wanted, now)

    def check_parameters(self, now: float) -> None:
        """Begins to read, and where it may to set, what a flight depends on."""
        firmware = self.peer.firmware
        own_id = Setting(firmware.system_parameter, self.peer.system, True, "exact targets")
        self.parameters.require((own_id, *firmware.settings), now)

    def set_origin(self, now: float) -> None:
        """Gives ArduPilot's estimate the origin without which vision does not start it."""
        self._now = now
        if self.peer.firmware is ARDUPILOT:
            self._mav.set_gps_global_origin_send(self.peer.system, *_ORIGIN, int(now * 1e6))

    def ask_for(self, number: int, rate: float, now: float) -> Command:
        """Asks for a message at a rate, Hz."""
        return self.commands.put(
            mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, (float(number), 1e6 / rate), now
        )

    @property
    def takes_set_points(self) -> bool:
        """Whether it is in a mode that follows us."""
        return self.status.mode in self.peer.firmware.fly_modes

    @property
    def round_trip(self) -> float:
        """Median time to it and back of the last few exchanges, s; 0 before the first."""
        return median(self._trips) if self._trips else 0.0

    def age(self, now: float) -> float:
        """Time since its last heartbeat, s."""
        return now - self.status.heartbeat

    def _heartbeat(self, message: Any, now: float) -> None:
        self.status.heartbeat = now
        self.status.armed = bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
        self.status.mode = message.custom_mode
        self.status.failsafe = message.system_status in (
            mavlink.MAV_STATE_CRITICAL, mavlink.MAV_STATE_EMERGENCY,
            mavlink.MAV_STATE_FLIGHT_TERMINATION,
        )  # fmt: skip

    def _timesync(self, message: Any, now: float) -> None:
        if message.tc1 == 0:
            self.time_requests += 1
            self._mav.timesync_send(int(now * 1e9), message.ts1)
            return
        # Only answers to what we asked, each once: anyone could send others.
        sent = self._asked.pop(message.ts1, None)
        if sent is not None:
            self.clock.sees(sent, message.tc1 * 1e-9, now)
            self._trips.append(now - sent)

    def _command_ack(self, message: Any, now: float) -> None:
        self.commands.sees(message.command, message.result, now)

    def _param_value(self, message: Any, now: float) -> None:
        name = message.param_id
        text = name.decode("ascii", "replace") if isinstance(name, bytes) else name
        self.parameters.sees(text, message.param_value, message.param_type, now)

    def _statustext(self, message: Any, now: float) -> None:
        self.texts.sees(message.text, message.severity, message.id, message.chunk_seq, now)

    def _sys_status(self, message: Any, now: float) -> None:
        used = message.onboard_control_sensors_enabled
        self.status.healthy = used & ~message.onboard_control_sensors_health == 0
        if message.battery_remaining >= 0:
            self.status.charge = message.battery_remaining / 100.0
        if message.voltage_battery != 0xFFFF:
            self.status.voltage = message.voltage_battery * 1e-3
            elapsed = min(now - self._voltage_time, 10.0)
            self.thrust.sees_voltage(self.status.voltage, elapsed)
            self._voltage_time = now

    def _extended_sys_state(self, message: Any, now: float) -> None:
        known = message.landed_state != mavlink.MAV_LANDED_STATE_UNDEFINED
        on_ground = message.landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND
        self.status.landed = on_ground if known else None

    def _attitude_quaternion(self, message: Any, now: float) -> None:
        q = (message.q1, message.q2, message.q3, message.q4)
        if all(map(math.isfinite, q)):
            self.status.attitude = frames.attitude(q)
            self.status.attitude_time = now
        self._sees_boot(message.time_boot_ms)

    def _local_position_ned(self, message: Any, now: float) -> None:
        place = frames.world((message.x, message.y, message.z))
        velocity = frames.world((message.vx, message.vy, message.vz))
        if all(map(math.isfinite, (*place, *velocity))):
            self.status.position, self.status.velocity = place, velocity
            self.status.position_time = now
        self._sees_boot(message.time_boot_ms)

    def _sees_boot(self, boot_ms: int) -> None:
        if boot_ms + 1000 < self.status.boot_ms:
            self.status.boots += 1
        self.status.boot_ms = boot_ms


def _milliseconds(now: float) -> int:
    return int(now * 1e3) & 0xFFFFFFFF


_HANDLERS: dict[str, Callable[[VehicleLink, Any, float], None]] = {
    "HEARTBEAT": VehicleLink._heartbeat,
    "TIMESYNC": VehicleLink._timesync,
    "COMMAND_ACK": VehicleLink._command_ack,
    "PARAM_VALUE": VehicleLink._param_value,
    "STATUSTEXT": VehicleLink._statustext,
    "SYS_STATUS": VehicleLink._sys_status,
    "EXTENDED_SYS_STATE": VehicleLink._extended_sys_state,
    "ATTITUDE_QUATERNION": VehicleLink._attitude_quaternion,
    "LOCAL_POSITION_NED": VehicleLink._local_position_ned,
}
