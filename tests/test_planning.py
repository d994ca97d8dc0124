"""Planned moves: limits, flatness, shapers' theory, and what the tracking law makes of them."""

from __future__ import annotations

import math

import multilift as ml
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift import planning
from multilift.errors import PlanningError, ScenarioError
from multilift.models.planar import swing_mode
from multilift.models.planar.tables import ACTUATORS, SENSORS
from multilift.planning import Limits, Mode, Pendulum
from random_moves import greatest, random_moves

PENDULUM = Pendulum(1.8, 9.8)
LIMITS = {"speed_max": 1.5, "acceleration_max": 2.0, "jerk_max": 15.0, "snap_max": 150.0}


@pytest.mark.parametrize("part", [0.0, 0.1, 0.5])
def test_limits_hold_on_random_moves(part):
    moves = list(random_moves(4000, round(10 * part), part))
    ways = [planning.move(s, g, limits, goal_velocity=v) for s, g, limits, v in moves]
    # A start that rushes towards one limit while another holds it cannot always be saved.
    planned = [k for k, way in enumerate(ways) if way.pieces]
    assert len(planned) >= (1.0 if part == 0.0 else 0.6) * len(ways)
    allowed = np.array([moves[k][2].numbers for k in planned])
    assert (greatest([ways[k] for k in planned]) <= allowed * (1 + 1e-6)).all()


@given(
    seed=st.integers(0, 2**32 - 1),
    part=st.sampled_from([0.0, 0.1, 0.3]),
)
@settings(max_examples=60, deadline=None)
def test_a_move_begins_and_ends_where_it_shall_and_is_smooth(seed, part):
    ((start, goal, limits, moving),) = random_moves(1, seed, part)
    way = planning.move(start, goal, limits, goal_velocity=moving)
    if not way.pieces:
        return
    scale = 1e-7 * (1.0 + np.abs(start).max() + np.abs(limits.numbers).max())
    assert way.at(0.0) == pytest.approx(start, abs=scale)
    for begin, _ in way.pieces[1:]:
        assert way.at(np.nextafter(begin, 0.0)) == pytest.approx(way.at(begin), abs=scale)
    if moving is None:
        assert way.at(way.end) == pytest.approx(planning.state(goal), abs=scale)
    else:
        late = way.pieces[-1][0] + 1.0
        assert way.at(late) == pytest.approx(
            planning.state(goal + late * moving, moving), abs=scale
        )


@given(part=st.floats(0.0, 0.95))
@settings(max_examples=40, deadline=None)
def test_a_move_planned_again_on_its_way_stays_as_it_is(part):
    limits = Limits(1.5, 2.0, 10.0, 80.0)
    way = planning.move(planning.state([0.0, 0.0]), [1.2, 0.3], limits)
    done = part * way.end
    again = planning.move(way.at(done), [1.2, 0.3], limits, remaining=way.end - done)
    assert again.end == pytest.approx(way.end - done)
    middle = 0.5 * again.end
    assert again.at(middle)[:, :3] == pytest.approx(way.at(done + middle)[:, :3], abs=1e-7)


@given(part=st.floats(0.0, 1.0), aside=st.floats(-0.5, 0.5))
@settings(max_examples=40, deadline=None)
def test_a_goal_that_jumps_is_reached_within_the_limits(part, aside):
    """From any state on a planned way, one that used 80 % of the limits."""
    limits = Limits(1.5, 2.0, 10.0, 80.0)
    within = Limits(*(0.8 * x for x in limits.numbers))
    way = planning.move(planning.state([0.0, 0.0]), [1.2, 0.3], within)
    again = planning.move(way.at(part * way.end), [1.2 + aside, 0.3], limits)
    assert again.pieces
    assert (greatest([again], 100)[0] <= np.array(limits.numbers) * (1 + 1e-6)).all()
    assert again.at(again.end) == pytest.approx(planning.state([1.2 + aside, 0.3]), abs=1e-6)


