"""The vehicle link against a second implementation's encoder and decoder, in memory."""

import math
import random

import numpy as np
import pytest
from flight_peer import COMPONENT, OWN, SYSTEM, Autopilot, made
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift.flight.link.clock import ClockSync
from multilift.flight.link.firmware import ARDUPILOT, BY_NAME, PX4
from multilift.flight.link.parameters import from_wire, to_wire
from multilift.flight.link.setpoint import SetPoint
from multilift.flight.link.texts import printable
from multilift.flight.link.vehicle import until_next_question
from pymavlink.dialects.v20 import common as mavlink

LEVEL = (1.0, 0.0, 0.0, 0.0)


def point(now, age=0.01, thrust=14.7, attitude=LEVEL):
    return SetPoint(attitude, thrust, now, now - age)


def test_a_set_point_on_the_wire():
    link, wire, pilot = made()
    north = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))  # nose north
    assert link.send(point(5.0, attitude=north), 5.0)
    [message] = pilot.hears(wire)
    assert message.get_type() == "SET_ATTITUDE_TARGET"
    assert (message.target_system, message.target_component) == (SYSTEM, COMPONENT)
    assert message.type_mask == 7
    assert message.q == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-7)  # NED: north is heading 0
    assert message.thrust == pytest.approx(0.5, abs=1e-7)
    assert (message.get_srcSystem(), message.time_boot_ms) == (OWN, 5000)


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (point(9.0, age=0.11), "stale"),
        (point(10.5), "from the future"),
        (point(10.0, age=-0.5), "from the future"),
        (point(10.0, thrust=math.nan), "not finite"),
        (point(10.0, attitude=(0.0, 0.0, 0.0, 0.0)), "no attitude"),
        (point(10.0, attitude=(1.0, math.inf, 0.0, 0.0)), "not finite"),
    ],
)
def test_set_points_that_are_refused(bad, reason):
    link, wire, _pilot = made()
    assert not link.send(bad, 10.0 if reason != "stale" else 9.0)
    assert link.freshness.refused == {reason: 1}
    assert not wire.sent


@settings(deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from(["new", "again"]), st.floats(0.001, 0.3), st.floats(0.0, 0.3)),
        max_size=40,
    )
)
def test_nothing_stale_and_nothing_twice_ever_goes_out(steps):
    link, wire, _pilot = made(state_age=0.1)
    now, last, sent = 1.0, None, set()
    for what, wait, age in steps:
        now += wait
        if what == "new" or last is None:
            last = point(now, age=age)
        out = link.send(last, now)
        assert len(wire.sent) == out
        wire.sent.clear()
        if out:
            assert now - last.state_time <= 0.1
            assert last.made not in sent
            sent.add(last.made)


@pytest.mark.parametrize("odometry", [False, True])
def test_a_pose_on_the_wire_is_stamped_at_capture(odometry):
    link, wire, pilot = made()
    link.send_pose((1.0, 2.0, 3.0), LEVEL, 7.25, 7.26, odometry=odometry)
    [message] = pilot.hears(wire)
    assert (message.x, message.y, message.z) == (2.0, 1.0, -3.0)
    if odometry:
        assert message.get_type() == "ODOMETRY"
        assert message.time_usec == 7_250_000
        assert message.q == pytest.approx([math.sqrt(0.5), 0, 0, math.sqrt(0.5)], abs=1e-7)
        assert math.isnan(message.vx)
    else:
        assert message.get_type() == "VISION_POSITION_ESTIMATE"
        assert message.usec == 7_250_000
        # ENU x is east: heading 90 degrees.
        assert (message.roll, message.pitch, message.yaw) == pytest.approx(
            (0.0, 0.0, math.pi / 2), abs=1e-6
        )


