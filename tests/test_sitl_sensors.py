"""Sensors tell the truth, but for biases and noise of the sizes and spectra that are said."""

import math

import multilift as ml
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift.errors import ScenarioError
from multilift.flight.link import frames
from multilift.flight.sitl import geodesy, physics
from multilift.flight.sitl.physics import Motion, Physics
from multilift.flight.sitl.sensors import IDEAL, Capture, Noise, Sensors

LEVEL = Motion((0.0, 0.0, -1.0), (0.0,) * 3, (1.0, 0.0, 0.0, 0.0), (0.0,) * 3, (0.0,) * 3,
               (0.0, 0.0, -9.8))  # fmt: skip
ANGLE = st.floats(-3.0, 3.0)


def series(noise, count=4000, dt=0.004, motion=LEVEL, **others):
    sensors = Sensors(1, 0, noise, **others)
    return [sensors.read(dt * (k + 1), dt, motion) for k in range(count)]


def hover(scenario="bar_from_floor", **changes):
    return Physics(ml.load(scenario).with_values(changes))


def test_at_rest_an_accelerometer_feels_the_floor_push_it_up():
    world = hover()
    for _ in range(100):
        world.advance([(0.0,) * 4] * 2, 0.004)
    for motion in world.motions:
        assert motion.mean_force == pytest.approx((0.0, 0.0, -9.8), abs=1e-9)
        assert motion.mean_rate == (0.0, 0.0, 0.0)


def test_falling_it_feels_nothing_but_drag():
    world = hover(**{"start.payload_position": [0.0, 0.0, 2.5], "plant.vehicle_drag": 0.0,
                     "start.vehicle_position": [[-0.75, 0.0, 3.0], [0.75, 0.0, 3.0]]})  # fmt: skip
    world.advance([(0.0,) * 4] * 2, 0.004)
    for motion in world.motions:
        assert motion.mean_force == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_mean_force_and_rate_add_up_to_the_motion():
    """Over any flight the means, turned back and summed, are the change of velocity."""
    world = hover()
    velocity = np.zeros(3)
    for k in range(400):
        before = world.motions[0].quaternion
        # Lopsided, so that it leaves the ground turning.
        world.advance([(0.78, 0.781, 0.782, 0.779), (0.75,) * 4], 0.004)
        m = world.motions[0]
        middle = physics._middle(before, m.quaternion)
        back = physics.to_body((middle[0], *(-u for u in middle[1:])), m.mean_force)
        velocity += 0.004 * np.add(back, (0.0, 0.0, 9.8))
        assert velocity == pytest.approx(m.velocity, abs=1e-9), k
    assert np.linalg.norm(world.motions[0].rate) > 0.01


def test_where_the_flight_is_smooth_the_mean_is_what_is_felt_at_the_instant():
    world = hover()
    for _ in range(200):
        world.advance([(0.8,) * 4, (0.75,) * 4], 0.004)
    world.advance([(0.8,) * 4, (0.75,) * 4], 0.0005)
    felt = [frames.body(f) for f in world.world.specific_force.tolist()]
    # Half a step apart, at less than 3 m/s^3.
    assert world.motions[0].mean_force == pytest.approx(felt[0], abs=3 * 0.0005)


@given(ANGLE, st.floats(-1.5, 1.5), ANGLE, st.tuples(ANGLE, ANGLE, ANGLE))
@settings(max_examples=50)
def test_seen_from_a_body_a_vector_keeps_its_length_and_turns_back(roll, pitch, yaw, v):
    cr, cp, cy = (math.cos(a / 2) for a in (roll, pitch, yaw))
    sr, sp, sy = (math.sin(a / 2) for a in (roll, pitch, yaw))
    q = (cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
         cr * cp * sy - sr * sp * cy)  # fmt: skip
    seen = physics.to_body(q, v)
    assert math.dist(seen, (0, 0, 0)) == pytest.approx(math.dist(v, (0, 0, 0)), abs=1e-12)
    assert physics.to_body((q[0], -q[1], -q[2], -q[3]), seen) == pytest.approx(v, abs=1e-12)
    # Down, as seen from a rolled and pitched body.
    down = (-math.sin(pitch), math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch))
    assert physics.to_body(q, (0.0, 0.0, 1.0)) == pytest.approx(down, abs=1e-12)


