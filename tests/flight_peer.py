"""The other end of a vehicle link, in memory: what tests let an autopilot say."""

from multilift.flight.link.firmware import PX4
from multilift.flight.link.setpoint import Freshness
from multilift.flight.link.signing import sign_with
from multilift.flight.link.thrust import ThrustMap
from multilift.flight.link.vehicle import Peer, VehicleLink
from pymavlink.dialects.v20 import common as mavlink

SYSTEM, COMPONENT, OWN = 11, 1, 255
SOURCE = ("127.0.0.1", 14580)
UNIX = 1.7e9


class Bytes:
    """The file of an encoder: keeps what it writes."""

    def __init__(self):
        self.written = []

    def write(self, data):
        self.written.append(bytes(data))


class Wire:
    """A transport that tests fill and read."""

    def __init__(self):
        self.peer = None
        self.incoming = []
        self.sent = []

    def receive(self):
        came, self.incoming = self.incoming, []
        return [(data, SOURCE) for data in came]

    def send(self, data):
        self.sent.append(data)

    def forget_peer(self):
        self.peer = None


class Autopilot:
    """Encodes what a vehicle says, decodes what it hears."""

    def __init__(self, system=SYSTEM, component=COMPONENT, key=None, unix=UNIX):
        self.out = Bytes()
        self.mav = mavlink.MAVLink(self.out, system, component)
        self.ears = mavlink.MAVLink(None)
        if key is not None:
            sign_with(self.mav, key, unix)

    def says(self, name, *fields):
        """The bytes of one message."""
        getattr(self.mav, f"{name}_send")(*fields)
        return self.out.written.pop()

    def heartbeat(self, armed=False, mode=PX4.fly_mode, state=mavlink.MAV_STATE_ACTIVE):
        base = 1 | (mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else 0)
        return self.says("heartbeat", mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_PX4, base,
                         mode, state)  # fmt: skip

    def hears(self, wire, name=None):
        """The messages on a wire since the last time, of one type where it is named."""
        data, wire.sent = b"".join(wire.sent), []
        heard = self.ears.parse_buffer(bytearray(data)) or []
        return [m for m in heard if name is None or m.get_type() == name]


def made(firmware=PX4, key=None, may_set=True, state_age=0.1, tap=None):
    """A link, its wire and the autopilot at its end."""
    wire = Wire()
    link = VehicleLink(
        Peer(SYSTEM, COMPONENT, OWN, firmware, key),
        wire,
        ThrustMap(14.7, 0.5),
        Freshness(state_age),
        may_set,
        UNIX,
        tap,
    )
    return link, wire, Autopilot(key=key)
