"""A spatial world that is stepped from outside is the world of a run."""

import multilift as ml
import numpy as np
import pytest
from multilift.errors import ControllerError, ScenarioError
from multilift.models.spatial import FlyingLaw, SpatialWorld
from multilift.models.spatial.world import AUTOPILOT_MOTORS
from spatial_scenarios import plate
from test_spatial_runs import KINDS

LEVEL = {"formation.tilt": 0.0, "goal.payload_position": [0.0, 0.0, 1.0]}
CRAFT = {**LEVEL, "vehicle.type": "x500"}


def columns(world, quadrotors):
    """The world's state as a run's row names it."""
    row = {"t": world.t, "energy": world.energy}

    def put(name, values, parts):
        row.update({f"{name}{part}": x for part, x in zip(parts, values, strict=True)})

    axes, wxyz = ("_x", "_y", "_z"), ("_qw", "_qx", "_qy", "_qz")
    put("payload", world.payload, axes)
    put("payload_v", world.payload_velocity, axes)
    put("payload", world.payload_attitude, wxyz)
    put("payload_rate", world.payload_rate, axes)
    for i in range(world.count):
        name = f"vehicle{i + 1}"
        put(name, world.vehicle[i], axes)
        put(f"{name}_v", world.vehicle_velocity[i], axes)
        if quadrotors:
            put(name, world.vehicle_attitude[i], wxyz)
            put(f"{name}_rate", world.vehicle_rate[i], axes)
            put(f"{name}_rotor", world.rotor_speed[i], "1234")
    return row


def same_as_row(world, run, k):
    for name, value in columns(world, "vehicle1_qw" in run.columns).items():
        assert value == run[name][k], (name, k)


@pytest.mark.parametrize("kind", KINDS)
def test_a_runs_commands_take_it_the_runs_way_to_the_last_bit(kind):
    scenario = plate(changes={**KINDS[kind], "simulation.record_period": 0.01})
    run, world = ml.simulate(scenario), SpatialWorld(scenario)
    forces = np.stack([run.vector(f"force{i + 1}") for i in range(3)], axis=1)
    for k, force in enumerate(forces[:-1]):
        same_as_row(world, run, k)
        world.step_forces(force)
    same_as_row(world, run, -1)
    assert world.status == "running"


@pytest.mark.parametrize("kind", KINDS)
def test_law_and_world_together_are_the_run(kind):
    scenario = plate(changes={**KINDS[kind], "simulation.record_period": 0.01})
    run, world, law = ml.simulate(scenario), SpatialWorld(scenario), FlyingLaw(scenario)
    for k in range(len(run["t"]) - 1):
        payload = world.measured_payload
        command = law.update(
            world.t, world.measured_vehicle, world.measured_vehicle_velocity, payload[:3],
            payload[3:7], payload[7:10], payload[10:], world.saturated,
        )  # fmt: skip
        assert np.array_equal(command.asked[0], run.vector("force1")[k])
        world.step_forces(command.asked)
        same_as_row(world, run, k + 1)


def test_set_points_are_what_its_own_control_makes_of_forces():
    scenario = plate(changes={"vehicle.type": "paper_craft"})
    by_force, by_set_point = SpatialWorld(scenario), SpatialWorld(scenario)
    law = FlyingLaw(scenario)
    for k in range(50):
        world = by_force
        command = law.update(
            world.t, world.vehicle, world.vehicle_velocity, world.payload, world.payload_attitude,
            world.payload_velocity, world.payload_rate,
        )  # fmt: skip
        by_force.step_forces(command.force, yaw=0.3)
        by_set_point.step_set_points(*law.set_points(command.force, 0.3))
        assert columns(by_force, True) == columns(by_set_point, True), k


@pytest.mark.parametrize("changes", [{}, {"plant.cables": "elastic"}, CRAFT, {**CRAFT, **{
    "wind.gust_speed": 3.0, "ground.present": True, "ground.height": -0.2}}])  # fmt: skip
def test_one_call_for_many_steps_is_many_calls_for_one(changes):
    once, often = (SpatialWorld(plate(changes=changes)) for _ in range(2))
    rng = np.random.default_rng(1)
    for _ in range(20):
        if "vehicle.type" in changes:
            motors = rng.uniform(0.5, 0.7, (3, 4))
            once.step_motors(motors, steps=7)
            for _ in range(7):
                often.step_motors(motors, steps=1)
        else:
            force = rng.normal([0.0, 0.0, 19.0], 3.0, (3, 3))
            once.step_forces(force, steps=7)
            for _ in range(7):
                often.step_forces(force, steps=1)
    assert columns(once, True) == columns(often, True)
    assert np.array_equal(once.tension, often.tension)
    assert once.incidents == often.incidents