@pytest.mark.parametrize(("kind", "peaks"), [("flat", 622.5327356), ("least_snap", 384.0)])
def test_from_rest_the_duration_is_the_closed_form(kind, peaks):
    limits = Limits(100.0, 100.0, 1000.0, 50.0)
    if kind == "flat":
        way = planning.move(planning.state([0.0, 0.0, 0.0]), [0.0, 0.6, 0.8], limits)
    else:
        way = planning.least_snap_move([0.0, 0.0, 0.0], [0.0, 0.6, 0.8], limits)
    assert way.end == pytest.approx((peaks / 50.0) ** 0.25, rel=1e-9)
    assert greatest([way], 400)[0, 3] == pytest.approx(50.0, rel=1e-4)


# --- shapers -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["zv", "zvd", "ei"])
@pytest.mark.parametrize("damping", [0.0, 0.02, 0.2])
def test_shapers_weigh_one_and_leave_what_theory_says(kind, damping):
    mode = Mode(2.3, damping)
    impulses = planning.shaper(kind, mode, 0.05)
    assert sum(weight for _, weight in impulses) == pytest.approx(1.0)
    left = planning.residual(impulses, mode)
    if kind != "ei":
        assert left == pytest.approx(0.0, abs=1e-12)
    elif damping == 0.0:
        assert left == pytest.approx(0.05)


def test_robustness_to_the_frequency_is_of_the_order_that_theory_says():
    mode = Mode(2.0)

    def left(kind: str, ratio: float) -> float:
        return planning.residual(planning.shaper(kind, mode), Mode(ratio * mode.frequency))

    for error in (1e-3, -1e-3):
        # ZV leaves |cos(pi r / 2)|, ZVD its square: of first and of second order.
        assert left("zv", 1 + error) == pytest.approx(abs(error) * math.pi / 2, rel=1e-3)
        assert left("zvd", 1 + error) == pytest.approx((error * math.pi / 2) ** 2, rel=1e-3)
    # EI stays at its 5 % over the widest band; here are its ends by |(1+V)/2 cos(pi r) + (1-V)/2|.
    r = np.linspace(0.6, 1.4, 801)
    width = {k: np.mean([left(k, x) <= 0.05 + 1e-9 for x in r]) for k in ("zv", "zvd", "ei")}
    assert width["zv"] < 0.5 * width["zvd"] < width["zvd"] < width["ei"]
    theory = [abs(0.525 * math.cos(math.pi * x) + 0.475) for x in r]
    assert [left("ei", x) for x in r] == pytest.approx(theory, abs=1e-12)


def test_the_mode_of_held_vehicles_is_a_pendulum_where_cables_are_alike():
    scenario = ml.load("sim1")
    mode = swing_mode.of_held_vehicles(
        scenario.plant_values(), np.array(scenario["goal.vehicle_position"])
    )
    assert mode.frequency == pytest.approx(math.sqrt(9.8 / 1.8), rel=1e-9)
    # Two angles of 0.02 N m s each against m l^2 of the bar.
    assert mode.damping == pytest.approx(0.04 / (0.8 * 1.8**2) / (2 * mode.frequency), rel=1e-6)


@pytest.mark.parametrize("kind", ["zv", "zvd"])
def test_what_a_shaper_leaves_vanishes_faster_than_the_move(kind):
    """Zero in the linear limit: the last lean, beside the greatest, falls with the square."""
    impulses = planning.shaper(kind, Mode(math.sqrt(9.8 / 1.8)))
    limits = Limits(3.0, 4.0, 40.0, 400.0)
    left = []
    for size in (0.8, 0.4, 0.2):
        # The same duration for each size: the limits shrink with it.
        within = Limits(*(size * x for x in limits.numbers))
        way = planning.shaped_move([0.0, 0.0], [size, 0.0], within, impulses, PENDULUM)
        last = way.pieces[-1][0]
        # Lean is horizontal acceleration over gravity; together with its rate it is the swing.
        _, v, a, _, _ = way.at(last)[0]
        swing = math.hypot(a / 9.8, v / math.sqrt(9.8 * 1.8))
        left.append(swing / max(abs(way.at(t)[0, 2]) / 9.8 for t in np.linspace(0, last, 200)))
    orders = np.log2(np.array(left[:-1]) / left[1:])
    assert (orders > 1.8).all()


# --- two parts -----------------------------------------------------------------------------------


