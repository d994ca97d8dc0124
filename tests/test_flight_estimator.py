"""The estimator: what it says of a good stream, of every fault, and of any stream at all."""

import math
import random
from dataclasses import replace

import multilift as ml
import numpy as np
import pytest
from flight_scenes import BEGAN, BODIES, CABLES, LATENCY, RATE, Camera, times, truth
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift.flight.estimate.config import Tuning
from multilift.flight.estimate.estimator import Estimator, Verdict
from multilift.flight.estimate.scene import estimator_for
from multilift.flight.estimate.state import Fault, Quality
from multilift.flight.mocap import rotations
from multilift.flight.mocap.frames import Frame, Pose

TUNING = Tuning()
#: Within this of its first frame a fault must be seen in the quality: coasting, then a frame.
SEEN = TUNING.coast + 1 / RATE + 1e-9


def settled(camera, seconds=1.0):
    """An estimator that has seen a good stream, and when that ended."""
    estimator = Estimator(BODIES, CABLES)
    for t in times(seconds):
        assert estimator.accept(camera.frame(t)) is Verdict.NEW
    return estimator, seconds


def standings(estimator, now):
    return {name: body.standing for name, body in estimator.at(now).bodies.items()}


def fault_after(estimator, frames, names=BODIES):
    """Time from the first frame until the named bodies are SUSPECT, and what is said then.

    Meanwhile, no body may be said to be GOOD while its pose was not taken in.
    """
    start = None
    for frame in frames:
        estimator.accept(frame)
        now = frame.received_time
        start = now if start is None else start
        found = standings(estimator, now)
        if all(found[name].quality <= Quality.SUSPECT for name in names):
            return now - start, {found[name].fault for name in names}
    pytest.fail("the fault was not seen")


def assert_sound(estimate):
    """What is said to be sound is where the scene is, to 2 cm."""
    for name, body in estimate.bodies.items():
        if body.standing.quality >= Quality.COASTING:
            assert math.dist(body.position, truth(name, estimate.time)[0]) < 0.02


# A good stream.


def test_estimates_are_near_the_truth_and_near_what_they_say_of_themselves():
    camera, estimator = Camera(), Estimator(BODIES, CABLES)
    position_errors, velocity_errors, rate_errors = [], [], []
    for t in times(20.0):
        estimator.accept(camera.frame(t))
        if t < 1.0:
            continue
        now = t + LATENCY + 0.005
        estimate = estimator.at(now)
        assert estimate.standing.quality is Quality.GOOD
        assert estimate.standing.age == pytest.approx(LATENCY + 0.005)
        for name, body in estimate.bodies.items():
            position, velocity, _, rate = truth(name, now)
            position_errors.append(math.dist(body.position, position) / body.position_sigma)
            velocity_errors.append(math.dist(body.velocity, velocity) / body.velocity_sigma)
            rate_errors.append(math.dist(body.rate, rate))

    def rms(errors):
        return math.sqrt(sum(e * e for e in errors) / len(errors))

    # three components; the scene is gentler than what the filter allows for
    assert rms(position_errors) < math.sqrt(3)
    assert rms(velocity_errors) < math.sqrt(3)
    chain_sigma = 0.6  # of the rate: sigma of attitude, 5 mrad, over the filter's 10 ms to 50 ms
    assert rms(rate_errors) < chain_sigma


def test_cables_are_what_geometry_says():
    camera, (estimator, end) = Camera(position_noise=1e-6, attitude_noise=1e-6), (None, None)
    estimator, end = settled(camera, 3.0)
    now = end - 1 / RATE + LATENCY
    for cable, state in zip(CABLES, estimator.at(now).cables, strict=True):

        def ends(t, cable=cable):
            top, low = truth(cable.vehicle, t), truth(cable.payload, t)
            arm = rotations.turned(low[2], cable.payload_point)
            return [p - q - a for p, q, a in zip(top[0], low[0], arm, strict=True)]

        def direction(t, ends=ends):
            return [x / math.hypot(*ends(t)) for x in ends(t)]

        h = 1e-4
        slope = [
            (b - a) / (2 * h) for a, b in zip(direction(now - h), direction(now + h), strict=True)
        ]
        # what noise and the scene's jerk leave: 1 mm and 2 cm/s over a metre
        assert state.direction == pytest.approx(direction(now), abs=1e-3)
        assert state.direction_rate == pytest.approx(slope, abs=2e-2)
        assert state.distance == pytest.approx(math.hypot(*ends(now)), abs=1e-3)
        assert state.swing == pytest.approx(math.acos(state.direction[2]))
        assert math.tan(state.swing_along) == pytest.approx(state.direction[0] / state.direction[2])
        dot = sum(a * b for a, b in zip(state.direction, state.direction_rate, strict=True))
        assert dot == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_no_alarm_in_ten_minutes_of_noise_and_jitter(seed):
    camera, estimator = Camera(seed, 5e-4, 5e-3), Estimator(BODIES, CABLES)
    rng = random.Random(seed)
    last = 0.0
    for t in times(200.0):
        late = LATENCY + rng.expovariate(1 / 2e-3)
        last = max(last, t + min(late, 0.02))
        frame = replace(camera.frame(t), received_time=last)
        if rng.random() < 0.05:
            continue  # lost on the way
        assert estimator.accept(frame) is Verdict.NEW
        if t > 1.0:
            assert estimator.at(last).standing.quality is Quality.GOOD