def test_a_free_run_keeps_its_energy():
    # Level motions under upright cables, which none of them jerks.
    changes = {
        **CRAFT, "plant.vehicle_drag": 0.0, "start.payload_rate": [0.0, 0.0, 0.4],
        "start.vehicle_velocity": [[0.3, 0.1, 0.0], [-0.2, 0.2, 0.0], [0.0, -0.4, 0.0]],
        "start.rotors": "stopped",
    }  # fmt: skip
    drift = []
    for step in (0.001, 0.0005):
        world = SpatialWorld(plate(changes={**changes, "simulation.step": step}))
        before = world.energy
        world.step_motors(np.zeros((3, 4)), steps=round(0.5 / step))
        _, lost, _ = world.impacts
        drift.append(abs(world.energy + lost - before))
    # A step of order 4 drifts by its fourth power or less, down to round-off of 50 J.
    assert drift[1] < max(drift[0] / 8, 1e-12)
    assert drift[1] < 1e-7


def test_what_a_jerk_takes_is_what_the_energy_lacks():
    up = plate(changes={"plant.vehicle_drag": 0.0})
    places = up.vehicle_start[:, :3] - [0.0, 0.0, 0.1]
    world = SpatialWorld(up.with_values({"start.vehicle_position": places}))
    assert not world.taut.any()
    before = world.energy
    world.step_forces(np.zeros((3, 3)), steps=50)
    assert world.impacts[0] == 0
    assert np.isclose(world.energy, before, rtol=1e-12)
    force = np.outer(up["plant.vehicle_mass"], [0.0, 0.0, 2 * 9.8])
    place, work = world.vehicle[:, 2].copy(), 0.0
    for _ in range(400):
        world.step_forces(force, steps=1)
        work += (force[:, 2] * (world.vehicle[:, 2] - place)).sum()
        place[:] = world.vehicle[:, 2]
    count, lost, hardest = world.impacts
    assert count >= 3
    assert lost > 0.1
    assert hardest > 0
    # Constant forces: the work is force times way, exactly, but for integration error.
    assert np.isclose(world.energy - before, work - lost, atol=1e-6)
    assert {i.what for i in world.incidents} >= {"taut"}


def hover_motors(scenario):
    share = scenario.rest.cable_force[0][:, 2] + np.array(scenario["plant.vehicle_mass"]) * 9.8
    speed = np.sqrt(share / 4 / np.array(scenario["vehicle.thrust_coefficient"]))
    return np.outer(speed / np.array(scenario["vehicle.rotor_speed_max"]), np.ones(4))


def test_motors_at_hover_hold_everything_where_it_is():
    scenario = plate(changes=CRAFT)
    world = SpatialWorld(scenario)
    motors = hover_motors(scenario)
    start = world.vehicle.copy()
    world.step_motors(motors, steps=1000)
    # Round-off of a millionth of a millionth newton, unstable as quadrotors are, for a second.
    assert np.abs(world.vehicle - start).max() < 1e-9
    assert np.allclose(world.tension, 1.2 * 9.8 / 3)
    assert np.allclose(world.specific_force, [0.0, 0.0, 9.8])
    assert world.incidents == []


def test_motors_turn_craft_as_autopilots_expect():
    scenario = plate(changes=CRAFT)
    # Motor 1 front right, 2 rear left, 3 front left, 4 rear right; 1 and 2 turn counterclockwise.
    # Body x forward, y left, z up: nose up is -y, left side down -x, clockwise from above -z.
    for motors, axis in (([0, 2], 1), ([0, 3], 0), ([0, 1], 2)):
        world = SpatialWorld(scenario)
        command = hover_motors(scenario)
        command[:, motors] += 0.02
        world.step_motors(command[:, AUTOPILOT_MOTORS], steps=30)
        rate = world.vehicle_rate
        assert (rate[:, axis] < 0).all()
        assert (np.abs(np.delete(rate, axis, axis=1)) < 1e-6 * np.abs(rate[:, [axis]])).all()


def test_accelerometers_feel_what_changes_the_velocity():
    error = []
    for step in (0.001, 0.0005):
        scenario = plate(changes={**CRAFT, "simulation.step": step})
        world = SpatialWorld(scenario)
        command = hover_motors(scenario) * [1.02, 0.99, 1.01, 1.0]
        world.step_motors(command, steps=round(0.1 / step) - 1)
        before = world.vehicle_velocity.copy()
        world.step_motors(command, steps=1)
        felt, attitude = world.specific_force.copy(), world.vehicle_attitude.copy()
        world.step_motors(command, steps=1)
        measured = (world.vehicle_velocity - before) / (2 * step)
        w, v = attitude[:, :1], attitude[:, 1:]
        turned = felt + 2 * np.cross(v, np.cross(v, felt) + w * felt)
        error.append(np.abs(turned - [0.0, 0.0, 9.8] - measured).max())
    # Central differences: of order 2.
    assert 3.5 < error[0] / error[1] < 4.5


