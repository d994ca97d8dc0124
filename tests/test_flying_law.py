"""A law that is stepped from outside is the law of a run."""

import multilift as ml
import numpy as np
import pytest
from multilift.errors import ControllerError, ScenarioError
from multilift.models.spatial import FlyingLaw
from spatial_scenarios import plate
from test_spatial_runs import KINDS

GEOMETRIC = {
    "law": "geometric", "rate": 200.0, "k_position": 4.0, "k_velocity": 4.0, "k_integral": 0.3,
    "k_attitude": 6.0, "k_rate": 5.0, "k_cable": 40.0, "k_cable_rate": 9.0,
}  # fmt: skip
PD = {"law": "pd", "rate": 100.0, "k_p": 4.0, "k_d": 6.0, "gamma": 0.5, "k_i": 0.4,
      "feedforward": 1.0}  # fmt: skip
TIGHT = {"limits.thrust_max": 20.0, "limits.tilt_max": 0.15}


def flown(scenario):
    """The scenario's own law, made again outside and told what a law of one's own is told."""
    law = FlyingLaw(scenario)
    swing = []

    def step(m):
        command = law.update(
            m.t, m.vehicle, m.vehicle_velocity, m.payload, m.payload_attitude, m.payload_velocity,
            m.payload_rate, m.saturated,
        )  # fmt: skip
        swing.append(command.swing)
        assert np.array_equal(law.target(m.t).vehicle, m.vehicle_target)
        return command.asked

    return ml.simulate(scenario, step), swing


@pytest.mark.parametrize("kind", [*KINDS, "geometric", "pd", "limited"])
def test_it_gives_a_runs_forces_to_the_last_bit(kind):
    changes = {
        "geometric": {**KINDS["moving"], "controller": GEOMETRIC},
        "pd": {**KINDS["noisy"], "controller": PD},
        "limited": {"simulation.duration": 1.0, **TIGHT},
    }.get(kind) or KINDS[kind]
    if "controller" in changes:
        changes = {k: v for k, v in changes.items() if k != "controller.feedforward"}
    scenario = plate(changes={**changes, "simulation.record_period": 0.01})
    own = ml.simulate(scenario)
    outside, _ = flown(scenario)
    assert outside.status == own.status
    # A run under a law of one's own knows no estimate and no storage function.
    names = [n for n in own.columns if not n.startswith("d_hat") and n != "storage"]
    for name in names:
        assert np.array_equal(outside[name], own[name]), name


def test_swing_is_that_of_the_run():
    scenario = plate(changes={"simulation.duration": 1.0, "simulation.record_period": 0.01})
    run, swing = flown(scenario)
    # The same sums in another order: round-off of lengths of a metre.
    assert np.allclose(np.array(swing), run.swing(), rtol=0, atol=1e-14)


def measured(scenario):
    """Everything where it starts."""
    payload = scenario.payload_start
    return [
        scenario.vehicle_start[:, :3], scenario.vehicle_start[:, 3:], payload[:3], payload[3:7],
        payload[7:10], payload[10:],
    ]  # fmt: skip


def test_it_learns_and_forgets():
    scenario = plate(changes={"controller.k_i": 0.5})
    law, now = FlyingLaw(scenario), measured(scenario)
    now[1] = now[1] + 0.3
    first = law.update(0.0, *now)
    later = law.update(0.01, *now)
    assert not np.array_equal(first.force, later.force)
    assert np.abs(law.drag_estimate).max() > 0
    law.reset()
    assert np.array_equal(law.update(0.0, *now).force, first.force)


def test_forces_keep_to_the_limits_and_integral_action_rests_there():
    changes = {"controller.k_i": 5.0, "goal.payload_position": [50.0, 0.0, 1.0], **TIGHT}
    scenario = plate(changes=changes)
    law, now = FlyingLaw(scenario), measured(scenario)
    asked = []
    for k in range(20):
        command = law.update(0.01 * k, *now)
        asked.append(command.asked)
        assert command.limited.all()
        assert (np.linalg.norm(command.force, axis=1) <= 20.0 * (1 + 1e-15)).all()
        tilt = np.arctan2(np.hypot(*command.force[:, :2].T), command.force[:, 2])
        assert (tilt <= 0.15 + 1e-12).all()
    # The first period knew of no limit yet.
    assert np.array_equal(asked[2][:, 0], asked[-1][:, 0])