def test_drifting_clocks_are_followed():
    camera, estimator = Camera(), Estimator(BODIES, CABLES)
    for t in times(60.0):
        frame = camera.frame(t)
        estimator.accept(replace(frame, capture_time=frame.capture_time * (1 - 1e-4)))
    age = estimator.at(t + LATENCY).standing.age
    assert age == pytest.approx(LATENCY, abs=1e-4)


def test_a_source_without_capture_times_has_those_of_arrival():
    camera, estimator = Camera(), Estimator(BODIES, CABLES)
    for t in times(2.0):
        estimator.accept(replace(camera.frame(t), number=None, capture_time=None))
    estimate = estimator.at(t + LATENCY)
    assert estimate.standing.quality is Quality.GOOD
    assert estimate.standing.age == pytest.approx(LATENCY)
    for name, body in estimate.bodies.items():
        assert math.dist(body.position, truth(name, t + LATENCY)[0]) < 2e-3


def test_a_scenario_says_which_bodies_there_are():
    scenario = ml.load("uneven_four")
    estimator, rng = estimator_for(scenario), np.random.default_rng(1)
    names = [f"vehicle_{k + 1}" for k in range(scenario.count)]
    seen = dict(zip(names, scenario.vehicle_start[:, :3], strict=True))
    seen["payload"] = scenario.payload_start[:3]
    for t in times(1.0):
        bodies = {name: Pose(tuple(p + rng.normal(0.0, 1e-5, 3))) for name, p in seen.items()}
        estimator.accept(Frame(None, t, t, bodies))
    estimate = estimator.at(t)
    assert set(estimate.bodies) == {*names, "payload"}
    # at the start the scenario's cables are as long as they are
    distances = [cable.distance for cable in estimate.cables]
    assert distances == pytest.approx(scenario.values["plant"]["cable_length"], abs=1e-4)


def test_before_the_first_frame_nothing_is_known():
    estimator = Estimator(BODIES, CABLES)
    for quality, t in ((Quality.NONE, 0.0), (Quality.CONVERGING, 0.1)):
        estimate = estimator.at(t + LATENCY)
        assert estimate.standing.quality is quality
        assert all(c.standing.quality is quality for c in estimate.cables)
        estimator.accept(Camera().frame(0.1))


# Order.


def test_old_and_repeated_frames_change_nothing():
    camera = Camera()
    estimator, end = settled(camera)
    frame, newer = camera.frame(end), camera.frame(end + 0.01)
    estimator.accept(newer)
    now = newer.received_time
    before = estimator.at(now).bodies
    late = replace(frame, received_time=now)
    assert estimator.accept(late) is Verdict.LATE
    assert estimator.accept(newer) is Verdict.DUPLICATE
    after = estimator.at(now).bodies
    for name in BODIES:
        assert after[name].position == before[name].position
        assert after[name].standing.age == before[name].standing.age
        assert after[name].standing.quality < Quality.GOOD


# Faults.


def test_silence():
    estimator, end = settled(Camera())
    last = end - 1 / RATE
    for since in (0.02, 0.051, 0.2):
        for standing in standings(estimator, last + since).values():
            assert standing.age == pytest.approx(since)
            if since > TUNING.lost:
                assert (standing.quality, standing.fault) == (Quality.LOST, Fault.SILENT)
                assert not standing.usable
            elif since > TUNING.coast:
                assert standing.quality is Quality.SUSPECT
            else:
                assert standing.quality is Quality.GOOD


def test_extrapolation_ends():
    estimator, end = settled(Camera())
    far = [estimator.at(end + wait).bodies for wait in (1.0, 1e6)]
    for name in BODIES:
        assert far[0][name].position == far[1][name].position
        assert far[0][name].position_sigma == far[1][name].position_sigma


