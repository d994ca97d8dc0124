"""Laws of mechanics that whole rollouts obey, whatever the plant."""

from dataclasses import replace

import multilift as ml
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from planar_random import State, loads, plants, states
from planar_runs import (
    COMPILED,
    SHIPPED,
    commands,
    constant,
    coordinates,
    cross,
    no_force,
    rates,
    released_from,
    whole_runs,
)
from scipy.integrate import simpson

free_of_damping = {"vehicle_drag": (0.0,) * 4, "swing_damping": (0.0,) * 3}
DURATION = 0.4  # s


def pushes_of(load):
    """Pushes that hold the last seven numbers of a draw of `loads` for the whole run."""
    always = {"start": 0.0, "duration": 2 * DURATION}
    return [
        {"body": "vehicle_1", "force": load[4:6].tolist()} | always,
        {"body": "vehicle_2", "force": load[6:8].tolist()} | always,
        {"body": "bar", "force": load[8:10].tolist(), "torque": float(load[10])} | always,
    ]


def masses_moving(plant, run):
    """Vehicles' and bar's masses (3,), positions and velocities, each (n, 3, 2).

    The bar's velocity comes from differentiating (1).
    """
    q, v = coordinates(run), rates(run)
    l1, l2 = plant.cable_length
    lever = np.array([0.5 * l1, -0.5 * l2, plant.bar_half_thickness])
    lift = np.abs(lever)
    bar_velocity = 0.5 * (v[:, 0:2] + v[:, 2:4]) + np.stack(
        [(np.cos(q[:, 4:]) * v[:, 4:]) @ lever, (np.sin(q[:, 4:]) * v[:, 4:]) @ lift], axis=1
    )
    bar = np.stack([run["bar_y"], run["bar_z"]], axis=1)
    position = np.hstack([q[:, :4], bar]).reshape(-1, 3, 2)
    velocity = np.hstack([v[:, :4], bar_velocity]).reshape(-1, 3, 2)
    return np.array([*plant.vehicle_mass, plant.bar_mass]), position, velocity


def momentum(plant, run):
    """Linear momentum (y, z) and angular momentum about the world's origin, shape (n, 3)."""
    mass, position, velocity = masses_moving(plant, run)
    linear = np.einsum("b,nbk->nk", mass, velocity)
    angular = cross(position, velocity) @ mass + plant.bar_inertia * run["theta3_dot"]
    return np.column_stack([linear, angular])


def energy(plant, run):
    """Kinetic energy and the bar's weight; the vehicles' weights are held by u's gravity share."""
    mass, position, velocity = masses_moving(plant, run)
    kinetic = np.einsum("b,nbk,nbk->n", mass, velocity, velocity)
    turning = plant.bar_inertia * run["theta3_dot"] ** 2
    share = plant.bar_mass * plant.gravity
    height = position[:, 2, 1] - position[:, :2, 1].mean(axis=1)
    return 0.5 * (kinetic + turning) + share * height


def check_that_defect_vanishes_with_the_step(defect, plant, state, law, **tables):
    """`defect(run)` shrinks as the 4th power of the step, down to round-off: no law is broken.

    The bound of 10 leaves room for what a step of 2 ms has not settled yet.
    """
    runs = [
        ml.simulate(released_from(plant, state, DURATION, step, **tables), law)
        for step in (0.002, 0.001)
    ]
    assume(all(run.finished for run in runs))  # no cable went slack
    coarse, fine = map(defect, runs)
    assert (fine <= coarse / 10 + 1e-11).all(), (coarse, fine)


@whole_runs
@given(plants(**free_of_damping, gravity=0.0), states)
def test_an_isolated_system_keeps_energy_and_momentum(plant, state):
    def defect(run):
        kept = np.column_stack([momentum(plant, run), energy(plant, run)])
        return (np.abs(kept - kept[0]) / (1 + np.abs(kept[0]))).max(axis=0)

    check_that_defect_vanishes_with_the_step(defect, plant, state, no_force)


@whole_runs
@given(plants(**free_of_damping), states, loads.map(lambda x: 0.2 * x))
def test_momentum_changes_by_the_impulse_of_the_forces(plant, state, load):
    outside = np.reshape([*load[:4] + load[4:8], *load[8:10]], (3, 2))  # per body
    weight = plant.bar_mass * plant.gravity
    outside_and_weight = outside + 0.5 * weight * np.array([[0, 1], [0, 1], [0, -2]])

    def defect(run):
        _, position, _ = masses_moving(plant, run)
        torque = cross(position, outside_and_weight).sum(axis=1) + load[10]
        impulse = [
            *outside.sum(axis=0) * run.end_time,
            simpson(torque, run.t),
        ]
        change = momentum(plant, run)[-1] - momentum(plant, run)[0]
        return np.abs(change - impulse) / (1 + np.abs(change))

    check_that_defect_vanishes_with_the_step(
        defect, plant, state, constant(load[:4]), push=pushes_of(load)
    )


