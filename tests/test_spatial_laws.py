"""The geometric law and the linear-quadratic regulator close the loop on random teams."""

import math

import numpy as np
import pytest
from multilift.models.spatial.lqr import Weights, feedback_matrix, linearisation, lqr_gains
from scipy.linalg import expm
from spatial_flights import (
    FIELDS,
    attitude_error,
    fly,
    pack,
    payload_error,
    quaternion,
    start,
    team,
    turn,
)

#: Teams by number of vehicles and payload; of points, the box and the bar not all turns are driven.
TEAMS = [(1, "point"), (1, "platform"), (2, "platform"), (3, "point"), (3, "platform"),
         (4, "platform"), (6, "platform")]  # fmt: skip
DRIVEN = [(n, kind) for n, kind in TEAMS if n > 2 and kind == "platform"]

#: As flown with motion capture at 100 Hz over a link: 10 ms and 20 ms late.
MOTION_CAPTURE = {"period": 0.01, "delay": 0.01, "position_noise": 5e-4, "velocity_noise": 0.01,
                  "attitude_noise": 3.5e-3, "rate_noise": 0.017}  # fmt: skip


def plant_of(team):
    return (team.mass, team.length, team.attachment, team.payload_mass, team.payload_inertia,
            team.cable_force)  # fmt: skip


def gains_of(law, team):
    return lqr_gains(*plant_of(team)) if law == "lqr" else {"k_integral": 0.0}


@pytest.mark.parametrize("law", ["geometric", "lqr"])
@pytest.mark.parametrize(("n", "kind"), TEAMS)
def test_converges_from_perturbed_starts(law, n, kind):
    rng = np.random.default_rng(n)
    crew = team(n, rng, kind=kind)
    run = fly(crew, law, gains_of(law, crew), start(crew, rng, yaw=0.4), yaw=0.4, seconds=20.0)
    error = payload_error(run)
    assert run["status"] == "finished"
    assert run["metrics"]["min_tension"] > 0
    # The slowest mode of either law decays by more than 0.4 a second: by 3000 in 20 s.
    assert error[-1] < error[0] / 3000
    if (n, kind) in DRIVEN:
        assert attitude_error(run)[-1] < 1e-4


def circle(radius, omega, seconds, yaw_rate, piece=0.1):
    """Taylor polynomials of a circle, whose remainder is (omega piece)^8 / 8! of the radius."""
    pieces = []
    for k in range(round(seconds / piece)):
        t = k * piece
        x, y = (
            [
                radius * omega**j * f(omega * t + j * math.pi / 2) / math.factorial(j)
                for j in range(8)
            ]
            for f in (math.cos, math.sin)
        )
        pieces.append((t, [x, y, [0.0] * 8, [yaw_rate * t, yaw_rate, *[0.0] * 6]]))
    return pieces


@pytest.mark.parametrize(("n", "kind"), [(1, "point"), *DRIVEN])
def test_geometric_law_follows_a_circle_but_for_the_hold(n, kind):
    radius, omega, k = 1.0, 1.0, 2.0
    gains = {"k_position": k, "k_velocity": 2.5, "k_integral": 0.0, "k_cable": 30.0,
             "k_cable_rate": 9.0}  # fmt: skip
    left = {}
    for steps in (1, 10):
        rng = np.random.default_rng(n)
        crew = team(n, rng, kind=kind)
        begin = start(crew, rng, goal=(radius, 0.0, 2.0))
        run = fly(crew, "geometric", gains, begin, seconds=20.0, control_steps=steps,
                  pieces=circle(radius, omega, 20.0, 0.3), path_end=20.0)  # fmt: skip
        left[steps] = payload_error(run)[1500:].max()
        # A force held for h is late by h / 2, and so is the acceleration, by a jerk's h / 2; twice
        # that for what the cables add.
        assert left[steps] < 0.001 * steps * radius * omega**3 / k
        if kind == "platform":
            assert attitude_error(run)[1500:].max() < 0.001 * steps
    # Nothing else is left: the error goes with the hold. What decays is below a tenth of it.
    assert left[10] / left[1] == pytest.approx(10, rel=0.2)