@pytest.mark.parametrize("stamped", [True, False], ids=["new stamps", "old stamps"])
def test_a_frozen_stream(stamped):
    camera = Camera()
    estimator, end = settled(camera)
    still = camera.frame(end)
    estimator.accept(still)
    frames = [
        replace(
            still,
            received_time=t + LATENCY,
            capture_time=BEGAN + t if stamped else still.capture_time,
        )
        for t in times(1.0, end + 1 / RATE)
    ]
    after, faults = fault_after(estimator, frames)
    assert after <= SEEN
    assert faults == {Fault.FROZEN}


def test_one_frozen_body_among_moving_ones():
    camera = Camera()
    estimator, end = settled(camera)
    pose = camera.pose("payload", end)
    frames = []
    for t in times(0.5, end):
        frame = camera.frame(t)
        frames.append(replace(frame, bodies={**frame.bodies, "payload": pose}))
    after, faults = fault_after(estimator, frames, ["payload"])
    assert after <= SEEN
    assert faults == {Fault.FROZEN}
    assert standings(estimator, frames[5].received_time)["vehicle_1"].quality >= Quality.GOOD


@pytest.mark.parametrize("pose", [None, Pose((math.nan, 0.0, 0.0)), Pose((1e300, 0.0, 0.0))])
def test_a_dropped_body(pose):
    camera = Camera()
    estimator, end = settled(camera)
    frames = []
    for t in times(1.0, end):
        frame = camera.frame(t)
        bodies = {n: p for n, p in frame.bodies.items() if n != "vehicle_2"}
        frames.append(
            replace(frame, bodies=bodies if pose is None else {**bodies, "vehicle_2": pose})
        )
    after, faults = fault_after(estimator, frames, ["vehicle_2"])
    assert after <= SEEN
    assert faults == {Fault.DROPPED}
    for frame in frames:
        estimator.accept(frame)
    found = standings(estimator, frames[-1].received_time)
    assert found["vehicle_2"].quality is Quality.LOST
    assert found["vehicle_2"].since == pytest.approx(end + LATENCY)
    assert found["vehicle_1"].quality is Quality.GOOD


@pytest.mark.parametrize("axis", range(3))
def test_a_jump_is_not_believed_until_it_lasts(axis):
    camera = Camera()
    estimator, end = settled(camera)
    by = [0.0, 0.0, 0.0]
    by[axis] = 0.4

    def moved(t):
        frame = camera.frame(t)
        pose = frame.bodies["payload"]
        there = tuple(p + d for p, d in zip(pose.position, by, strict=True))
        return replace(frame, bodies={**frame.bodies, "payload": replace(pose, position=there)})

    after, faults = fault_after(estimator, [moved(t) for t in times(0.1, end)], ["payload"])
    assert after <= SEEN
    assert faults == {Fault.JUMP}
    here = estimator.at(end + SEEN).bodies["payload"].position
    assert math.dist(here, truth("payload", end + SEEN)[0]) < 0.02
    for t in times(TUNING.rebirth + 0.05, end + 0.1):
        estimator.accept(moved(t))
    body = estimator.at(t + LATENCY).bodies["payload"]
    assert body.standing.quality is Quality.GOOD
    position, velocity, _, _ = truth("payload", t + LATENCY)
    assert math.dist([p + d for p, d in zip(position, by, strict=True)], body.position) < 2e-3
    assert math.dist(velocity, body.velocity) < 4 * body.velocity_sigma


def test_a_body_that_is_turned_over_at_its_place():
    camera = Camera()
    estimator, end = settled(camera)
    frames = []
    for t in times(0.1, end):
        frame = camera.frame(t)
        pose = frame.bodies["vehicle_1"]
        turned = rotations.product(pose.attitude, (0.0, 0.0, 0.0, 1.0))
        frames.append(
            replace(frame, bodies={**frame.bodies, "vehicle_1": replace(pose, attitude=turned)})
        )
    after, faults = fault_after(estimator, frames, ["vehicle_1"])
    assert after <= SEEN
    assert faults == {Fault.JUMP}


def test_single_outliers_cost_no_more_than_their_own_frame():
    camera = Camera()
    estimator, end = settled(camera)
    for k, t in enumerate(times(2.0, end)):
        frame = camera.frame(t)
        if k % 5 == 0:
            wrong = Pose(camera.vector(3.0), rotations.from_vector(camera.vector(1.0)))
            frame = replace(frame, bodies={**frame.bodies, "vehicle_1": wrong})
        estimator.accept(frame)
        found = standings(estimator, frame.received_time)["vehicle_1"]
        expected = (Quality.COASTING, Fault.JUMP) if k % 5 == 0 else (Quality.GOOD, Fault.NONE)
        assert (found.quality, found.fault) == expected