def test_what_stands_on_the_ground_feels_it():
    changes = {
        **CRAFT, "ground.present": True, "start.rotors": "stopped",
        "start.payload_position": [0.0, 0.0, 0.0],
        "start.vehicle_position": [[1.0, 0.0, 0.15], [-0.5, 0.9, 0.15], [-0.5, -0.9, 0.15]],
    }  # fmt: skip
    world = SpatialWorld(plate(changes=changes))
    world.step_motors(np.zeros((3, 4)), steps=2000)
    assert world.standing.all()
    assert not world.taut.any()
    # Within the oscillation that critical damping has left after 2 s: none.
    assert np.allclose(world.specific_force, [0.0, 0.0, 9.8], atol=1e-6)
    assert np.allclose(world.payload_contact[2], 1.2 * 9.8)
    told = [i for i in world.incidents if i.what == "touch_down"]
    assert {i.vehicle for i in told} == {-1, 0, 1, 2}


def test_what_breaks_is_told():
    scenario = plate(changes={**KINDS["noisy"], "safety.vehicle_distance": 0.3})
    world = SpatialWorld(scenario)
    hold = np.outer([19.0] * 3, [0.0, 0.0, 1.0])
    world.step_forces(hold, steps=599)
    assert not any(i.what == "cable_cut" for i in world.incidents)
    world.step_forces(hold, steps=2)
    cut = [i for i in world.incidents if i.what == "cable_cut"]
    assert [(i.t, i.vehicle) for i in cut] == [(0.6, 1)]
    world.fail("vehicle_lost", 0)
    world.step_forces(hold, steps=200)
    assert world.rotor_speed[0].max() < 1.0
    assert world.incidents[-1].t <= world.t


def test_a_world_that_ended_stays_as_it_was():
    changes = {"safety.vehicle_distance": 0.6}
    scenario = plate(changes=changes)
    world = SpatialWorld(scenario)
    inwards = np.array([[-9.0, 0.0, 19.0], [4.0, -8.0, 19.0], [4.0, 8.0, 19.0]])
    while world.status == "running":
        world.step_forces(inwards)
        assert world.t < 5.0
    assert world.status == "collision"
    assert world.incidents[-1].what == "collision"
    assert world.clearance[0] < 0.6
    ended = columns(world, True)
    world.step_forces(inwards)
    assert columns(world, True) == ended
    world.reset()
    assert world.status == "running"
    assert world.incidents == []
    assert world.t == 0.0
    assert columns(world, True) == columns(SpatialWorld(scenario), True)


def test_what_cannot_be_meant_is_refused():
    ideal, craft = SpatialWorld(plate()), SpatialWorld(plate(changes=CRAFT))
    level = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    for call, message in (
        (lambda: ideal.step_forces(np.zeros((2, 3))), r"forces have the shape \(2, 3\)"),
        (lambda: ideal.step_forces(np.full((3, 3), np.nan)), "forces are"),
        (lambda: ideal.step_forces(np.zeros((3, 3)), yaw=np.inf), "yaw is"),
        (lambda: ideal.step_forces(np.zeros((3, 3)), steps=0), "steps is 0"),
        (lambda: ideal.step_motors(np.zeros((3, 4))), "take forces only"),
        (lambda: ideal.step_set_points(level, np.zeros(3)), "take forces only"),
        (lambda: craft.step_motors(np.zeros((3, 3))), "motor commands have the shape"),
        (lambda: craft.step_set_points(2 * level, np.zeros(3)), "unit quaternions"),
        (lambda: craft.step_set_points(level, np.zeros(2)), "thrusts have the shape"),
    ):
        with pytest.raises(ControllerError, match=message):
            call()
    for arguments, key in ((("sneeze", 0), "what"), (("cable_cut", 3), "vehicle"),
                           (("rotor_stopped", 0, 4), "rotor")):  # fmt: skip
        with pytest.raises(ScenarioError, match=key):
            craft.fail(*arguments)
    with pytest.raises(ScenarioError, match="rotor_stopped"):
        ideal.fail("rotor_stopped", 0)
    with pytest.raises(ScenarioError, match=r"plant\.model"):
        SpatialWorld(ml.load("sim1"))
    assert ideal.t == craft.t == 0.0
