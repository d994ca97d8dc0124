"""Each firmware's motors are our rotors: its mixer turns our vehicles the way it means to."""

import math

import multilift as ml
import numpy as np
import pytest
from multilift.errors import ScenarioError
from multilift.flight.link.firmware import ARDUPILOT as LINK_ARDUPILOT
from multilift.flight.link.firmware import PX4 as LINK_PX4
from multilift.flight.sitl import motors, parameters
from multilift.flight.sitl.physics import Physics

#: What more thrust of motors 1 to 4 does to roll, pitch and yaw, FRD: front right and rear left
#: turn counterclockwise, front left and rear right clockwise. ArduPilot's add_motor of
#: MOTOR_FRAME_TYPE_X has them at 45, -135, -45 and 135 degrees from the front, clockwise.
ANGLES = np.radians([45.0, -135.0, -45.0, 135.0])
SPIN = np.array([1, 1, -1, -1])
ARDUPILOT = {"roll": -np.sin(ANGLES), "pitch": np.cos(ANGLES), "yaw": SPIN}


def px4_mixer(values):
    """PX4's control allocation, from rotor places and spins: upward thrust times its arm, drag."""
    place = np.array([[values[f"CA_ROTOR{k}_P{a}"] for a in "XY"] for k in range(4)])
    spin = np.array([values[f"CA_ROTOR{k}_KM"] for k in range(4)])
    return {"roll": -place[:, 1], "pitch": place[:, 0], "yaw": spin}


def flown(frame_angle="45 deg"):
    return ml.load("bar_from_floor").with_values({"vehicle.frame_angle": frame_angle})


def turn(scenario, mixer):
    """Angular accelerations, FRD, of a vehicle in the air whose motors get a little of a mixer."""
    mixer = np.asarray(mixer) / np.abs(mixer).max()
    high = scenario.with_values(
        {"start.payload_position": [0.0, 0.0, 3.0],
         "start.vehicle_position": [[-0.75, 0.0, 4.2], [0.75, 0.0, 4.2]]}
    )  # fmt: skip
    physics = Physics(high)
    command = np.sqrt(0.5 + 0.1 * mixer)
    before = np.array(physics.motions[1].rate)
    # Motor lag first; then a moment in which nothing has turned far.
    for _ in range(5):
        physics.advance([(0.7,) * 4, tuple(command)], 0.002)
    return np.array(physics.motions[1].rate) - before


@pytest.mark.parametrize("axis", ["roll", "pitch", "yaw"])
@pytest.mark.parametrize("firmware", ["px4", "ardupilot"])
def test_a_mixer_turns_the_vehicle_about_its_axis_and_no_other(firmware, axis):
    scenario = flown()
    mixer = ARDUPILOT if firmware == "ardupilot" else px4_mixer(
        parameters.of_vehicle("px4", scenario, 1)
    )  # fmt: skip
    k = ["roll", "pitch", "yaw"].index(axis)
    turned = turn(scenario, mixer[axis])
    assert turned[k] > 0
    others = np.delete(turned, k)
    assert np.abs(others).max() < 1e-6 * turned[k]


@pytest.mark.parametrize("angle", [0.0, 20.0, 45.0, 70.0])
def test_px4_is_told_the_rotor_places_of_any_frame(angle):
    scenario = flown(f"{angle} deg")
    mixer = px4_mixer(parameters.of_vehicle("px4", scenario, 1))
    for k, axis in enumerate(("roll", "pitch", "yaw")):
        turned = turn(scenario, mixer[axis])
        assert turned[k] > 0
        # Places are told to hundredths of a millimetre.
        assert np.abs(np.delete(turned, k)).max() < 1e-3 * turned[k]


def test_ardupilot_is_told_its_frame_and_has_none_for_others():
    assert parameters.of_vehicle("ardupilot", flown(), 0)["FRAME_TYPE"] == 1
    assert parameters.of_vehicle("ardupilot", flown(0.0), 0)["FRAME_TYPE"] == 0
    with pytest.raises(ScenarioError, match=r"frame_angle.*\n.*45 deg"):
        parameters.of_vehicle("ardupilot", flown("20 deg"), 0)


def test_hover_thrust_lifts_the_vehicle_and_its_share():
    scenario = flown()
    share = parameters.hover_share(scenario, 0)
    top = 4 * 8.5e-6 * 950.0**2
    assert share * top == pytest.approx((1.486 + 0.386 / 2) * 9.8)
    heavy = scenario.with_values({"plant.payload_mass": 100.0})
    with pytest.raises(ScenarioError, match="does not lift"):
        parameters.hover_share(heavy, 0)


def test_pulses_and_controls_are_parts_of_full_speed():
    assert motors.from_pwm([0, 1000, 1500, 2500] + [1000] * 12) == (0.0, 0.0, 0.5, 1.0)
    assert motors.from_controls([0.5, math.nan, -0.5, 1.5], armed=True) == (0.5, 0.0, 0.0, 1.0)
    assert motors.from_controls([0.5] * 4, armed=False) == (0.0,) * 4


@pytest.mark.parametrize("firmware", ["px4", "ardupilot"])
def test_shipped_parameters_have_names_that_fit_and_numbers(firmware):
    values = {**parameters.shipped(firmware), **parameters.of_vehicle(firmware, flown(), 0)}
    assert len(values) > 20
    for name, value in values.items():
        assert len(name) <= 16
        assert math.isfinite(value)


@pytest.mark.parametrize("firmware", [LINK_PX4, LINK_ARDUPILOT], ids=lambda f: f.name)
def test_shipped_parameters_are_those_without_which_the_link_lets_nobody_arm(firmware):
    shipped = parameters.shipped(firmware.name)
    assert {s.name: shipped.get(s.name) for s in firmware.settings} == {
        s.name: s.value for s in firmware.settings
    }