@pytest.mark.parametrize(
    "order",
    [("vehicle_2", "vehicle_1", "payload"), ("vehicle_2", "payload", "vehicle_1")],
    ids=["two", "three in a ring"],
)
def test_swapped_bodies_are_put_right_and_told(order):
    camera = Camera()
    estimator, end = settled(camera)
    wrong = {a for a, b in zip(BODIES, order, strict=True) if a != b}
    for t in times(2.0, end):
        frame = camera.frame(t)
        bodies = {a: frame.bodies[b] for a, b in zip(BODIES, order, strict=True)}
        estimator.accept(replace(frame, bodies=bodies))
        for name, body in estimator.at(t + LATENCY).bodies.items():
            assert math.dist(body.position, truth(name, t + LATENCY)[0]) < 3e-3
            expected = Fault.SWAPPED if name in wrong else Fault.NONE
            assert body.standing.fault is expected
            assert (body.standing.quality is Quality.SUSPECT) == (name in wrong)
    estimator.accept(camera.frame(end + 2.0))
    assert estimator.at(end + 2.0 + LATENCY).standing.quality is Quality.GOOD


def test_a_body_under_the_name_of_one_that_is_hidden():
    camera = Camera()
    estimator, end = settled(camera)
    for t in times(0.3, end):
        frame = camera.frame(t)
        bodies = {"vehicle_1": frame.bodies["vehicle_2"], "payload": frame.bodies["payload"]}
        estimator.accept(replace(frame, bodies=bodies))
    estimate = estimator.at(t + LATENCY)
    assert math.dist(estimate.bodies["vehicle_2"].position, truth("vehicle_2", t)[0]) < 0.01
    assert estimate.bodies["vehicle_2"].standing.fault is Fault.SWAPPED
    assert estimate.bodies["vehicle_1"].standing.quality is Quality.LOST


def test_bodies_that_come_back_under_one_anothers_names_are_not_believed():
    camera = Camera()
    estimator, end = settled(camera)
    other = {"vehicle_1": "vehicle_2", "vehicle_2": "vehicle_1", "payload": "payload"}
    for t in times(2.0, end + 1.0):
        frame = camera.frame(t)
        bodies = {name: frame.bodies[other[name]] for name in BODIES}
        estimator.accept(replace(frame, bodies=bodies))
        assert_sound(estimator.at(t + LATENCY))
    found = standings(estimator, t + LATENCY)
    assert found["vehicle_1"].fault is found["vehicle_2"].fault is Fault.SWAPPED
    assert found["payload"].quality is Quality.GOOD
    for t in times(1.0, end + 3.0):
        estimator.accept(camera.frame(t))
    estimate = estimator.at(t + LATENCY)
    assert estimate.standing.quality is Quality.GOOD
    assert_sound(estimate)


def test_bodies_that_were_carried_about_are_where_they_are_seen_after_forgetting():
    camera = Camera()
    estimator, end = settled(camera)
    estimator.forget()
    other = {"vehicle_1": "vehicle_2", "vehicle_2": "vehicle_1", "payload": "payload"}
    for t in times(1.0, end):
        frame = camera.frame(t)
        estimator.accept(
            replace(frame, bodies={name: frame.bodies[other[name]] for name in BODIES})
        )
    assert estimator.at(t + LATENCY).standing.quality is Quality.GOOD


@pytest.mark.parametrize("by", [-900.0, -0.2, 0.2, 3600.0])
def test_a_capture_clock_that_jumps_is_told_and_then_followed(by):
    camera = Camera()
    estimator, end = settled(camera)

    def jumped(t):
        frame = camera.frame(t)
        return replace(frame, capture_time=frame.capture_time + by)

    after, faults = fault_after(estimator, [jumped(t) for t in times(0.1, end)])
    assert after <= SEEN
    assert faults == {Fault.CLOCK}
    for t in times(1.0, end + 0.1):
        estimator.accept(jumped(t))
        estimate = estimator.at(t + LATENCY)
        assert_sound(estimate)
    assert estimate.standing.quality is Quality.GOOD
    assert estimate.standing.age == pytest.approx(LATENCY, abs=1e-3)


def test_a_clock_that_goes_to_and_fro_is_never_followed():
    camera, rng = Camera(), random.Random(2)
    estimator, end = settled(camera)
    for t in times(3.0, end):
        frame = camera.frame(t)
        wrong = rng.choice((-1, 1)) * rng.uniform(0.2, 50.0)
        estimator.accept(replace(frame, capture_time=frame.capture_time + wrong))
        assert_sound(estimator.at(t + LATENCY))
    assert estimator.at(t + LATENCY).standing.quality is Quality.LOST
    assert estimator.counts["new"] == round(end * RATE)