def test_status_from_what_it_says():
    link, wire, pilot = made()
    wire.incoming = [
        pilot.heartbeat(armed=True),
        pilot.says("sys_status", 7, 7, 5, 0, 15200, -1, 64, 0, 0, 0, 0, 0, 0),
        pilot.says("extended_sys_state", 0, mavlink.MAV_LANDED_STATE_ON_GROUND),
        pilot.says("attitude_quaternion", 900, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        pilot.says("local_position_ned", 900, 1.0, 2.0, -3.0, 0.1, 0.2, -0.3),
    ]
    link.receive(3.0)
    status = link.status
    assert (status.armed, status.landed, status.healthy) == (True, True, False)
    assert link.takes_set_points
    assert (status.voltage, status.charge) == (pytest.approx(15.2), 0.64)
    assert status.position == pytest.approx((2.0, 1.0, 3.0), abs=1e-6)
    assert status.velocity == pytest.approx((0.2, 0.1, 0.3), abs=1e-6)
    assert status.attitude == pytest.approx((math.sqrt(0.5), 0, 0, math.sqrt(0.5)))
    assert link.age(3.5) == 0.5
    assert wire.peer is not None


def test_a_stranger_does_not_become_the_peer():
    link, wire, _pilot = made()
    wire.incoming = [Autopilot(system=12).heartbeat(), b"\xfd\x00"]
    link.receive(1.0)
    assert wire.peer is None
    assert link.age(1.0) == math.inf


def test_messages_for_another_ground_station_are_not_ours():
    link, wire, pilot = made()
    command = link.arm(0.0)
    link.work(0.0)
    ack = (mavlink.MAV_CMD_COMPONENT_ARM_DISARM, mavlink.MAV_RESULT_DENIED, 0, 0)
    wire.incoming = [pilot.says("command_ack", *ack, 7, 0)]
    link.receive(0.1)
    assert command.outcome == ""
    wire.incoming = [pilot.says("command_ack", *ack, OWN, 0)]
    link.receive(0.1)
    assert command.outcome == "denied"


def run(link, wire, pilot, answer, until, start=0.0):
    """Lets time pass in steps of 10 ms; `answer` gives bytes for each message that is heard."""
    for tick in range(round((until - start) * 100) + 1):
        now = start + tick * 0.01
        link.work(now)
        for message in pilot.hears(wire):
            wire.incoming += answer(message, now) or []
        link.receive(now + 0.002)


def test_a_command_is_sent_again_until_it_is_answered():
    link, wire, pilot = made()
    command = link.arm(0.0)
    heard = []

    def answer(message, now):
        if message.get_type() != "COMMAND_LONG":
            return []
        heard.append((now, message.confirmation, message.target_system))
        lost = len(heard) < 3
        return [] if lost else [pilot.says("command_ack", message.command, 0, 0, 0, OWN, 0)]

    run(link, wire, pilot, answer, 3.0)
    assert command.accepted
    assert [confirmation for _t, confirmation, _s in heard] == [0, 1, 2]
    assert {system for _t, _c, system in heard} == {SYSTEM}


def test_a_command_without_answer_is_given_up():
    link, wire, pilot = made()
    command = link.land_mode(0.0)
    run(link, wire, pilot, lambda *_: [], 4.0)
    assert (command.outcome, command.tries) == ("no answer", 5)
    assert link.commands.under_way == 0


def test_progress_is_no_answer():
    link, wire, pilot = made()
    command = link.arm(0.0)

    def answer(message, now):
        if message.get_type() != "COMMAND_LONG":
            return []
        return [pilot.says("command_ack", message.command, mavlink.MAV_RESULT_IN_PROGRESS, 50, 0,
                           OWN, 0)]  # fmt: skip

    run(link, wire, pilot, answer, 4.0)
    assert (command.outcome, command.tries) == ("", 1)
    run(link, wire, pilot, answer, 11.0, start=4.0)
    assert command.outcome == "no answer"


@pytest.mark.parametrize("name", sorted(BY_NAME))
def test_modes_are_asked_for_as_the_firmware_wants_them(name):
    link, wire, pilot = made(BY_NAME[name])
    link.fly_mode(0.0)
    link.work(0.0)
    [message] = pilot.hears(wire, "COMMAND_LONG")
    wanted = (1.0, 6.0, 0.0) if name == "px4" else (1.0, 4.0, 0.0)
    assert (message.param1, message.param2, message.param3) == wanted
    # The heartbeat that then comes is recognised.
    custom = 6 << 16 if name == "px4" else 4
    wire.incoming = [pilot.heartbeat(mode=custom)]
    link.receive(0.1)
    assert link.takes_set_points


@pytest.mark.parametrize("firmware", [PX4, ARDUPILOT], ids=lambda f: f.name)
@pytest.mark.parametrize("may_set", [True, False])
def test_parameters_are_read_compared_and_set(firmware, may_set):
    link, wire, pilot = made(firmware, may_set=may_set)
    store = {s.name: (s.value + 1.0, 6 if s.whole else 9) for s in firmware.settings}
    store[firmware.system_parameter] = (SYSTEM, 6)
    lost = iter([True, False] * 1000)

    def answer(message, now):
        name = getattr(message, "param_id", None)
        if name is None or next(lost):
            return []
        value, kind = store[name]
        if message.get_type() == "PARAM_SET":
            assert message.param_type == kind
            value = from_wire(message.param_value, kind, firmware.bytewise)
            store[name] = value, kind
        carried = to_wire(value, kind, firmware.bytewise)
        return [pilot.says("param_value", name.encode(), carried, kind, len(store), 0)]

    assert link.parameters.problems == ["parameters were not read"]
    link.check_parameters(0.0)
    run(link, wire, pilot, answer, 40.0)
    assert link.parameters.is_done
    if may_set:
        assert not link.parameters.problems
        assert all(store[s.name][0] == pytest.approx(s.value) for s in firmware.settings)
    else:
        assert len(link.parameters.problems) == len(firmware.settings)
        assert firmware.settings[0].name in link.parameters.problems[0]


def test_parameters_without_answer_are_named():
    link, wire, pilot = made()
    link.check_parameters(0.0)
    run(link, wire, pilot, lambda *_: [], 15.0)
    assert link.parameters.is_done
    assert all("does not answer" in line for line in link.parameters.problems)


@given(st.integers(-(2**31), 2**31 - 1))
def test_whole_parameters_travel_without_loss(value):
    carried = to_wire(value, mavlink.MAV_PARAM_TYPE_INT32, True)
    # A not-a-number pattern may change on its way through a register: those are no settings.
    if not math.isnan(carried):
        assert from_wire(carried, mavlink.MAV_PARAM_TYPE_INT32, True) == value


@settings(max_examples=30, deadline=None)
@given(st.floats(-1e4, 1e4), st.floats(0.0005, 0.02), st.integers(0, 2**32))
def test_clocks_converge_to_the_offset_within_the_way(offset, way, seed):
    rng = np.random.default_rng(seed)
    clock = ClockSync()
    now = 1e5
    for _ in range(60):
        # At most 1 ms more on one of the two legs: the quickest agree within 2 ms.
        there, back = way + rng.exponential(2e-4, 2)
        clock.sees(now, now + there - offset, now + there + back)
        now += 0.1
    assert clock.is_converged
    # Half of how unequal the legs are.
    assert clock.offset == pytest.approx(offset, abs=2e-3)
    assert clock.to_theirs(now) == pytest.approx(now - offset, abs=2e-3)


def test_a_clock_that_jumps_converges_anew_and_one_that_wanders_never_does():
    clock = ClockSync()
    for k in range(40):
        clock.sees(k * 0.1, k * 0.1 - 5.0, k * 0.1 + 0.002)
    assert clock.is_converged
    for k in range(40, 46):
        clock.sees(k * 0.1, k * 0.1 - 9.0, k * 0.1 + 0.002)
    assert clock.resets == 1
    assert not clock.is_converged
    assert clock.to_theirs(5.0) is None
    for k in range(46, 200):
        clock.sees(k * 0.1, k * 0.1 - 9.0 + 0.04 * (k % 2), k * 0.1 + 0.002)
        assert not clock.is_converged or k < 60


def test_times_are_asked_for_and_given():
    link, wire, pilot = made()

    def answer(message, now):
        if message.get_type() != "TIMESYNC" or message.tc1:
            return []
        theirs = pilot.says("timesync", int((now - 100.0 + 0.001) * 1e9), message.ts1)
        forged = pilot.says("timesync", 12345, message.ts1 + 1)
        return [theirs, forged, theirs]

    run(link, wire, pilot, answer, 203.0, start=200.0)
    assert link.clock.is_converged
    assert link.clock.offset == pytest.approx(100.0, abs=1e-3)
    wire.incoming = [pilot.says("timesync", 0, 777)]
    link.receive(5.0)
    [reply] = pilot.hears(wire, "TIMESYNC")
    assert (reply.tc1, reply.ts1) == (5_000_000_000, 777)
    assert link.time_requests == 1


def test_what_it_says_in_words_is_put_together_and_safe_to_print():
    link, wire, pilot = made()
    long = "Preflight Fail: " + "x" * 70
    wire.incoming = [
        pilot.says("statustext", 4, b"\x1b[2Jboo"),
        pilot.says("statustext", 3, long[:50].encode(), 9, 0),
        pilot.says("statustext", 3, long[50:].encode(), 9, 1),
    ]
    link.receive(1.0)
    assert [(t.severity, t.text) for t in link.texts.said] == [(4, "?[2Jboo"), (3, long)]


@given(st.binary(max_size=50))
def test_no_text_holds_an_order_to_a_terminal(raw):
    assert printable(raw).isprintable()


def test_a_signed_link_speaks_and_listens_signed():
    key = bytes(range(32))
    link, wire, pilot = made(key=key)
    wire.incoming = [Autopilot().heartbeat(), pilot.heartbeat()]
    link.receive(1.0)
    assert link.guard.dropped["unsigned"] == 1
    assert link.age(1.0) == 0.0
    pilot.ears.signing.secret_key = key
    link.work(1.0)
    heard = pilot.hears(wire)
    assert heard
    assert all(m.get_signed() for m in heard)


def test_the_tap_sees_every_byte():
    seen = []
    link, wire, pilot = made(tap=lambda *args: seen.append(args))
    wire.incoming = [pilot.heartbeat(), b"noise"]
    link.receive(1.0)
    link.work(2.0)
    assert [(way, t) for way, t, _d in seen] == [("in", 1.0)] * 2 + [("out", 2.0)] * 2
    assert seen[1][2] == b"noise"


def test_a_vehicle_that_starts_anew_is_noticed():
    link, wire, pilot = made()
    wire.incoming = [pilot.says("local_position_ned", ms, *[0.0] * 6) for ms in (90_000, 90_100, 5)]
    link.receive(1.0)
    assert link.status.boots == 1


def test_cutting_the_motors_says_so():
    link, wire, pilot = made()
    link.disarm(0.0, cut=True)
    link.work(0.0)
    [message] = pilot.hears(wire, "COMMAND_LONG")
    assert (message.param1, message.param2) == (0.0, 21196.0)


@pytest.mark.parametrize("phase", [k / 40 for k in range(40)])
def test_clocks_agree_whatever_the_phase_of_the_loop_that_answers(phase):
    # Whoever answers reads its mail every 10 ms and is a little late, as on a busy machine; in step
    # with it some questions would wait for nothing and some for a whole turn.
    period, rng, sync, sent = 0.01, random.Random(7), ClockSync(), 100.0
    for asked in range(1, 61):
        arrived = sent + 0.001 + rng.uniform(0.0, 0.001)
        turn = math.ceil(arrived / period - phase) + phase
        answered = turn * period
        sync.sees(sent, answered - 5.0, answered + 0.001)
        sent += until_next_question(asked)
    assert sync.is_converged
    assert sync.offset == pytest.approx(5.0, abs=0.005)