@given(
    angle=st.floats(-0.3, 0.3), rate=st.floats(-0.4, 0.4), goal=st.floats(-3.0, 3.0),
    moving=st.floats(-0.4, 0.4),
)  # fmt: skip
@settings(max_examples=40, deadline=None)
def test_the_antiswing_part_ends_any_swing_within_the_limits(angle, rate, goal, moving):
    limits = Limits(3.0, 6.0, 40.0)
    lean = [math.sin(angle), math.cos(angle)]
    lean_rate = [rate * lean[1], -rate * lean[0]]
    way = planning.antiswing_move(
        [0.0, 0.0], [0.0, 0.0], lean, lean_rate, [goal, 0.5], limits, 0.7, PENDULUM,
        goal_velocity=[moving, 0.0], load=False,
    )  # fmt: skip
    assert way.pieces
    tops = greatest([way])[0]
    # Between knots the vehicles' way is a polynomial through what was checked at the knots.
    assert (tops[:3] <= np.array(limits.numbers[:3]) * 1.01).all()
    late = way.end if math.isfinite(way.end) else way.pieces[-1][0] + 1.0
    expected = planning.state([goal + moving * late, 0.5], [moving, 0.0])
    assert way.at(late) == pytest.approx(expected, abs=1e-6)


# --- runs ----------------------------------------------------------------------------------------


MOVES = ["sim1", "sim2", "exp1_1", "exp1_2"]


def ideal(name: str, **reference: object) -> ml.Scenario:
    """A shipped scenario without what the testbed adds, and with a reference."""
    perfect = {
        f"{table.name}.{f.name}": f.default for table in (ACTUATORS, SENSORS) for f in table.fields
    }
    return ml.load(name).with_values(
        {
            **perfect,
            "controller.rate": 1000.0,
            **{f"reference.{k}": v for k, v in reference.items()},
        }
    )


def swing_after(run: ml.Run, time: float) -> float:
    """Greatest |theta_1| or |theta_2| from a time on, deg."""
    late = run["t"] >= time
    return float(np.degrees(max(np.abs(run[name][late]).max() for name in ("theta1", "theta2"))))


@pytest.mark.parametrize("name", [*MOVES, "exp2"])
@pytest.mark.parametrize("kind", ["flat", "least_snap", "zv", "zvd", "ei", "antiswing"])
def test_no_plan_leaves_swing(name, kind):
    scenario = ideal(name, kind=kind, **LIMITS)
    quiet = scenario.with_values({"simulation.duration": 12.0}) if name != "exp2" else scenario
    run = ml.simulate(quiet.with_values({"push": []}) if name == "exp2" else quiet)
    assert run.status == "finished"
    assert swing_after(run, quiet.path[1]) < 0.5


@pytest.mark.parametrize("law", ["energy_coupled", "pd"])
def test_a_target_that_rests_is_the_papers_law_to_the_last_bit(law):
    """The tracking law with constant places, under pushes, lag and noise."""
    paper = ml.load("exp2").with_values({"plant.gravity": 3.7, "simulation.duration": 6.0})
    moving = paper.with_values({"reference.kind": "flat"})
    assert moving.moves_target()
    step, tracked = ml.simulate(paper, law), ml.simulate(moving, law)
    for column in ("y1", "z2", "theta1", "theta3", "u1", "u2", "u3", "u4"):
        assert np.array_equal(step[column], tracked[column])
    assert step.audit["actuation"] == tracked.audit["actuation"]
    assert tracked.audit["reference"] == 0.0


@pytest.mark.parametrize("law", ["energy_coupled", "pd"])
@pytest.mark.parametrize("kind", ["flat", "antiswing"])
def test_the_audit_closes_along_a_way(law, kind):
    scenario = ideal("exp1_1", kind=kind, **LIMITS).with_values(
        {
            "plant.vehicle_mass": [1.4, 1.8],
            "simulation.duration": 8.0,
            "push": [
                {"body": "vehicle_1", "start": 0.5, "duration": 1.0, "force": [1.0, 0.3],
                 "shape": "half_sine"},
                {"body": "bar", "start": 1.0, "duration": 0.7, "force": [0.5, 0.0],
                 "shape": "half_sine"},
            ],
        }
    )  # fmt: skip
    errors = []
    for step in (0.002, 0.001):
        run = ml.simulate(
            scenario.with_values({"simulation.step": step, "controller.rate": 500.0}), law
        )
        assert abs(run.audit["reference"]) > 1e-3
        errors.append(run.audit["largest_integration_error"])
    # Fourth order, but where knots and pushes fall between stages; either way it is not a balance
    # that lacks an entry: those here are of a tenth of a joule and more.
    assert errors[1] < 1e-5


