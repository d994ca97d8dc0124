"""Rubbish, messages with a few bytes changed, whole ones that hold rubbish: for the decoders.

``python tests/fuzz_sitl.py 5000000 1`` gives those of both physics protocols so many inputs each,
from a seed: none may raise anything but what is said, none may be taken for what it is not, and
what follows must be read again.
"""

import math
import random
import struct
import sys

from multilift.flight.sitl import ardupilot_json, motors
from multilift.flight.sitl.px4_hil import Actuators, Decoder
from pymavlink.dialects.v20 import common

SERVOS = [
    struct.pack(f"<HHI{n}H", magic, 400, 7, *range(1000, 1000 + n))
    for magic, n in ardupilot_json.CHANNELS.items()
]


def _stream():
    mav = common.MAVLink(None, 1, 1)
    return [
        bytes(m.pack(mav))
        for m in (
            common.MAVLink_hil_actuator_controls_message(1, [0.5] * 16, 129, 1),
            common.MAVLink_heartbeat_message(0, 12, 0, 0, 0, 3),
            common.MAVLink_command_long_message(0, 0, 511, 0, 115, 5000, 0, 0, 0, 0, 0),
            common.MAVLink_statustext_message(6, b"ready for take-off"),
        )
    ]


STREAM = _stream()
#: Longer than any message, so that what a broken length swallows is over.
REST = bytes(300)


KINDS = sorted(common.mavlink_map.items())


def whole(draw):
    """A message of any kind whose checksum is right and whose content is rubbish."""
    number, kind = KINDS[draw.randrange(len(KINDS))]
    payload = draw.randbytes(draw.randrange(1, 256))
    flags = draw.choice((0, 0, 0, 1, 2))
    head = struct.pack("<BBBBBB", len(payload), flags, 0, draw.randrange(256), 1, 1)
    body = head + number.to_bytes(3, "little") + payload
    check = common.x25crc(body + bytes([kind.crc_extra])).crc
    return b"\xfd" + body + struct.pack("<H", check) + draw.randbytes(13 * (flags & 1))


def spoilt(draw, seeds):
    """One input: a good one, cut, lengthened or with bytes changed; or rubbish."""
    kind = draw.randrange(5)
    if kind == 0:
        return draw.randbytes(draw.randrange(100))
    data = bytearray(draw.choice(seeds))
    if kind == 1:
        del data[draw.randrange(len(data) + 1) :]
    elif kind == 2:
        data += draw.randbytes(draw.randrange(60))
    elif kind == 3:
        at = draw.randrange(len(data))
        data[at:at] = draw.randbytes(draw.randrange(1, 4))
    else:
        for _ in range(draw.randrange(1, 6)):
            data[draw.randrange(len(data))] = draw.randrange(256)
    return bytes(data)


def servo_packet(data):
    """One input of the JSON back end's decoder."""
    try:
        told = ardupilot_json.decode(data)
    except ardupilot_json.PacketError:
        return
    assert len(data) in (40, 72)
    assert told.frame_rate > 0
    assert all(0.0 <= u <= 1.0 for u in motors.from_pwm(told.pwm))


def stream(decoder, data):
    """One input of PX4's decoder, in a stream that goes on."""
    heard = decoder.feed(data)
    if heard.actuators is not None:
        told = heard.actuators
        assert isinstance(told, Actuators)
        parts = motors.from_controls(told.controls, armed=told.armed)
        assert all(math.isfinite(u) and 0.0 <= u <= 1.0 for u in parts)


def fuzz(count, seed):
    """Gives both decoders ``count`` inputs each."""
    draw = random.Random(seed)
    decoder = Decoder()
    for k in range(count):
        servo_packet(spoilt(draw, SERVOS))
        stream(decoder, whole(draw) if k % 4 == 0 else spoilt(draw, STREAM))
        if k % 1000 == 0:
            decoder.feed(REST)
            heard = decoder.feed(STREAM[0])
            assert heard.actuators is not None, f"deaf after input {k} of seed {seed}"


if __name__ == "__main__":
    fuzz(int(sys.argv[1]), int(sys.argv[2]))