def test_a_stream_that_is_held_up_never_looks_new():
    camera = Camera()
    estimator, end = settled(camera)
    for t in times(20.0, end):
        frame = camera.frame(t, latency=0.3)
        estimator.accept(frame)
        estimate = estimator.at(frame.received_time)
        assert estimate.standing.quality is Quality.LOST
        assert estimate.standing.age > 0.3


# Any stream.

number = st.floats(allow_nan=True, allow_infinity=True)
near = st.floats(-5, 5)
poses = st.one_of(
    st.builds(Pose, st.tuples(near, near, near)),
    st.builds(
        Pose,
        st.tuples(near, near, near),
        st.builds(rotations.from_vector, st.tuples(near, near, near)),
    ),
    st.builds(Pose, st.tuples(number, number, number), st.tuples(*[number] * 4)),
)


@st.composite
def streams(draw):
    """Frames of a good stream with anything in between, and times that mostly go on."""
    camera, t = Camera(draw(st.integers(0, 1000))), 0.0
    frames = []
    for _ in range(draw(st.integers(1, 60))):
        t += draw(st.sampled_from([0.0, 0.01, 0.01, 0.01, 0.02, 0.2, 3.0]))
        frame = camera.frame(t)
        what = draw(st.sampled_from(["good", "good", "good", "bodies", "times", "again"]))
        if what == "bodies":
            names = st.sampled_from([*BODIES, "stranger"])
            frame = replace(frame, bodies=draw(st.dictionaries(names, poses)))
        elif what == "times":
            frame = replace(frame, capture_time=draw(st.one_of(st.none(), number)))
        elif what == "again" and frames:
            frame = replace(draw(st.sampled_from(frames)), received_time=frame.received_time)
        frames.append(frame)
    return frames


@settings(max_examples=150, deadline=None)
@given(frames=streams(), wait=st.floats(0.0, 1.0))
def test_whatever_comes_values_are_numbers_and_old_is_never_new(frames, wait):
    estimator = Estimator(BODIES, CABLES)
    news: dict[str, float] = {}
    lent: dict[str, float] = {}
    seen: dict[str, list] = {}
    for frame in frames:
        verdict = estimator.accept(frame)
        if verdict is Verdict.NEW:
            for name, pose in frame.bodies.items():
                if pose.is_finite and pose.position not in seen.setdefault(name, [])[-1:]:
                    news[name] = frame.received_time
                    seen[name].append(pose.position)
        for now in (frame.received_time, frame.received_time + wait):
            estimate = estimator.at(now)
            for name, body in estimate.bodies.items():
                values = (*body.position, *body.velocity, *body.acceleration)
                assert all(map(math.isfinite, (*values, *body.attitude, *body.rate)))
                assert math.hypot(*body.attitude) == pytest.approx(1.0)
                standing = body.standing
                assert not math.isnan(standing.age)
                assert (standing.fault is Fault.NONE) == (standing.quality is Quality.GOOD)
                if standing.quality is Quality.NONE:
                    continue
                # other bodies' poses may have been taken in for it, while it was SWAPPED
                if standing.fault is Fault.SWAPPED:
                    lent[name] = max(news.values())
                last = max(news[name], lent.get(name, news[name]))
                assert standing.age >= now - last - 1e-6
                if standing.quality >= Quality.COASTING:
                    assert standing.age <= TUNING.coast
                elif standing.quality is Quality.SUSPECT:
                    assert standing.age <= TUNING.lost
            for cable in estimate.cables:
                values = (*cable.direction, *cable.direction_rate, cable.swing, cable.distance)
                assert all(map(math.isfinite, values))
                assert math.hypot(*cable.direction) == pytest.approx(1.0)


@settings(max_examples=20, deadline=None)
@given(frames=streams())
def test_after_anything_a_good_stream_is_good_again_or_names_are_in_doubt(frames):
    estimator = Estimator(BODIES, CABLES)
    for frame in frames:
        estimator.accept(frame)
    camera, start = Camera(7), frames[-1].received_time + 0.1
    for forgotten in (False, True):
        if forgotten:
            estimator.forget()
        for t in times(2.0, start + 2.0 * forgotten):
            estimator.accept(camera.frame(t))
        standing = estimator.at(t + LATENCY).standing
        if forgotten or standing.fault is not Fault.SWAPPED:
            assert standing.quality is Quality.GOOD
            assert_sound(estimator.at(t + LATENCY))
