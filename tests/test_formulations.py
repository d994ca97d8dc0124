"""The fast formulation against the redundant one, and the laws both must obey."""

from dataclasses import replace

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from multilift import _core
from planar_random import State, gravity_shares, laws, loads, plants, states

EPS = np.finfo(float).eps
# Rounding errors times the condition number of the 3x3 system in the bar's acceleration, below 150
# throughout the box of planar_random. Found at most 100 of the 450 in 50000 states.
ROUND_OFF = 3 * 150 * EPS

up = np.array([0, 1, 0, 1])


def assert_close(found, expected, scale):
    """Equal to round-off of numbers of a given size."""
    assert np.abs(np.asarray(found) - expected).max() <= ROUND_OFF * max(1.0, np.abs(scale).max())


def force_scale(plant, q_ddot, load):
    """Size of the forces that balance in a motion, N."""
    mass = sum(plant.vehicle_mass) + plant.bar_mass
    return mass * (plant.gravity + np.abs(q_ddot).max()) + np.abs(load).max()


def forces_on_vehicles(plant, q_dot, load):
    """Everything but the cables, N."""
    weights = np.repeat(plant.vehicle_mass, 2) * plant.gravity * up
    drag = np.array(plant.vehicle_drag) * q_dot[:4]
    return load[:4] + gravity_shares(plant) + load[4:8] - drag - weights


@laws
@given(plants(), states, loads)
def test_both_formulations_give_the_same_motion_and_forces(plant, state, load):
    q, q_dot = state.seven(plant)
    fast = _core.planar_motion(plant.values, q, q_dot, load)
    reference = _core.planar_redundant_motion(plant.values, q, q_dot, load)
    q_ddot = np.array(reference["q_ddot"])
    scale = force_scale(plant, q_ddot, load)
    assert_close(fast["q_ddot"], q_ddot, q_ddot)
    assert_close(fast["tension"], reference["tension"], scale)
    # What a cable does to its vehicle is the opposite of what it does to the bar.
    of_cables = np.array(fast["cable_force"])
    from_balance = (
        forces_on_vehicles(plant, q_dot, load) - np.repeat(plant.vehicle_mass, 2) * q_ddot[:4]
    )
    assert_close(of_cables, from_balance, scale)
    # The multipliers of the closure are half the difference of the cables' forces.
    assert_close(of_cables[:2] - of_cables[2:], 2 * np.array(reference["mu"]), scale)


@laws
@given(plants(), states, loads)
def test_outside_forces_change_the_momentum_and_nothing_else_does(plant, state, load):
    q, q_dot = state.seven(plant)
    motion = _core.planar_motion(plant.values, q, q_dot, load)
    vehicles = np.repeat(plant.vehicle_mass, 2) * motion["q_ddot"][:4]
    momentum_rate = plant.bar_mass * np.array(motion["bar_acceleration"]) + vehicles.reshape(
        2, 2
    ).sum(0)
    outside = forces_on_vehicles(plant, q_dot, load).reshape(2, 2).sum(0)
    on_bar = load[8:10] - [0, plant.bar_mass * plant.gravity]
    assert_close(momentum_rate, outside + on_bar, force_scale(plant, motion["q_ddot"], load))


@laws
@given(plants(), states)
def test_seven_coordinates_satisfy_the_closure_and_its_rate(plant, state):
    q, q_dot = state.seven(plant)
    # A few roundings of lengths and velocities of size 10.
    assert np.abs(_core.planar_closure(plant.values, q)).max() <= 50 * EPS
    sines, cosines = np.array([_core.sincos(angle) for angle in state.theta]).T
    (l1, l2), l0 = plant.cable_length, plant.bar_length
    end_1 = q_dot[:2] + l1 * q_dot[4] * np.array([cosines[0], sines[0]])
    end_2 = q_dot[2:4] + l2 * q_dot[5] * np.array([-cosines[1], sines[1]])
    turning = l0 * q_dot[6] * np.array([-sines[2], cosines[2]])
    assert np.abs(end_2 - end_1 - turning).max() <= 50 * EPS