def test_flatness_is_exact_for_any_plant_without_damping():
    """Without damping nothing is left to feedback but what holding a command costs."""
    scenario = ml.load("sim1").with_values(
        {
            "plant.vehicle_mass": [2.0, 1.3],
            "plant.cable_length": [1.8, 1.2],
            "plant.bar_half_thickness": 0.2,
            "plant.bar_inertia": 0.1,
            "plant.vehicle_drag": 0.0,
            "plant.swing_damping": 0.0,
            "start.vehicle_position": [[0.0, 3.0], [1.8, 2.4]],
            "goal.vehicle_position": [[1.0, 3.5], [2.8, 2.9]],
            "reference.kind": "flat",
            "reference.duration": 2.0,
            "simulation.duration": 3.0,
            "simulation.step": 0.0005,
        }
    )
    error = []
    for rate in (500.0, 1000.0, 2000.0):
        run = ml.simulate(scenario.with_values({"controller.rate": rate}))
        error.append(np.hypot(run["y1"][-1] - 1.0, run["z1"][-1] - 3.5))
        bar = max(np.abs(run["theta3"]))
    # A held command is half a period old.
    assert error[0] / error[1] == pytest.approx(2.0, rel=0.1)
    assert error[1] / error[2] == pytest.approx(2.0, rel=0.1)
    assert error[2] < 2e-3 and bar < 0.01


JUMPING = {
    "kind": "flat",
    "times": [0.5, 1.3, 5.0],
    "points": [0.6, 3.2, -0.4, 2.9, 1.2, 3.5],
    "speed_max": 2.0, "acceleration_max": 4.0, "jerk_max": 20.0, "snap_max": 300.0,
}  # fmt: skip


def test_a_goal_that_jumps_in_mid_move_keeps_limits_and_leaves_no_swing():
    scenario = ideal("sim1", damping=True, lead=0.0005, **JUMPING).with_values(
        {"simulation.duration": 12.0}
    )
    pieces, end = scenario.path
    starts = [begin for begin, _ in pieces]
    assert starts == sorted(starts) and 0.5 in starts and 1.3 in starts and 5.0 in starts
    limits = Limits(*(JUMPING[f"{n}_max"] for n in Limits.names))

    def at(time: float, k: int) -> np.ndarray:
        rows = np.array(pieces[k][1])
        derivatives = [np.polynomial.Polynomial(r).deriv(n) for n in range(5) for r in rows]
        return np.array([d(time - pieces[k][0]) for d in derivatives]).reshape(5, 2)

    for k in range(len(pieces)):
        until = pieces[k + 1][0] if k + 1 < len(pieces) else end
        inside = np.array([at(t, k) for t in np.linspace(pieces[k][0], until, 200)])
        sizes = np.linalg.norm(inside[:, 1:], axis=2).max(axis=0)
        assert (sizes <= np.array(limits.numbers) * (1 + 1e-6)).all()
        if k + 1 < len(pieces):
            assert at(until, k) == pytest.approx(at(until, k + 1), abs=1e-6)
    # The first goal is given up in mid-move.
    assert np.abs(at(1.3, starts.index(1.3))[1]).max() > 0.1
    run = ml.simulate(scenario)
    assert run.status == "finished"
    assert swing_after(run, end) < 0.01
    last = np.array([run[c][-1] for c in ("y1", "z1")])
    assert last == pytest.approx(scenario["goal.vehicle_position"][0], abs=1e-3)
    assert run.audit["largest_integration_error"] < 1e-5


def test_a_goal_told_again_changes_nothing():
    """Rest on the way is rest: the same goal once more after the move has ended."""
    once = {**JUMPING, "times": [0.5], "points": [1.2, 3.5]}
    twice = {**JUMPING, "times": [0.5, 4.0], "points": [1.2, 3.5, 1.2, 3.5]}
    runs = [ml.simulate(ideal("sim1", **r)) for r in (once, twice)]
    assert runs[0]["y1"] == pytest.approx(runs[1]["y1"], abs=1e-9)