def test_ideal_sensors_tell_the_truth():
    (told,) = series(IDEAL, 1)
    assert told.accel == LEVEL.mean_force
    assert told.gyro == LEVEL.mean_rate
    assert told.mag == geodesy.FIELD
    assert told.pressure_altitude == pytest.approx(geodesy.HOME.altitude + 1.0, abs=1e-6)


@pytest.mark.parametrize("dt", [0.001, 0.004])
def test_densities_are_the_same_at_every_rate(dt):
    noise = Noise(gyro=0.01, accel=0.1, gyro_bias=0.0, accel_bias=0.0)
    told = series(noise, 4000, dt)
    # Of 4000 samples the deviation is known to 1.1 %: six times that.
    for name, density in (("gyro", 0.01), ("accel", 0.1)):
        x = np.array([getattr(s, name) for s in told])[:, 0]
        assert x.std() * math.sqrt(dt) == pytest.approx(density, rel=0.07)


def test_biases_are_constant_and_each_vehicles_own():
    noise = Noise(0.0, 0.1, 0.0, 0.1, 0.0, 0.1, 0.0, 0.1)
    told = series(noise, 50)
    assert len({(s.gyro, s.accel, s.mag, s.pressure) for s in told}) == 1
    other = Sensors(1, 1, noise).read(0.004, 0.004, LEVEL)
    assert other.gyro != told[0].gyro
    many = [Sensors(1, i, noise).read(0.004, 0.004, LEVEL).gyro for i in range(400)]
    assert np.std(many) == pytest.approx(0.1, rel=6 / math.sqrt(2 * 1200))


def test_equal_seeds_give_equal_noise_whatever_motion_capture_does():
    assert series(Noise(), 20) == series(Noise(), 20)
    watched = series(Noise(), 20, capture=Capture())
    assert [s.gyro for s in watched] == [s.gyro for s in series(Noise(), 20)]


def test_motion_capture_comes_at_its_rate_late_by_its_delay():
    moving = [LEVEL._replace(position=(0.004 * k, 0.0, -1.0)) for k in range(100)]
    sensors = Sensors(1, 0, IDEAL, Capture(0.02, 0.012, 0.0, 0.0))
    told = [sensors.read(0.004 * k, 0.004, m) for k, m in enumerate(moving)]
    seen = [(k, s.pose.position[0]) for k, s in enumerate(told) if s.pose]
    assert [k for k, _ in seen] == list(range(3, 100, 5))
    for k, x in seen:
        assert x == pytest.approx(0.004 * (k - 3))


def test_the_atmosphere_is_the_standard_one():
    # ISO 2533, table 1.
    for height, hectopascal in ((0.0, 1013.25), (1000.0, 898.746), (2000.0, 794.952)):
        assert geodesy.pressure(height) == pytest.approx(hectopascal, abs=0.01)
        assert geodesy.pressure_altitude(geodesy.pressure(height)) == pytest.approx(height)


@pytest.mark.parametrize(
    ("scenario", "changes", "key"),
    [
        ("sim1", {}, "plant.model"),
        ("exp1_1", {}, "plant.model"),
        ("bar_from_floor", {"vehicle.kind": "ideal"}, "vehicle.kind"),
        ("bar_from_floor", {"ground.present": False}, "ground.present"),
        ("bar_from_floor", {"start.rotors": "running"}, "start.rotors"),
    ],
)
def test_where_firmware_cannot_start_it_is_said(scenario, changes, key):
    with pytest.raises(ScenarioError, match=key):
        hover(scenario, **changes)