def test_another_scenarios_targets_are_followed_with_what_was_learnt():
    scenario = plate(changes={"controller.k_i": 0.5})
    aside = scenario.with_values({"goal.payload_position": [1.0, 2.0, 1.5]})
    law, other, now = FlyingLaw(scenario), FlyingLaw(aside), measured(scenario)
    law.update(0.0, *now)
    law.follow(aside)
    assert np.array_equal(law.target(0.0).vehicle, other.target(0.0).vehicle)
    assert not np.array_equal(law.update(0.01, *now).force, other.update(0.0, *now).force)


def test_set_points_point_thrust_along_the_force_at_the_heading():
    scenario = plate(changes={"vehicle.type": "x500"})
    law = FlyingLaw(scenario)
    rng = np.random.default_rng(3)
    force = rng.normal([0.0, 0.0, 20.0], 1.0, size=(3, 3))
    for yaw in (0.0, 1.0, 3.0, -2.5):
        attitudes, thrusts = law.set_points(force, yaw)
        for (w, x, y, z), f in zip(attitudes, force, strict=True):
            up = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
            assert np.allclose(up, f / np.linalg.norm(f), atol=1e-14)
            # Body x stands over the heading, turned with the tilt: without it, along it.
            tilt = np.array([1 + up[2], -up[1], up[0], 0.0]) / np.sqrt(2 + 2 * up[2])
            back = tilt * [1, -1, -1, -1]
            turn_w = back[0] * w - back[1:] @ [x, y, z]
            turn_z = back[0] * z + back[3] * w + back[1] * y - back[2] * x
            assert np.isclose(abs(turn_w * np.cos(yaw / 2) + turn_z * np.sin(yaw / 2)), 1.0)
        assert ((thrusts > 0) & (thrusts < 1)).all()


def test_thrust_goes_straight_through_the_hover_thrust():
    law = FlyingLaw(plate(changes={"vehicle.type": "paper_craft"}))
    up = np.array([0.0, 0.0, 1.0])
    hover = np.array([0.4, 0.5, 0.6])
    weight = law.hover_force
    for share in (0.5, 1.0, 1.5):
        _, thrust = law.set_points(share * weight[:, None] * up, 0.0, hover_thrust=hover)
        assert np.allclose(thrust, share * hover, rtol=1e-15)
    _, alone = law.set_points(np.outer([9.0] * 3, up), 0.0, hover_thrust=0.4, hover_force=9.0)
    assert np.allclose(alone, 0.4, rtol=1e-15)


def test_what_cannot_be_meant_is_refused_and_leaves_the_law_as_it_was():
    scenario = plate(changes={"controller.k_i": 0.5})
    law, twin, now = FlyingLaw(scenario), FlyingLaw(scenario), measured(scenario)
    now[1] = now[1] + 0.3
    for place, bad, message in (
        (0, np.zeros((2, 3)), "vehicle measured has the shape"),
        (1, np.full((3, 3), np.nan), "vehicle_velocity measured is not finite"),
        (3, [0.0, 0.0, 0.0, 0.0], "unit quaternion"),
        (5, [np.inf, 0.0, 0.0], "payload_rate measured is not finite"),
    ):
        wrong = [*now]
        wrong[place] = bad
        with pytest.raises(ControllerError, match=message):
            law.update(0.0, *wrong)
    with pytest.raises(ControllerError, match="t measured is not finite"):
        law.update(float("nan"), *now)
    with pytest.raises(ControllerError, match="saturated has 2 entries"):
        law.update(0.0, *now, [True, False])
    assert np.array_equal(law.update(0.0, *now).force, twin.update(0.0, *now).force)
    with pytest.raises(ControllerError, match="hover_thrust"):
        law.set_points(np.ones((3, 3)), 0.0)
    with pytest.raises(ControllerError, match="hover_thrust is"):
        law.set_points(np.ones((3, 3)), 0.0, hover_thrust=0.0)
    with pytest.raises(ControllerError, match="forces are"):
        law.set_points(np.ones((2, 3)), 0.0, hover_thrust=0.5)
    with pytest.raises(ScenarioError, match=r"plant\.model"):
        FlyingLaw(ml.load("sim1"))
    with pytest.raises(ScenarioError, match=r"plant\.vehicles"):
        law.follow(plate(2))
