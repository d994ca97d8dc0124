"""PX4's simulator interface: bytes as they stand on the wire, and the states of a link."""

import math
import select
import socket
import struct
import sys

import pytest
from multilift.errors import MissingExtraError
from multilift.flight.sitl import px4_hil
from multilift.flight.sitl.autopilot import Pose, Sample, SitlError
from multilift.flight.sitl.px4_hil import Decoder, Encoder, Px4Link
from pymavlink.dialects.v20 import common

SAMPLE = Sample(
    1.004, (0.5, -0.25, 2.0), (0.125, -1.0, -9.75), (0.25, 0.0, 0.5), 955.5, 492.0, 11.5,
    (10.0, -20.0, -3.0), (1.0, -0.5, 0.25), (1.0, 0.0, 0.0, 0.0), (0.5, -0.25, 2.0),
    Pose((1.0, 2.0, -3.0), (0.125, -0.25, 3.0)),
)  # fmt: skip

ALL = px4_hil.ACCEL | px4_hil.GYRO | px4_hil.MAG | px4_hil.BARO


def crc(data, extra):
    """The checksum of MAVLink (CRC-16/MCRF4XX) with a message's own byte behind, bit by bit."""
    value = 0xFFFF
    for byte in data + bytes([extra]):
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0x8408 if value & 1 else 0)
    return struct.pack("<H", value)


def frame(number, extra, payload, *, sequence=0, system=252):
    payload = payload.rstrip(b"\0") or b"\0"
    head = struct.pack("<BBBBBB", len(payload), 0, 0, sequence, system, 1) + number.to_bytes(
        3, "little"
    )
    return b"\xfd" + head + payload + crc(head + payload, extra)


def actuators(time, controls, mode, flags, *, sequence=0):
    """HIL_ACTUATOR_CONTROLS as the MAVLink guide lays it out: time, flags, controls, mode."""
    payload = struct.pack("<QQ16fB", time, flags, *controls, mode)
    return frame(93, 47, payload, sequence=sequence, system=1)


HEARTBEAT = frame(0, 50, struct.pack("<IBBBBB", 0, 0, 12, 0, 0, 3), system=1)
WANT_TRUTH = frame(76, 152, struct.pack("<7fHBBB", 115.0, 5000.0, 0, 0, 0, 0, 0, 511, 0, 0, 0))
CONTROLS = (0.5, 0.25, 0.125, 1.0, *[0.0] * 12)


def test_sensors_stand_on_the_wire_as_the_guide_lays_them_out():
    payload = struct.pack(
        "<Q13fI", 1004000, 0.125, -1.0, -9.75, 0.5, -0.25, 2.0, 0.25, 0.0, 0.5, 955.5, 0.0, 492.0,
        11.5, 0b1101111111111,
    )  # fmt: skip
    assert Encoder().sensor(SAMPLE, ALL) == frame(107, 108, payload)
    assert ALL == 0b1101111111111


def test_poses_and_fixes_and_truth_stand_on_the_wire_too():
    encoder = Encoder()
    nan = struct.unpack("<I", struct.pack("<f", math.nan))[0]
    pose = struct.pack("<Q6f21IB", 1004000, 1.0, 2.0, -3.0, 0.125, -0.25, 3.0, *[nan] * 21, 0)
    assert encoder.pose(SAMPLE) == frame(102, 158, pose)
    decoder = common.MAVLink(None)
    (fix,) = decoder.parse_buffer(encoder.gps(SAMPLE))
    # A minute of arc is a sea mile: 10 m north are 0.3238 s of arc.
    assert fix.lat == pytest.approx(473977420 + 10 / 1852 / 60 * 1e7, abs=10)
    assert fix.alt == 491000
    assert (fix.vn, fix.ve, fix.vd, fix.vel, fix.fix_type) == (100, -50, 25, 112, 3)
    (truth,) = decoder.parse_buffer(encoder.truth(SAMPLE))
    assert truth.attitude_quaternion == [1.0, 0.0, 0.0, 0.0]
    assert (truth.rollspeed, truth.pitchspeed, truth.yawspeed) == (0.5, -0.25, 2.0)
    assert (truth.zacc, truth.vz) == (-994, 25)


def test_commands_are_read_as_they_stand_on_the_wire():
    heard = Decoder().feed(HEARTBEAT + WANT_TRUTH + actuators(1004000, CONTROLS, 129, 1))
    assert heard.actuators == (1004000, CONTROLS, True, True)
    assert heard.wants_truth
    assert (heard.messages, heard.malformed) == (3, 0)


def test_commands_are_read_however_the_stream_is_cut():
    stream = HEARTBEAT + actuators(7, CONTROLS, 1, 1)
    for cut in range(1, len(stream)):
        decoder = Decoder()
        first, second = decoder.feed(stream[:cut]), decoder.feed(stream[cut:])
        assert first.messages + second.messages == 2
        assert second.actuators == (7, CONTROLS, False, True)