@laws
@given(plants(), states)
def test_free_coordinates_invert_the_seven(plant, state):
    q, q_dot = state.seven(plant)
    back = np.array(_core.planar_free_coordinates(plant.values, q, q_dot))
    # A few roundings of numbers of size 10.
    assert np.abs(back - state.flat).max() <= 50 * EPS
    assert (back[2:5] == state.theta).all()
    assert (back[7:] == state.theta_dot).all()


def mirrored(y1, z1, y2, z2):
    """A vector for each vehicle, seen in a mirror that swaps left and right."""
    return -y2, z2, -y1, z1


@laws
@given(plants(), states, loads)
def test_a_mirror_image_moves_as_the_mirror_image(plant, state, load):
    # A positive theta1 carries the cable's lower end to +y, a positive theta2 to -y: they trade
    # places. A positive theta3 lifts end 2, in the mirror end 1: it changes sign, as a torque does.
    def mirrored_seven(x):
        return np.array([*mirrored(*x[:4]), x[5], x[4], -x[6]])

    drag, damping = plant.vehicle_drag, plant.swing_damping
    image = replace(
        plant,
        vehicle_mass=plant.vehicle_mass[::-1],
        cable_length=plant.cable_length[::-1],
        vehicle_drag=drag[2:] + drag[:2],
        swing_damping=(damping[1], damping[0], damping[2]),
    )
    image_load = [*mirrored(*load[:4]), *mirrored(*load[4:8]), -load[8], load[9], -load[10]]
    q, q_dot = state.seven(plant)
    motion = _core.planar_motion(plant.values, q, q_dot, load)
    image_motion = _core.planar_motion(
        image.values, mirrored_seven(q), mirrored_seven(q_dot), image_load
    )
    q_ddot = mirrored_seven(motion["q_ddot"])
    scale = force_scale(plant, q_ddot, load)
    assert_close(image_motion["q_ddot"], q_ddot, q_ddot)
    assert_close(image_motion["tension"], motion["tension"][::-1], scale)


@laws
@given(plants(), states, loads, st.tuples(*[st.floats(-5, 5)] * 4))
def test_motion_depends_on_no_position_and_without_drag_on_no_common_velocity(
    plant, state, load, offset
):
    def motion(p, s):
        return _core.planar_motion(p.values, *s.seven(p), load)

    moved = replace(state, bar=tuple(np.add(state.bar, offset[:2])))
    assert motion(plant, moved) == motion(plant, state)
    dragless = replace(plant, vehicle_drag=(0.0,) * 4)
    carried = replace(state, bar_velocity=tuple(np.add(state.bar_velocity, offset[2:])))
    assert motion(dragless, carried) == motion(dragless, state)


@laws
@given(plants(), st.tuples(*[st.floats(-5, 5)] * 2))
def test_hover_is_an_equilibrium_in_which_each_cable_carries_half_the_bar(plant, bar):
    hover = State(bar, (0.0,) * 3, (0.0,) * 2, (0.0,) * 3)
    motion = _core.planar_motion(plant.values, *hover.seven(plant), np.zeros(11))
    half_weight = plant.bar_mass * plant.gravity / 2
    assert_close(motion["q_ddot"], 0, plant.gravity)
    assert_close(motion["tension"], half_weight, half_weight)


@laws
@given(plants(vehicle_drag=(0.0,) * 4), states)
def test_without_thrust_all_falls_freely_and_no_cable_pulls(plant, state):
    resting = replace(state, bar_velocity=(0.0,) * 2, theta_dot=(0.0,) * 3)
    no_thrust = np.hstack([-gravity_shares(plant), np.zeros(7)])
    motion = _core.planar_motion(plant.values, *resting.seven(plant), no_thrust)
    falling = [*(-plant.gravity * up), 0, 0, 0]
    assert_close(motion["q_ddot"], falling, plant.gravity)
    assert_close(motion["tension"], 0, no_thrust)


@laws
@given(plants(bar_inertia=0.0))
def test_reference_refuses_an_inertialess_bar_whose_centre_both_cables_point_at(plant):
    assume(plant.bar_half_thickness > 0)
    angle = np.arctan(plant.bar_length / (2 * plant.bar_half_thickness))
    aslant = State((0.0,) * 2, (angle, angle, 0.0), (0.0,) * 2, (0.0,) * 3)
    motion = _core.planar_redundant_motion(plant.values, *aslant.seven(plant), np.zeros(11))
    assert not motion["regular"]
