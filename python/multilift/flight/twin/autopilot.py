"""An autopilot's outside: what PX4 or ArduPilot asks, refuses and does, on MAVLink.

The inside, attitude and rate control with the rotors, is the plant's. Every rule here is one that
real firmware enforces and that a flight program could otherwise forget: set-points come before the
mode that follows them and are lost when they stop, arming is refused until the estimate stands,
messages for others are not for it, nobody can disarm it in the air without force.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from multilift.flight.link import frames
from multilift.flight.link.firmware import PX4, Firmware
from multilift.flight.link.guard import Guard, Signatures
from multilift.flight.link.parameters import from_wire, to_wire
from multilift.flight.link.signing import sign_with, signature_time
from multilift.flight.link.vehicle import ATTITUDE_AND_THRUST, OWN_COMPONENT, Transport
from multilift.flight.twin.descent import Descent

#: How long set-points must have come, and at what least rate, before their mode is taken, s, Hz.
_STREAM_TIME = 0.5
_STREAM_GAP = 0.5

#: Without a pose for so long the estimate of position is gone, s; it stands again after as long.
_VISION_LOST = 1.0

#: Without a heartbeat for so long the ground station is gone, s.
_STATION_LOST = 5.0

#: On the ground in the landing mode for so long, it disarms, s.
_DISARM_AFTER = 1.0

_BOTH_FORCED = 21196.0

#: Commander's actions when set-points are lost, PX4's COM_OBL_RC_ACT.
_TERMINATE, _DISARM = 6, 7
_LANDS = (3, 4, 5)

#: The mode in which it starts and takes nothing: PX4 position control, ArduPilot stabilise.
_START_MODE = {"px4": 3 << 16, "ardupilot": 0}

#: A factory's values of what the flight program must set.
_FACTORY = {
    "COM_OF_LOSS_T": 1.0, "COM_OBL_RC_ACT": 0, "COM_RC_IN_MODE": 3, "COM_RCL_EXCEPT": 0,
    "NAV_DLL_ACT": 0, "COM_LOW_BAT_ACT": 3, "EKF2_EV_CTRL": 15, "EKF2_HGT_REF": 1,
    "EKF2_GPS_CTRL": 7, "GUID_OPTIONS": 0, "GUID_TIMEOUT": 3.0, "FS_GCS_ENABLE": 0,
    "FS_GCS_TIMEOUT": 5.0, "FS_EKF_ACTION": 1, "BATT_FS_LOW_ACT": 2, "VISO_TYPE": 0,
    "EK3_SRC1_POSXY": 3, "EK3_SRC1_POSZ": 1, "EK3_SRC1_YAW": 1,
}  # fmt: skip


@dataclass(frozen=True)
class Body:
    """A vehicle as the plant has it; world ENU, body FLU.

    Attributes:
        position: m.
        velocity: m/s.
        attitude: unit quaternion, scalar first.
        standing: whether it touches the ground.
    """

    position: frames.Vector
    velocity: frames.Vector
    attitude: frames.Quaternion
    standing: bool


@dataclass(frozen=True)
class Drive:
    """What the inside shall follow: an attitude, body FLU in world ENU, and normalised thrust."""

    attitude: frames.Quaternion
    thrust: float


class _Out:
    """The file that pymavlink writes to."""

    def __init__(self, send: Callable[[bytes], None]) -> None:
        self.write = send


@dataclass
class TwinAutopilot:
    """One simulated autopilot.

    Attributes:
        system: its MAVLink id.
        station: the ground station's.
        firmware: whose manners it has.
        transport: carries datagrams.
        hover: normalised thrust that it believes to hold it.
        key: signs, and every message must be signed by it; None without.
        unix: time of day at its start, for signatures, s.
        voltage: of its battery, V.
        charge: of its battery, 0 to 1.
        strength: what its battery leaves of a command's thrust.
        armed, mode: as its heartbeat says.
        parameters: by name.
        ignored: set-points for others, or of which it takes no part.
    """

    system: int
    station: int
    firmware: Firmware
    transport: Transport
    hover: float
    key: bytes | None = None
    unix: float = 0.0
    voltage: float = 15.8
    charge: float = 0.95
    strength: float = 1.0
    armed: bool = False
    mode: int = field(init=False)
    parameters: dict[str, float] = field(init=False)
    ignored: int = 0
    _wanted: tuple[frames.Quaternion, float] = ((1.0, 0.0, 0.0, 0.0), 0.0)
    _wanted_at: float = -math.inf
    _stream_since: float = math.inf
    _vision_at: float = -math.inf
    _vision_since: float = math.inf
    _station_at: float = -math.inf
    _ground_since: float = math.inf
    _origin: bool = False
    _failed: bool = False
    _descent: Descent | None = None
    _now: float = -math.inf
    _sent: dict[str, float] = field(default_factory=dict)
    _body: Body | None = None

    def __post_init__(self) -> None:
        self.mode = _START_MODE[self.firmware.name]
        self.parameters = {s.name: float(_FACTORY[s.name]) for s in self.firmware.settings}
        self.parameters[self.firmware.system_parameter] = float(self.system)
        self._whole = {s.name for s in self.firmware.settings if s.whole}
        self._whole.add(self.firmware.system_parameter)
        self._mav: Any = mavlink.MAVLink(_Out(self.transport.send), self.system, 1)
        signatures = None
        if self.key is not None:
            signatures = Signatures(self.key, signature_time(self.unix))
            sign_with(self._mav, self.key, self.unix)
        self._guard = Guard(self.station, OWN_COMPONENT, signatures)

    def step(self, body: Body, now: float) -> Drive:
        """Hears, speaks and flies for a moment.

        Args:
            body: now.
            now: its own clock, s.
        """
        elapsed = min(max(now - self._now, 0.0), 0.1)
        self._now, self._body = now, body
        for data, source in self.transport.receive():
            for message in self._guard.messages(data):
                if self.transport.peer is None:
                    self.transport.peer = source
                handler = _HANDLERS.get(message.get_type())
                if handler is not None:
                    handler(self, message)
        self._watch()
        self._speak()
        return self._drive(body, elapsed)

    @property
    def sees(self) -> bool:
        """Whether its estimate of position stands."""
        lasted = self._now - self._vision_since >= _VISION_LOST
        origin = self.firmware is PX4 or self._origin
        return lasted and origin and self._now - self._vision_at < _VISION_LOST

    @property
    def loss_time(self) -> float:
        """After how long set-points count as lost, s."""
        name = "COM_OF_LOSS_T" if self.firmware is PX4 else "GUID_TIMEOUT"
        return self.parameters[name]

    @property
    def is_streamed(self) -> bool:
        """Whether set-points come and have come for long enough."""
        fresh = self._now - self._wanted_at < min(self.loss_time, _STREAM_GAP)
        return fresh and self._now - self._stream_since >= _STREAM_TIME

    def _watch(self) -> None:
        """Failsafes and automatic disarming."""
        body = self._body
        assert body is not None
        follows = self.mode in self.firmware.fly_modes
        if self.armed and follows and self._now - self._wanted_at > self.loss_time:
            self._lose_set_points()
        dead = self._now - self._station_at > _STATION_LOST
        action = "NAV_DLL_ACT" if self.firmware is PX4 else "FS_GCS_ENABLE"
        lands = self.parameters[action] == (3.0 if self.firmware is PX4 else 5.0)
        if self.armed and dead and lands and self.mode != self.firmware.land_mode:
            self._fail_safe("ground station lost: landing")
            self._change(self.firmware.land_mode)
        resting = body.standing and abs(body.velocity[2]) < 0.1
        self._ground_since = min(self._ground_since, self._now) if resting else math.inf
        landing = self.mode == self.firmware.land_mode
        if self.armed and landing and self._now - self._ground_since > _DISARM_AFTER:
            self.armed = False
            self._say(6, "Disarmed by landing")

    def _lose_set_points(self) -> None:
        """What the firmware does when nothing tells it where to."""
        if self.firmware is not PX4:
            # Measured: it levels, holds its height and stays in its mode.
            if self._descent is None:
                self._descent = Descent(self._wanted[1] or self.hover, rate=0.0)
                self._say(4, "Guided timeout: level")
            return
        action = self.parameters["COM_OBL_RC_ACT"]
        self._fail_safe("Offboard control lost")
        if action in (_TERMINATE, _DISARM):
            self.armed = False
        # Hold and Return need a global position, which nothing gives indoors; manual modes need a
        # remote control.
        self._change(self.firmware.land_mode)

    def _fail_safe(self, text: str) -> None:
        if not self._failed:
            self._failed = True
            self._say(2, text)

    def _change(self, mode: int) -> None:
        if mode != self.mode:
            self.mode, self._descent = mode, None

    def _drive(self, body: Body, elapsed: float) -> Drive:
        if not self.armed:
            return Drive(body.attitude, 0.0)
        if self.mode in self.firmware.fly_modes and self._descent is None:
            attitude, thrust = self._wanted
        else:
            if self._descent is None:
                self._descent = Descent(max(self._wanted[1], self.hover))
            velocity = body.velocity if self.sees else None
            attitude, thrust = self._descent.step(
                body.attitude, velocity, body.velocity[2], elapsed
            )
        return Drive(attitude, min(thrust * self.strength, 1.0))

    # What it says.

    def _every(self, name: str, period: float) -> bool:
        if self._now - self._sent.get(name, -math.inf) < period:
            return False
        self._sent[name] = self._now
        return True

    def _speak(self) -> None:
        body = self._body
        assert body is not None
        boot = int(self._now * 1e3)
        if self._every("HEARTBEAT", 0.5):
            base = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
            base |= mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
            kind = mavlink.MAV_AUTOPILOT_PX4 if self.firmware is PX4 else (
                mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)  # fmt: skip
            status = mavlink.MAV_STATE_CRITICAL if self._failed else mavlink.MAV_STATE_ACTIVE
            self._mav.heartbeat_send(mavlink.MAV_TYPE_QUADROTOR, kind, base, self.mode, status)
        if self._every("SYS_STATUS", 0.5):
            self._mav.sys_status_send(
                7, 7, 7, 100, int(self.voltage * 1e3), -1, int(self.charge * 100),
                0, 0, 0, 0, 0, 0,
            )  # fmt: skip
        if self._every("EXTENDED_SYS_STATE", 0.2):
            landed = (mavlink.MAV_LANDED_STATE_ON_GROUND if body.standing
                      else mavlink.MAV_LANDED_STATE_IN_AIR)  # fmt: skip
            self._mav.extended_sys_state_send(mavlink.MAV_VTOL_STATE_UNDEFINED, landed)
        if self._every("TIMESYNC", 0.1):
            self._mav.timesync_send(0, int(self._now * 1e9))
        if self._every("ATTITUDE_QUATERNION", 0.02):
            q = frames.attitude(body.attitude)
            self._mav.attitude_quaternion_send(boot, *q, 0.0, 0.0, 0.0)
        if self.sees and self._every("LOCAL_POSITION_NED", 0.033):
            place, speed = frames.world(body.position), frames.world(body.velocity)
            self._mav.local_position_ned_send(boot, *place, *speed)

    def _say(self, severity: int, text: str) -> None:
        self._mav.statustext_send(severity, text.encode("ascii")[:50])

    # What it hears.

    def _is_mine(self, message: Any) -> bool:
        return bool(message.target_system == self.system and message.target_component == 1)

    def _hear_station(self, message: Any) -> None:
        self._station_at = self._now

    def _hear_time(self, message: Any) -> None:
        if message.tc1 == 0:
            self._mav.timesync_send(int(self._now * 1e9), message.ts1)

    def _hear_set_point(self, message: Any) -> None:
        numbers = (*message.q, message.thrust)
        whole = all(map(math.isfinite, numbers)) and abs(math.hypot(*message.q) - 1.0) < 1e-3
        taken = message.type_mask == ATTITUDE_AND_THRUST and 0.0 <= message.thrust <= 1.0
        thrust_counts = self.firmware is PX4 or int(self.parameters["GUID_OPTIONS"]) & 8
        if not (self._is_mine(message) and whole and taken and thrust_counts):
            self.ignored += 1
            return
        if self._now - self._wanted_at > _STREAM_GAP:
            self._stream_since = self._now
        self._wanted = frames.attitude(message.q), float(message.thrust)
        self._wanted_at = self._now
        if self.mode in self.firmware.fly_modes:
            self._descent = None

    def _hear_pose(self, message: Any) -> None:
        if not all(map(math.isfinite, (message.x, message.y, message.z))):
            return
        if self._now - self._vision_at > _VISION_LOST:
            self._vision_since = self._now
        self._vision_at = self._now

    def _hear_origin(self, message: Any) -> None:
        self._origin |= message.target_system == self.system

    def _hear_read(self, message: Any) -> None:
        if self._is_mine(message) and message.param_id in self.parameters:
            self._tell_parameter(message.param_id)

    def _hear_set(self, message: Any) -> None:
        name = message.param_id
        if not self._is_mine(message) or name not in self.parameters:
            return
        if message.param_type == self._kind(name):
            bytewise = self.firmware.bytewise
            value = from_wire(message.param_value, message.param_type, bytewise)
            if math.isfinite(value):
                self.parameters[name] = value
        self._tell_parameter(name)

    def _kind(self, name: str) -> int:
        whole = name in self._whole
        return int(mavlink.MAV_PARAM_TYPE_INT32 if whole else mavlink.MAV_PARAM_TYPE_REAL32)

    def _tell_parameter(self, name: str) -> None:
        kind = self._kind(name)
        carried = to_wire(self.parameters[name], kind, self.firmware.bytewise)
        number = list(self.parameters).index(name)
        self._mav.param_value_send(
            name.encode("ascii"), carried, kind, len(self.parameters), number
        )

    def _hear_command(self, message: Any) -> None:
        if not self._is_mine(message):
            return
        if message.command == mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
            refusal = self._arm(message.param1 == 1.0, message.param2 == _BOTH_FORCED)
        elif message.command == mavlink.MAV_CMD_DO_SET_MODE:
            refusal = self._take_mode(message)
        elif message.command == mavlink.MAV_CMD_NAV_LAND:
            self._change(self.firmware.land_mode)
            refusal = ""
        else:
            self._acknowledge(message.command, mavlink.MAV_RESULT_UNSUPPORTED)
            return
        if refusal:
            self._say(4, refusal)
        denied, done = mavlink.MAV_RESULT_TEMPORARILY_REJECTED, mavlink.MAV_RESULT_ACCEPTED
        self._acknowledge(message.command, denied if refusal else done)

    def _acknowledge(self, command: int, result: int) -> None:
        self._mav.command_ack_send(command, result, 0, 0, self.station, OWN_COMPONENT)

    def _arm(self, arm: bool, forced: bool) -> str:
        body = self._body
        assert body is not None
        if not arm:
            if self.armed and not body.standing and not forced:
                return "Disarming denied: not landed"
            self.armed, self._failed = False, False
            return ""
        reasons = {
            "Arming denied: position estimate": not self.sees,
            "Arming denied: mode": self.mode not in self.firmware.fly_modes,
            "Arming denied: no set-points": not self.is_streamed,
            "Arming denied: battery": self.charge < 0.15,
            "Arming denied: ground station": self._now - self._station_at > _STATION_LOST,
        }
        refusal = next((text for text, is_so in reasons.items() if is_so), "")
        self.armed |= not refusal
        return refusal

    def _take_mode(self, message: Any) -> str:
        if message.param1 % 2.0 != 1.0:  # the flag of a custom mode, the lowest one
            return "Mode denied: not custom"
        if self.firmware is PX4:
            mode = int(message.param2) << 16 | int(message.param3) << 24
        else:
            mode = int(message.param2)
        known = (*self.firmware.fly_modes, self.firmware.land_mode)
        if mode not in known:
            return "Mode denied: unknown"
        if mode in self.firmware.fly_modes:
            if self.firmware is PX4 and not self.is_streamed:
                return "Offboard denied: no set-points"
            if not self.sees:
                return "Mode denied: no position estimate"
        self._change(mode)
        return ""


_HANDLERS: dict[str, Callable[[TwinAutopilot, Any], None]] = {
    "HEARTBEAT": TwinAutopilot._hear_station,
    "TIMESYNC": TwinAutopilot._hear_time,
    "SET_ATTITUDE_TARGET": TwinAutopilot._hear_set_point,
    "VISION_POSITION_ESTIMATE": TwinAutopilot._hear_pose,
    "ODOMETRY": TwinAutopilot._hear_pose,
    "SET_GPS_GLOBAL_ORIGIN": TwinAutopilot._hear_origin,
    "PARAM_REQUEST_READ": TwinAutopilot._hear_read,
    "PARAM_SET": TwinAutopilot._hear_set,
    "COMMAND_LONG": TwinAutopilot._hear_command,
}