def test_rubbish_between_messages_is_counted_and_passed_over():
    decoder = Decoder()
    broken = bytearray(actuators(1, CONTROLS, 129, 1))
    broken[20] ^= 1
    heard = decoder.feed(b"rubbish" + bytes(broken) + actuators(2, CONTROLS, 129, 1))
    assert heard.actuators is not None
    assert heard.actuators.microseconds == 2
    assert heard.malformed > 0


@pytest.fixture
def link():
    made = Px4Link(0, port=0)
    yield made
    made.close()


def take(link):
    assert select.select([link], [], [], 5.0)[0]
    link.receive()


class Firmware:
    """The other end: connects and says so."""

    def __init__(self, link, hello=HEARTBEAT):
        self.wire = socket.create_connection(("127.0.0.1", link.port), 5.0)
        self.decoder = common.MAVLink(None)
        take(link)
        self.tell(link, hello)

    def tell(self, link, data):
        self.wire.sendall(data)
        take(link)

    def read(self, count):
        told = []
        while len(told) < count:
            told += self.decoder.parse_buffer(self.wire.recv(65536)) or []
        assert len(told) == count
        return told


@pytest.fixture
def firmwares(link):
    made = []

    def make(*hello):
        made.append(Firmware(link, *hello))
        return made[-1]

    yield make
    for firmware in made:
        firmware.wire.close()


def test_sensors_go_on_until_outputs_start_and_then_wait_for_them(link, firmwares):
    assert not link.connected
    firmware = firmwares()
    assert link.connected and link.free_running and not link.answered
    link.send(SAMPLE)
    pose, sensor = firmware.read(2)
    assert pose.get_type() == "VISION_POSITION_ESTIMATE"
    assert sensor.fields_updated == ALL
    assert link.free_running
    firmware.tell(link, actuators(1, CONTROLS, 129, 1))
    assert link.answered and not link.free_running
    assert link.motors == CONTROLS[:4]
    link.send(SAMPLE._replace(pose=None))
    (sensor,) = firmware.read(1)
    assert sensor.fields_updated == px4_hil.ACCEL | px4_hil.GYRO
    assert not link.answered and not link.free_running


def test_slower_sensors_tell_something_new_at_their_own_rates(link, firmwares):
    firmware = firmwares()
    for _ in range(16):
        link.send(SAMPLE._replace(pose=None))
    masks = [m.fields_updated for m in firmware.read(16)]
    assert [bool(m & px4_hil.MAG) for m in masks] == 4 * [True, False, False, False]
    assert [bool(m & px4_hil.BARO) for m in masks] == 2 * ([True] + 7 * [False])


@pytest.mark.parametrize(
    ("controls", "mode", "motors"),
    [
        ((0.5,) * 16, 1, (0.0,) * 4),
        ((math.nan, -1.0, 2.0, math.inf, *[0.0] * 12), 129, (0.0, 0.0, 1.0, 0.0)),
    ],
)
def test_motors_run_only_armed_and_within_their_range(link, firmwares, controls, mode, motors):
    firmware = firmwares()
    firmware.tell(link, actuators(1, controls, mode, 1))
    assert link.motors == motors


def test_truth_is_told_to_who_asks_for_it_and_not_faster_than_it_is_logged(link, firmwares):
    firmware = firmwares(HEARTBEAT + WANT_TRUTH)
    for k in range(10):
        link.send(SAMPLE._replace(time=1.0 + 0.004 * k, pose=None))
    kinds = [m.get_type() for m in firmware.read(12)]
    assert kinds.count("HIL_STATE_QUATERNION") == 2


def test_a_firmware_that_goes_is_forgotten_and_may_come_again(link, firmwares):
    firmware = firmwares()
    firmware.tell(link, actuators(1, CONTROLS, 129, 1))
    firmware.wire.close()
    take(link)
    assert not link.connected and not link.answered
    assert link.motors == (0.0,) * 4
    link.send(SAMPLE)  # to nobody
    firmwares()
    assert link.connected and link.free_running


def test_a_firmware_that_does_not_wait_is_refused(link, firmwares):
    firmware = firmwares()
    firmware.wire.sendall(actuators(1, CONTROLS, 129, 0))
    with pytest.raises(SitlError, match="vehicle_1: PX4 does not wait"):
        take(link)


def test_without_pymavlink_it_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymavlink.dialects.v20", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'multilift\[fly\]'"):
        Px4Link(0, port=0)


def test_it_listens_on_loopback_only_and_says_whose_port_is_taken(link):
    assert link._server.getsockname()[0] == "127.0.0.1"
    with pytest.raises(SitlError, match=f"vehicle_2: TCP port {link.port}"):
        Px4Link(1, port=link.port)