@pytest.mark.parametrize(("n", "kind"), TEAMS)
def test_regulated_plant_is_stable_and_decays_as_its_linearisation_says(n, kind):
    crew = team(n, np.random.default_rng(10 + n), kind=kind)
    plant = linearisation(*plant_of(crew))
    feedback = feedback_matrix(plant, Weights(), crew.mass)
    assert np.linalg.eigvals(plant.a - plant.b @ feedback).real.max() < -0.1

    # The same with forces held for one step, as the run holds them: its state from step to step.
    h, amount = 0.001, 1e-4
    m, inputs = plant.count, plant.b.shape[1]
    both = np.zeros((2 * m + inputs, 2 * m + inputs))
    both[: 2 * m, : 2 * m], both[: 2 * m, 2 * m :] = plant.a, plant.b
    held = expm(h * both)
    once = held[: 2 * m, : 2 * m] - held[: 2 * m, 2 * m :] @ feedback
    assert np.abs(np.linalg.eigvals(once)).max() < 1

    begin = start(crew, np.random.default_rng(3), amount=amount)
    run = fly(crew, "lqr", lqr_gains(*plant_of(crew)), begin, seconds=4.0)
    z = coordinates(crew, plant, run["columns"])
    expected = [z[0]]
    for _ in range(1, len(z)):
        expected.append(np.linalg.matrix_power(once, 10) @ expected[-1])
    # What is left out grows with the square of what was perturbed.
    assert np.abs(z - expected).max() < 10 * amount * np.abs(z[0]).max()


def coordinates(crew, plant, c):
    """The linearisation's state of every sample of a run to the goal (0, 0, 2)."""
    count = len(c["t"])
    vector = {name: np.stack([c[f"{name}_{k}"] for k in "xyz"], axis=1)
              for name in ("payload", "payload_v", "payload_rate")}  # fmt: skip
    attitude = 2 * np.stack([c[f"payload_q{k}"] for k in "xyz"], axis=1)
    vehicles = [np.stack([c[f"vehicle{i + 1}{v}_{k}"] for k in "xyz"], axis=1)
                for v in ("", "_v") for i in range(crew.n)]  # fmt: skip
    goal = np.array([0.0, 0.0, 2.0])
    places = [vehicles[i] - goal - crew.offset[i] for i in range(crew.n)]
    rates = vehicles[crew.n :]
    position = np.hstack([vector["payload"] - goal, attitude, *places])
    rate = np.hstack([vector["payload_v"], vector["payload_rate"], *rates])
    assert position.shape == (count, 6 + 3 * crew.n)
    return np.hstack([position @ plant.place.T, rate @ plant.place.T])


@pytest.mark.parametrize("law", ["geometric", "lqr"])
@pytest.mark.parametrize("n", [2, 4])
def test_numbering_of_the_vehicles_does_not_matter(law, n):
    rng = np.random.default_rng(5)
    crew = team(n, rng)
    payload, vehicles = start(crew, rng)
    order = rng.permutation(n)
    other = crew.relabelled(order)
    one = fly(crew, law, gains_of(law, crew), (payload, vehicles), seconds=5.0)
    two = fly(other, law, gains_of(law, other), (payload, vehicles[order]), seconds=5.0)
    for key in ("payload_x", "payload_y", "payload_z", "payload_qz"):
        np.testing.assert_allclose(one["columns"][key], two["columns"][key], atol=1e-8)
    for k, i in enumerate(order):
        np.testing.assert_allclose(
            one["columns"][f"tension{i + 1}"], two["columns"][f"tension{k + 1}"], atol=1e-6
        )


@pytest.mark.parametrize("law", ["geometric", "lqr"])
@pytest.mark.parametrize(("n", "kind"), TEAMS)
def test_heading_of_the_world_does_not_matter(law, n, kind):
    crew = team(n, np.random.default_rng(n), kind=kind)
    angle = 1.1
    level = turn(quaternion(np.array([0.0, 0.0, angle])))
    payload, vehicles = start(crew, np.random.default_rng(2))
    turned = payload.copy()
    for part in (slice(0, 3), slice(7, 10)):
        turned[part] = level @ payload[part]
    w, x, y, z = payload[3:7]
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    turned[3:7] = [c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w]
    moved = np.hstack([vehicles[:, :3] @ level.T, vehicles[:, 3:] @ level.T])
    one = fly(crew, law, gains_of(law, crew), (payload, vehicles), seconds=5.0)
    two = fly(crew, law, gains_of(law, crew), (turned, moved), yaw=angle, seconds=5.0)
    place = [np.stack([r["columns"][f"payload_{k}"] for k in "xyz"]) for r in (one, two)]
    np.testing.assert_allclose(level @ place[0], place[1], atol=1e-9)
    np.testing.assert_allclose(one["columns"]["tension1"], two["columns"]["tension1"], atol=1e-8)


