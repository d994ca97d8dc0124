"""ArduPilot's JSON back end: bytes as they stand on the wire, and links that meet rubbish."""

import json
import select
import socket
import struct

import pytest
from multilift.flight.sitl import ardupilot_json
from multilift.flight.sitl.ardupilot_json import ArduPilotLink, PacketError, decode, encode
from multilift.flight.sitl.autopilot import Sample, SitlError

#: 400 Hz, frame 305419896, channels 1000, 1250, 1500, 2000, 65535 and zeros, as a little-endian
#: machine lays out servo_packet_16 of ArduPilot's SIM_JSON.h.
GOLDEN_16 = bytes.fromhex("1a48 9001 78563412 e803 e204 dc05 d007 ffff" + 11 * "0000")
#: The same with servo_packet_32.
GOLDEN_32 = bytes.fromhex("8173 9001 78563412 e803 e204 dc05 d007 ffff" + 27 * "0000")

GOLDEN_REPLY = (
    b'\n{"timestamp":12.502500,"imu":{"gyro":[0.1000000,-0.2000000,0.0000001],'
    b'"accel_body":[0.0000000,0.5000000,-9.8100000]},"position":[1.0000000,-2.5000000,-3.0000000],'
    b'"quaternion":[0.70710678,0.00000000,0.00000000,0.70710678],'
    b'"velocity":[0.0000000,0.2500000,-0.1250000]}\n'
)


def sample(time=1.0, position=(1.0, 2.0, -3.0)):
    return Sample(time, (0.0,) * 3, (0.0, 0.0, -9.81), (0.2, 0.0, 0.4), 950.0, 540.0, 11.0,
                  position, (0.0,) * 3, (1.0, 0.0, 0.0, 0.0), (0.0,) * 3)  # fmt: skip


def packet(frame, pwm=1500, rate=400):
    return struct.pack("<HHI16H", 18458, rate, frame, *[pwm] * 16)


class Firmware:
    """The other end: one socket of a firmware."""

    def __init__(self, link):
        self.wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.wire.connect(("127.0.0.1", link.port))
        self.wire.settimeout(5.0)

    def tell(self, link, data):
        self.wire.send(data)
        assert select.select([link], [], [], 5.0)[0]
        link.receive()

    def read(self):
        return self.wire.recv(65536)

    def hears_nothing(self):
        self.wire.setblocking(False)
        with pytest.raises(BlockingIOError):
            self.wire.recv(65536)
        self.wire.settimeout(5.0)
        return True


@pytest.fixture
def link():
    made = ArduPilotLink(0, port=0)
    yield made
    made.close()


@pytest.fixture
def firmwares(link):
    made = []

    def make():
        made.append(Firmware(link))
        return made[-1]

    yield make
    for firmware in made:
        firmware.wire.close()


@pytest.mark.parametrize(("data", "channels"), [(GOLDEN_16, 16), (GOLDEN_32, 32)])
def test_packets_are_read_as_they_stand_on_the_wire(data, channels):
    told = decode(data)
    assert (told.frame_rate, told.frame_count) == (400, 0x12345678)
    assert told.pwm[:6] == (1000, 1250, 1500, 2000, 65535, 0)
    assert len(told.pwm) == channels


@pytest.mark.parametrize(
    "data",
    [b"", GOLDEN_16[:-1], GOLDEN_16 + b"\0", GOLDEN_32[:40], b"\0\0" + GOLDEN_16[2:],
     GOLDEN_16[:2] + b"\0\0" + GOLDEN_16[4:]],
)  # fmt: skip
def test_what_is_no_packet_is_refused(data):
    with pytest.raises(PacketError):
        decode(data)


def test_answers_stand_on_the_wire_as_the_firmware_reads_them():
    line = encode(12.5025, (0.1, -0.2, 1e-7), (0.0, 0.5, -9.81), (1.0, -2.5, -3.0),
                  (0.70710678118, 0.0, 0.0, 0.70710678118), (0.0, 0.25, -0.125))  # fmt: skip
    assert line == GOLDEN_REPLY
    assert b": " not in line
    assert json.loads(line)["imu"]["accel_body"] == [0.0, 0.5, -9.81]


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_no_answer_tells_what_is_not_finite(bad):
    with pytest.raises(PacketError):
        encode(bad, (0,) * 3, (0,) * 3, (0,) * 3, (1, 0, 0, 0), (0,) * 3)


def test_a_frame_is_answered_once_and_the_answer_again_when_it_is_asked_for_again(link, firmwares):
    firmware = firmwares()
    assert not link.connected
    firmware.tell(link, packet(0, pwm=1250, rate=500))
    assert link.connected and link.answered and not link.free_running
    assert link.motors == (0.25,) * 4
    assert link.period == 1 / 500
    firmware.tell(link, packet(0, pwm=1250, rate=500))
    assert firmware.hears_nothing()  # others are still waited for
    link.send(sample())
    first = firmware.read()
    assert not link.answered
    firmware.tell(link, packet(0))
    assert firmware.read() == first
    assert link.motors == (0.25,) * 4
    assert not link.answered
    assert link.counts.resent == 1
    firmware.tell(link, packet(1, pwm=2000))
    assert link.answered
    assert link.motors == (1.0,) * 4


def test_a_firmware_that_starts_again_is_taken_up_again(link, firmwares):
    firmware = firmwares()
    for frame in (0, 1, 2):
        firmware.tell(link, packet(frame))
        link.send(sample())
    again = firmwares()  # from another port
    again.tell(link, packet(0, pwm=1100))
    assert link.answered
    assert link.counts.restarts == 1
    link.send(sample(2.0))
    assert json.loads(again.read())["timestamp"] == 2.0


def test_others_are_counted_and_dropped(link, firmwares):
    firmware, stranger = firmwares(), firmwares()
    firmware.tell(link, packet(5))
    link.send(sample())
    firmware.read()
    stranger.tell(link, packet(6, pwm=2000))
    assert not link.answered
    for rubbish in (b"", b"rubbish", packet(6) + b"\0", bytes(5000)):
        firmware.tell(link, rubbish)
    assert (link.counts.alien, link.counts.malformed) == (1, 4)
    assert link.motors == (0.5,) * 4
    assert stranger.hears_nothing()
    firmware.tell(link, packet(6))
    assert link.answered


def test_it_listens_on_loopback_only_and_says_whose_port_is_taken(link):
    assert link._socket.getsockname()[0] == "127.0.0.1"
    with pytest.raises(SitlError, match=f"vehicle_3: UDP port {link.port}"):
        ArduPilotLink(2, port=link.port)
    assert ardupilot_json.FIRST_PORT + 3 * ardupilot_json.PORT_STEP == 9032