def left_without_feedback(damped: bool, drag: float, swing: float) -> float:
    """How far all is from rest at the goal after a move that forces alone make; m, rad and 1/s.

    Commands are held for a step, and given half a step ahead: what that leaves is of second order.
    """
    step = 0.0005
    scenario = ml.load("sim1").with_values(
        {
            "plant.vehicle_mass": [2.0, 1.3],
            "plant.cable_length": [1.8, 1.2],
            "plant.bar_half_thickness": 0.2,
            "plant.bar_inertia": 0.1,
            "plant.vehicle_drag": drag,
            "plant.swing_damping": [swing, 0.5 * swing, 0.0],
            "start.vehicle_position": [[0.0, 3.0], [1.8, 2.4]],
            "goal.vehicle_position": [[1.0, 3.5], [2.8, 2.9]],
            "controller.k_p": 1e-9,
            "controller.k_d": 1e-9,
            "controller.gamma": 1e-9,
            "controller.rate": 1.0 / step,
            "reference.kind": "flat",
            "reference.duration": 2.0,
            "reference.lead": 0.5 * step,
            "reference.damping": damped,
            "simulation.duration": 2.2,
            "simulation.step": step,
        }
    )
    run = ml.simulate(scenario, "pd")
    last = [run["y1"][-1] - 1.0, run["z1"][-1] - 3.5, run["y2"][-1] - 2.8, run["z2"][-1] - 2.9]
    return float(np.linalg.norm([*last, *(run[f"theta{k}"][-1] for k in (1, 2, 3))]))


def test_forces_along_the_way_make_up_for_drag():
    assert left_without_feedback(False, 0.5, 0.0) > 0.05
    assert left_without_feedback(True, 0.5, 0.0) < 2.0 * left_without_feedback(False, 0.0, 0.0)
    assert left_without_feedback(True, 0.5, 0.0) < 1e-5