@pytest.mark.parametrize(("n", "kind"), TEAMS)
def test_geometric_law_flies_quadrotors_with_its_default_gains(n, kind):
    rng = np.random.default_rng(n)
    crew = team(n, rng, kind=kind)
    run = fly(crew, "geometric", {}, start(crew, rng, amount=0.5), seconds=25.0, craft={},
              control_steps=10, link={"delay": 0.02}, motion_capture=MOTION_CAPTURE,
              limits={"tilt_max": 0.6})  # fmt: skip
    assert run["status"] == "finished"
    # Velocity noise of 1 cm/s comes through at the loop's 1 rad/s.
    assert payload_error(run)[-500:].max() < 0.03
    if (n, kind) in DRIVEN:
        assert attitude_error(run)[-500:].max() < 0.06


@pytest.mark.parametrize(("n", "kind"), [team for team in TEAMS if team != (1, "platform")])
def test_regulator_flies_quadrotors_where_it_leaves_fast_swings_alone(n, kind):
    rng = np.random.default_rng(n)
    crew = team(n, rng, kind=kind)
    gains = lqr_gains(*plant_of(crew), least_lever=0.2)
    run = fly(crew, "lqr", gains, start(crew, rng, amount=0.5), seconds=25.0, craft={},
              control_steps=10, link={"delay": 0.02}, motion_capture=MOTION_CAPTURE,
              limits={"tilt_max": 0.6})  # fmt: skip
    assert run["status"] == "finished"
    assert payload_error(run)[-500:].max() < 0.02


def test_integral_makes_up_for_a_wrong_mass():
    rng = np.random.default_rng(1)
    crew = team(3, rng)
    wrong = {"payload_mass": 1.1 * crew.payload_mass}
    runs = [
        fly(crew, "geometric", {"k_integral": k}, start(crew, rng), seconds=60.0, assumed=wrong)
        for k in (0.0, 0.4)
    ]
    left = [payload_error(run)[-1] for run in runs]
    assert left[0] > 0.05
    assert left[1] < 1e-4


def test_tension_floor_holds_where_the_formation_has_internal_forces():
    crew = team(4, np.random.default_rng(4))
    crew.tilt[:] = 0.5
    crew.__post_init__()
    # Down by 2 m in 1.8 s, from rest to rest, at up to 4.6 m/s^2.
    drop, seconds = 2.0, 1.8
    way = -np.array([0, 0, 0, 0, 35, -84, 70, -20]) / seconds ** np.arange(8)
    way[0] += 1
    pieces = [(0.0, [[0.0] * 8, [0.0] * 8, (drop * way).tolist(), [0.0] * 8])]
    least = {}
    for floor in (0.0, 3.0):
        run = fly(crew, "geometric", {"k_integral": 0.0, "tension_floor": floor},
                  start(crew, goal=(0.0, 0.0, 2.0 + drop)), seconds=12.0, pieces=pieces,
                  path_end=seconds)  # fmt: skip
        assert payload_error(run)[-1] < 1e-5
        least[floor] = run["metrics"]["min_tension"]
    assert least[0.0] < 2.9
    assert least[3.0] > 3.0


def test_gains_need_cables_that_pull():
    crew = team(3, np.random.default_rng(0))
    with pytest.raises(ValueError, match="must pull"):
        linearisation(*plant_of(crew)[:-1], np.zeros((3, 3)))


def test_rotations_that_no_cable_drives_are_no_coordinates():
    def turns(n, kind):
        return linearisation(*plant_of(team(n, np.random.default_rng(0), kind=kind))).turns

    assert len(turns(3, "point")) == 0
    assert abs(turns(1, "platform")[:, 2]).max() < 1e-12
    assert len(turns(4, "platform")) == 3


def test_rows_refuse_what_is_no_field():
    with pytest.raises(AssertionError, match="no fields"):
        pack(FIELDS["link"], 1, {"delya": 1.0})