@whole_runs
@given(plants(), states, loads.map(lambda x: 0.2 * x))
def test_energy_changes_by_the_work_of_forces_and_damping(plant, state, load):
    def defect(run):
        _, _, velocity = masses_moving(plant, run)
        moving, turning = velocity[:, :2].reshape(-1, 4), rates(run)[:, 4:]
        power = (
            moving @ (load[:4] + load[4:8])
            + velocity[:, 2] @ load[8:10]
            + run["theta3_dot"] * load[10]
            - moving**2 @ plant.vehicle_drag
            - turning**2 @ plant.swing_damping
        )
        work = simpson(power, run.t)
        change = energy(plant, run)[-1] - energy(plant, run)[0]
        return np.abs(change - work) / (1 + np.abs(change))

    check_that_defect_vanishes_with_the_step(
        defect, plant, state, constant(load[:4]), push=pushes_of(load)
    )


@whole_runs
@given(plants(**free_of_damping), states, st.tuples(*[st.floats(-3.0, 3.0)] * 4))
def test_motion_is_the_same_from_another_place_and_a_moving_frame(plant, state, change):
    shift, boost = np.array(change[:2]), np.array(change[2:])
    moved = replace(
        state, bar=tuple(state.bar + shift), bar_velocity=tuple(state.bar_velocity + boost)
    )
    run, other = (
        ml.simulate(released_from(plant, start, DURATION), no_force) for start in (state, moved)
    )
    rows = min(len(run.t), len(other.t))
    travelled = np.tile(shift + boost * run.t[:rows, None], 2)
    np.testing.assert_allclose(
        coordinates(other)[:rows],
        coordinates(run)[:rows] + np.pad(travelled, [(0, 0), (0, 3)]),
        rtol=0,
        atol=1e-10,
    )


def mirrored_vehicles(x):
    """[y1, z1, y2, z2] of the mirror image, in which the vehicles change places."""
    return [-x[2], x[3], -x[0], x[1]]


def swapped(table, *names):
    return table | {name: table[name][::-1] for name in names}


@whole_runs
@given(plants(), states, loads.map(lambda x: 0.2 * x))
def test_mirror_image_of_a_run_is_the_run_of_the_mirror_image(plant, state, load):
    goal = [0.5, 1.0, 0.5 + plant.bar_length, 1.0 + np.diff(plant.cable_length)[0]]
    controller = {
        "law": "energy_coupled", "k_lambda": 0.6, "rate": 100.0,
        "k_p": [[5.0, 6.0], [7.0, 8.0]], "k_d": [[3.0, 4.0], [5.0, 6.0]],
        "gamma": [[0.5, 0.7], [0.9, 1.1]], "d_hat_start": [[0.1, 0.2], [0.3, 0.4]],
        "k_i": [[1.0, 2.0], [3.0, 4.0]],
    }  # fmt: skip
    image = replace(
        plant,
        vehicle_mass=plant.vehicle_mass[::-1],
        cable_length=plant.cable_length[::-1],
        vehicle_drag=(*plant.vehicle_drag[2:], *plant.vehicle_drag[:2]),
        swing_damping=(*plant.swing_damping[1::-1], plant.swing_damping[2]),
    )
    theta, theta_dot = state.theta, state.theta_dot
    image_state = State(
        bar=(-state.bar[0], state.bar[1]),
        theta=(theta[1], theta[0], -theta[2]),
        bar_velocity=(-state.bar_velocity[0], state.bar_velocity[1]),
        theta_dot=(theta_dot[1], theta_dot[0], -theta_dot[2]),
    )
    pushed = mirrored_vehicles(load[4:8])
    image_load = np.array([0.0] * 4 + [*pushed, -load[8], load[9], -load[10]])
    gains = ("k_p", "k_d", "gamma", "d_hat_start", "k_i")

    run, other = (
        ml.simulate(released_from(p, x, DURATION, controller=c, push=pushes_of(f),
                                  goal={"vehicle_position": np.reshape(g, (2, 2)).tolist()}))
        for p, x, c, f, g in (
            (plant, state, controller, load, goal),
            (image, image_state, swapped(controller, *gains), image_load, mirrored_vehicles(goal)),
        )
    )  # fmt: skip
    assert (run.status, len(run.t)) == (other.status, len(other.t))
    expected = coordinates(run) @ np.diag([-1, 1, -1, 1, 1, 1, -1])
    expected = expected[:, [2, 3, 0, 1, 5, 4, 6]]
    np.testing.assert_allclose(coordinates(other), expected, rtol=0, atol=1e-9)
    np.testing.assert_allclose(
        commands(other), np.transpose(mirrored_vehicles(commands(run).T)), rtol=0, atol=1e-8
    )


@pytest.mark.parametrize("law", COMPILED)
@pytest.mark.parametrize("name", SHIPPED)
def test_the_cables_ends_stay_on_the_bar(name, law):
    run = ml.simulate(ml.load(name), law)
    assert run.finished
    assert run.closure_residual < 1e-9  # m
