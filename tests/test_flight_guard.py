"""What a socket lets in: only whole, checked, new messages of the one vehicle; the rest counts."""

import random

import pytest
from flight_peer import COMPONENT, SYSTEM, UNIX, Autopilot
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift.flight.link.guard import LARGEST_DATAGRAM, REASONS, Guard, Signatures, is_for
from multilift.flight.link.signing import signature_time

KEY = bytes(range(32))


def guard(key=None):
    signatures = Signatures(key, signature_time(UNIX)) if key else None
    return Guard(SYSTEM, COMPONENT, signatures)


def taken(judge, *datagrams):
    return [m.get_type() for d in datagrams for m in judge.messages(d)]


def test_a_message_passes_once():
    judge, pilot = guard(), Autopilot()
    datagram = pilot.heartbeat()
    assert taken(judge, datagram, datagram) == ["HEARTBEAT"]
    assert judge.dropped == dict.fromkeys(REASONS, 0) | {"replayed": 1}


def test_several_messages_of_one_datagram_pass_in_order():
    judge, pilot = guard(), Autopilot()
    both = pilot.heartbeat() + pilot.says("extended_sys_state", 0, 1)
    assert taken(judge, both) == ["HEARTBEAT", "EXTENDED_SYS_STATE"]


def test_late_frames_are_dropped_and_lost_ones_are_no_reason():
    judge, pilot = guard(), Autopilot()
    frames = [pilot.heartbeat() for _ in range(200)]
    assert len(taken(judge, frames[0], frames[5], frames[3], frames[100])) == 3
    assert judge.dropped["replayed"] == 1


def test_a_vehicle_that_begins_anew_is_heard_again():
    judge = guard()
    assert len(taken(judge, *[Autopilot().heartbeat()])) == 1
    pilot = Autopilot()
    pilot.mav.seq = 40
    taken(judge, pilot.heartbeat())
    anew = Autopilot()
    heard = taken(judge, *[anew.heartbeat() for _ in range(60)])
    assert len(heard) >= 50


@pytest.mark.parametrize(("system", "component"), [(12, 1), (11, 2), (255, 1), (0, 0)])
def test_other_ids_are_aliens(system, component):
    judge = guard()
    assert not taken(judge, Autopilot(system, component).heartbeat())
    assert judge.dropped["alien"] == 1


def test_what_is_too_large_is_not_looked_at():
    judge, pilot = guard(), Autopilot()
    flood = b"".join(pilot.heartbeat() for _ in range(200))
    assert len(flood) > LARGEST_DATAGRAM
    assert not taken(judge, flood)
    assert judge.dropped["oversized"] == 1


def test_an_older_protocol_is_no_message():
    judge, pilot = guard(), Autopilot()
    pilot.mav.heartbeat_send(2, 12, 1, 0, 4, force_mavlink1=True)
    assert not taken(judge, pilot.out.written.pop())
    assert judge.dropped["malformed"] == 1


def test_with_a_key_only_its_signatures_pass():
    judge = guard(KEY)
    ours, theirs, none = (Autopilot(key=k) for k in (KEY, bytes(32), None))
    frame = ours.heartbeat()
    assert taken(judge, frame, theirs.heartbeat(), none.heartbeat()) == ["HEARTBEAT"]
    assert (judge.dropped["forged"], judge.dropped["unsigned"]) == (1, 1)
    # The very same bytes again, and an old time under a new count.
    assert not taken(judge, frame)
    ours.mav.signing.timestamp -= 5
    ours.mav.seq += 100
    assert not taken(judge, ours.heartbeat())
    assert judge.dropped["replayed"] == 2


def test_a_forged_time_of_the_far_future_locks_nobody_out():
    judge = guard(KEY)
    forger = Autopilot(key=bytes(32), unix=UNIX + 1e9)
    assert not taken(judge, forger.heartbeat())
    assert taken(judge, Autopilot(key=KEY).heartbeat()) == ["HEARTBEAT"]


def test_a_signature_of_last_week_is_a_replay():
    judge = guard(KEY)
    assert not taken(judge, Autopilot(key=KEY, unix=UNIX - 7 * 86400).heartbeat())
    assert judge.dropped["replayed"] == 1


@settings(max_examples=500, deadline=None)
@given(st.binary(max_size=400), st.booleans())
def test_whatever_comes_it_is_dropped_and_counted(data, signed):
    judge = guard(KEY if signed else None)
    assert not taken(judge, data)
    assert sum(judge.dropped.values()) == bool(data)


@settings(max_examples=500, deadline=None)
@given(st.integers(0, 10**9), st.integers(1, 4), st.booleans())
def test_a_changed_message_is_never_taken(seed, flips, signed):
    rng = random.Random(seed)
    pilot = Autopilot(key=KEY if signed else None)
    frame = bytearray(rng.choice([
        pilot.heartbeat(), pilot.says("statustext", 6, b"hello"),
        pilot.says("local_position_ned", 1, 1.0, 2.0, 3.0, 0.1, 0.2, 0.3),
    ]))  # fmt: skip
    places = rng.sample(range(8 * len(frame)), flips)
    for place in places:
        frame[place // 8] ^= 1 << place % 8
    judge = guard(KEY if signed else None)
    # Up to three flipped bits a CRC of 16 bits finds in frames this short; four may be hidden, but
    # not from a signature.
    if flips < 4 or signed:
        assert not taken(judge, bytes(frame))
        assert sum(judge.dropped.values()) >= 1


def test_a_flood_of_noise_leaves_it_as_it_was():
    rng = random.Random(1)
    judge, pilot = guard(), Autopilot()
    kept = [pilot.heartbeat() for _ in range(8)]
    for _ in range(20_000):
        chunk = bytearray(rng.choice(kept))
        for _flip in range(rng.randrange(1, 6)):
            chunk[rng.randrange(len(chunk))] = rng.randrange(256)
        cut = chunk[: rng.randrange(len(chunk) + 1)]
        list(judge.messages(bytes(cut) + rng.randbytes(rng.randrange(60))))
    fresh = Autopilot()
    fresh.mav.seq = 128
    heard = taken(judge, *[fresh.heartbeat() for _ in range(20)])
    assert len(heard) >= 10


def test_who_is_meant():
    pilot = Autopilot()
    decode = pilot.ears.decode
    for target, meant in ((255, True), (0, True), (254, False), (11, False)):
        message = decode(bytearray(pilot.says("param_set", target, 0, b"A", 1.0, 9)))
        assert is_for(message, 255, 190) == meant
    assert is_for(decode(bytearray(pilot.heartbeat())), 255, 190)