def test_what_swing_damping_leaves_is_of_second_order():
    """The cables' lag is expanded to the first."""
    left = [left_without_feedback(True, 0.3, swing) for swing in (0.2, 0.1, 0.05)]
    orders = np.log2(np.array(left[:-1]) / left[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.25)
    assert left[-1] < 0.1 * left_without_feedback(False, 0.0, 0.05)


@pytest.mark.parametrize("name", MOVES)
def test_with_damping_counted_hardly_any_swing_is_left(name):
    counted = ideal(name, kind="flat", damping=True, lead=0.0005, **LIMITS)
    left = {}
    for damped in (False, True):
        scenario = counted.with_values({"reference.damping": damped, "simulation.duration": 8.0})
        left[damped] = swing_after(ml.simulate(scenario), scenario.path[1])
    assert left[True] < min(0.05, 0.3 * left[False])


def test_the_audit_closes_where_the_way_counts_damping():
    scenario = ideal("exp1_1", kind="flat", damping=True, **LIMITS).with_values(
        {"simulation.duration": 4.0, "controller.rate": 500.0, "simulation.step": 0.001}
    )
    run = ml.simulate(scenario)
    assert abs(run.audit["reference"]) > 1e-3
    assert run.audit["largest_integration_error"] < 1e-5


def test_a_batch_counts_each_worlds_damping_to_the_last_bit():
    scenario = ideal("exp1_2", kind="flat", damping=True, **LIMITS).with_values(
        {"simulation.duration": 2.0}
    )
    key, damping = "plant.swing_damping[0]", [0.0, 0.02, 0.05]
    batch = ml.simulate_batch(scenario, {key: damping})
    for k, value in enumerate(damping):
        alone = ml.simulate(scenario.with_values({key: value}))
        assert batch.metrics["peak_swing_1"][k] == alone.metrics["peak_swing_1"]
        assert batch.audit["reference"][k] == alone.audit["reference"]


def test_a_batch_follows_the_same_way_to_the_last_bit():
    scenario = ideal("exp1_2", kind="flat", **LIMITS).with_values({"simulation.duration": 2.0})
    masses = [0.3, 0.386, 0.5]
    batch = ml.simulate_batch(scenario, {"plant.bar_mass": masses})
    for k, mass in enumerate(masses):
        alone = ml.simulate(scenario.with_values({"plant.bar_mass": mass}))
        assert batch.metrics["peak_swing_1"][k] == alone.metrics["peak_swing_1"]
        assert batch.audit["reference"][k] == alone.audit["reference"]


def test_a_lead_makes_up_for_actuators_that_lag():
    way = {"kind": "flat", **LIMITS}
    lag = {
        "actuators.thrust_time_constant": 0.1,
        "actuators.attitude_time_constant": 0.1,
        "actuators.command_delay": 0.02,
    }
    late = ideal("exp1_1", **way).with_values(lag)
    ahead = late.with_values({"reference.lead": 0.12})
    left = [ml.simulate(s).metrics["swing_integral"] for s in (late, ahead)]
    swings = [swing_after(ml.simulate(s), s.path[1]) for s in (late, ahead)]
    assert left[1] < left[0]
    assert swings[1] < 0.6 * swings[0]


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"reference.kind": "fast"}, "reference.kind"),
        ({"reference.kind": "flat", "reference.duration": -1.0}, "reference.duration"),
        ({"reference.kind": "ei", "reference.tolerance": 1.0}, "reference.tolerance"),
        (
            {"reference.kind": "antiswing", "reference.damping_ratio": 1.5},
            "reference.damping_ratio",
        ),
        ({"reference.kind": "waypoints"}, "reference.times"),
        (
            {"reference.kind": "waypoints", "reference.times": [1.0, 2.0],
             "reference.points": [0.0, 0.0]},
            "reference.points",
        ),
        (
            {"reference.kind": "zv", "start.angle": [0.1, -0.1, 0.0]},
            "reference.kind",
        ),
        (
            {"reference.kind": "flat", "start.angle": [0.1, -0.1, 0.0], "reference.start": 1.0},
            "reference.start",
        ),
        ({"reference.kind": "ei", "reference.damping": True}, "reference.damping"),
        ({"reference.kind": "flat", "reference.points": [1.2, 3.5]}, "reference.times"),
        (
            {"reference.kind": "flat", "reference.duration": 2.0, "reference.times": [1.0],
             "reference.points": [1.2, 3.5]},
            "reference.duration",
        ),
        (
            {"reference.kind": "flat", "reference.damping": True, "controller.d_hat_start": 0.1},
            "reference.damping",
        ),
        ({"reference.kind": "zv", "plant.gravity": 0.0}, "plant.gravity"),
        (
            {"reference.kind": "flat", "goal.allow_mismatch": True,
             "goal.vehicle_position": [[1.2, 3.5], [3.2, 3.5]]},
            "goal.vehicle_position",
        ),
        (
            {"reference.kind": "flat", "start.angle": [0.5, -0.5, 0.0],
             "reference.acceleration_max": 0.1},
            "reference",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_planned_is_refused(values, key):
    with pytest.raises(ScenarioError) as caught:
        ml.load("sim1").with_values(values)
    assert caught.value.key == key


def test_what_a_way_excludes_is_refused():
    scenario = ideal("sim1", kind="flat")
    with pytest.raises(ScenarioError, match="same for all"):
        ml.simulate_batch(scenario, {"goal.vehicle_position[0][0]": [1.2, 1.2]})
    with pytest.raises(ScenarioError, match="without derivatives"):
        ml.gradient(scenario, ["plant.bar_mass"])


@pytest.mark.parametrize(
    "call",
    [
        lambda: Limits(0.0, 1.0, 1.0),
        lambda: Mode(1.0, 1.0),
        lambda: Pendulum(-1.0),
        lambda: planning.move(planning.state([0.0]), [1.0], Limits(1.0, 1.0, 1.0)),
        lambda: planning.move(planning.state([0.0, 0.0]), [1.0, np.nan], Limits(1.0, 1.0, 1.0)),
        lambda: planning.timed_move(planning.state([0.0, 0.0]), [1.0, 0.0], 0.0),
        lambda: planning.least_snap_move([0.0, 0.0], [1.0, 0.0]),
        lambda: planning.shaper("zvdd", Mode(1.0)),
    ],
)
def test_bad_numbers_are_refused(call):
    with pytest.raises(PlanningError, match="permitted"):
        call()
