"""Bounds of moves: closed forms, equations against the core, limits, the check on the plant."""

import json

import multilift as ml
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from multilift import _core, saved
from multilift.errors import MultiliftError, OutputError, ScenarioError
from planar_random import laws, loads, plants, states
from spatial_scenarios import plate
from test_cli import multilift

ca = pytest.importorskip("casadi")

from multilift import limit  # noqa: E402
from multilift.limit import bound, collocation, output  # noqa: E402
from multilift.limit.mesh import Mesh  # noqa: E402
from multilift.limit.move import Instant, Move  # noqa: E402
from multilift.models.planar import move as planar  # noqa: E402
from multilift.models.spatial import move as spatial  # noqa: E402

few = settings(max_examples=8, deadline=None, database=None)


def linear(residual, way, most, guess):
    """A move of linear equations by one input within +-most."""
    one = np.ones(1)
    return Move(
        equations=lambda q, v, a, u: Instant(residual(q, a, u), ca.SX(0, 1), q),
        start=np.zeros(len(way)), goal=np.array(way), input_start=0 * one, input_goal=0 * one,
        input_scale=most * one, input_lower=-most * one, input_upper=most * one,
        lower=np.zeros(0), upper=np.zeros(0), limit_names=(), time_guess=guess,
    )  # fmt: skip


def pushed(way, most, guess):
    return linear(lambda q, a, u: a - u, [way], most, guess)


@few
@given(way=st.floats(0.1, 10.0), most=st.floats(0.2, 20.0), off=st.floats(0.5, 2.0))
def test_least_time_of_a_double_integrator(way, most, off):
    exact = 2.0 * np.sqrt(way / most)
    found = collocation.refine(pushed(way, most, off * exact), least="time")[-1]
    # The rest of effort beside the time bends it by less than its weight.
    assert found.time == pytest.approx(exact, rel=collocation.REST_OF_EFFORT)


@few
@given(way=st.floats(0.1, 10.0), time=st.floats(0.5, 5.0), count=st.integers(4, 40))
def test_least_effort_of_a_double_integrator_is_the_cubic(way, time, count):
    found = collocation.solve(
        pushed(way, 1e3 * way / time**2, time), Mesh.even(count, 1), least="effort", time=time
    )
    # Held over N intervals, the straight line of inputs costs 1 / (1 - 1/N^2) times as much.
    exact = 12.0 * way**2 / time**3 / (1.0 - count**-2)
    assert found.objective == pytest.approx(exact, rel=1e-6)
    s = found.mesh.edges
    np.testing.assert_allclose(found.q[:, 0], way * (3 * s**2 - 2 * s**3), atol=way * count**-2.0)


def crane_time(way, most, omega):
    """Least time of a trolley with an undamped pendulum, the input its acceleration, by bang-bang.

    The input is odd about the middle; with half the time h and switches s before and after it,
    rest of the pendulum asks 1 - 2 cos(omega s) + cos(omega h) = 0 and the way h^2 - 2 s^2.
    """

    def swinging(h):
        s = np.sqrt(0.5 * (h**2 - way / most))
        return 1.0 - 2.0 * np.cos(omega * s) + np.cos(omega * h)

    h = np.sqrt(way / most) * (1.0 + 1e-12)
    step = 1e-3 * h
    sign = np.sign(swinging(h))
    while np.sign(swinging(h + step)) == sign:
        h += step
    low, high = h, h + step
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if np.sign(swinging(middle)) == sign else (low, middle)
    return 2.0 * high


@few
@given(way=st.floats(0.5, 4.0), most=st.floats(0.8, 3.0), omega=st.floats(0.8, 1.6))
def test_least_time_of_a_crane_that_ends_without_swing(way, most, omega):
    exact = crane_time(way, most, omega)
    crane = linear(
        lambda q, a, u: ca.vertcat(a[0] - u, a[1] + omega**2 * q[1] + u), [way, 0.0], most,
        1.2 * exact,
    )  # fmt: skip
    found = collocation.refine(crane, least="time")
    # Held inputs can only be slower; the last mesh is within its own step of refinement.
    assert exact * (1 - 1e-6) <= found[-1].time <= exact * 1.002
    assert found[-1].time <= found[0].time


def accelerations(equations, plant, q, q_dot, u):
    """Of equations that are zero where accelerations fit."""
    a = ca.SX.sym("a", len(q))
    residual = equations(plant, ca.SX(q), ca.SX(q_dot), a, ca.SX(u))["residual"]
    f = ca.Function("f", [a], [ca.jacobian(residual, a), residual])
    matrix, rest = (np.array(x) for x in f(np.zeros(len(q))))
    return np.linalg.solve(matrix, -rest.ravel()), matrix


@laws
@given(plant=plants(), state=states, load=loads)
def test_planar_equations_are_the_cores(plant, state, load):
    q, q_dot = state.seven(plant)
    u = np.array(load[:4])
    core = _core.planar_motion(plant.values, q, q_dot, [*u, *np.zeros(7)])
    free = np.concatenate([state.bar, state.theta])
    free_dot = np.concatenate([state.bar_velocity, state.theta_dot])
    table = {name: getattr(plant, name) for name, *_ in _core.planar_plant_fields()}
    table["vehicle_drag"] = np.reshape(plant.vehicle_drag, (2, 2)).tolist()
    found, _ = accelerations(planar.equations, table, free, free_dot, u)
    expected = np.concatenate([core["bar_acceleration"], np.array(core["q_ddot"])[4:]])
    scale = max(1.0, np.abs(expected).max())
    np.testing.assert_allclose(found, expected, atol=1e-10 * scale, rtol=0)


def test_spatial_equations_fly_as_the_core_does():
    # Forces that swing, climb and turn the plate; both are integrated by Runge and Kutta.
    scenario = plate(
        3,
        {
            "plant.payload_drag": [0.1, 0.2, 0.3], "plant.payload_drag_quadratic": 0.2,
            "plant.payload_spin_damping": 0.01, "controller.rate": 500.0,
            "plant.cable_length": [1.0, 1.2, 1.4], "formation.tilt": 0.0,
            "simulation.step": 0.002, "simulation.duration": 0.6,
            "simulation.record_period": 0.002, "start.payload_yaw": 0.4,
        },
    )  # fmt: skip
    rng = np.random.default_rng(7)
    amplitude, phase = rng.uniform(-1.5, 1.5, (3, 3)), rng.uniform(0.0, 6.0, (3, 3))

    def force(t, held):
        return held + amplitude * np.sin(7.0 * t + phase)

    held = []

    def law(m):
        held.append(m.holding)
        return force(m.t, m.holding)

    run = ml.simulate(scenario, law)
    assert run.finished and run.metrics["slack_time"] == 0.0
    plant, n = scenario.values["plant"], 12
    q, v, a, u = (ca.SX.sym(k, s) for k, s in zip("qvau", (n, n, n, 9), strict=True))
    residual = spatial.equations(plant, q, v, a, u)["residual"]
    f = ca.Function("f", [q, v, u], [ca.jacobian(residual, a), ca.substitute(residual, a, 0 * a)])

    def rate(x, u):
        matrix, rest = (np.array(y) for y in f(x[:n], x[n:], u))
        return np.concatenate([x[n:], np.linalg.solve(matrix, -rest.ravel())])

    rest = scenario.rest.cable_force[0] / np.linalg.norm(
        scenario.rest.cable_force[0], axis=1, keepdims=True
    )
    x = np.zeros(2 * n)
    x[:n] = spatial._coordinates(plant, scenario.payload_start[:3], 0.4, rest)
    h = 0.002
    for k in range(300):
        u_now = force(k * h, held[0]).ravel()
        k1 = rate(x, u_now)
        k2 = rate(x + 0.5 * h * k1, u_now)
        k3 = rate(x + 0.5 * h * k2, u_now)
        k4 = rate(x + h * k3, u_now)
        x = x + h / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4)
    # The steps' errors differ, as the core draws back the cables' lengths.
    np.testing.assert_allclose(x[:3], run.vector("payload")[-1], atol=1e-6)
    np.testing.assert_allclose(x[n : n + 3], run.vector("payload_v")[-1], atol=1e-5)
    w, i, j, k = run.attitude("payload")[-1]
    heading = np.arctan2(2 * (w * k + i * j), 1 - 2 * (j * j + k * k))
    assert x[3] == pytest.approx(heading, abs=1e-5)
    assert run.metrics["peak_swing"] > 3.0  # deg: the flight says something


@pytest.fixture(scope="module")
def sim2():
    return limit.find(ml.load("sim2"))


def test_the_bound_of_sim2_flies_on_the_plant_to_rest_at_the_goal(sim2):
    # 2.03 s was found elsewhere with these forces.
    assert sim2.time == pytest.approx(2.03, abs=0.01)
    assert sim2.limits.force == pytest.approx((6.2 * 0.8, 6.5 * 0.8))
    assert sim2.arrival["position"] < 1e-6 and sim2.arrival["swing"] < 1e-4
    assert sim2.run.finished
    for axis, most in zip((("u1", "u3"), ("u2", "u4")), sim2.limits.force, strict=True):
        assert max(np.abs(sim2.run[u]).max() for u in axis) <= most * (1 + 1e-7)
    assert sim2.multiple(sim2.run) < 1.0  # the bands are entered before the end


def test_the_same_move_mirrored_takes_as_long(sim2):
    mirrored = ml.load("sim2").with_values({"goal.vehicle_position": [[0.8, 2.2], [2.6, 2.2]]})
    found = limit.find(mirrored)
    assert found.time == pytest.approx(sim2.time, rel=1e-3)


def test_narrower_limits_take_longer_and_are_kept(sim2):
    force = sim2.limits.force
    narrow = limit.Limits(force, speed=0.7, swing=np.radians(6.0), tension=3.5)
    found = limit.find(ml.load("sim2"), narrow)
    assert found.time > sim2.time
    run = found.run
    moving = run.t <= found.time
    speed = max(np.hypot(run[f"y{i}_dot"], run[f"z{i}_dot"])[moving].max() for i in (1, 2))
    # Limits hold at Radau's points, and the curves bulge a little between them.
    assert speed <= 0.7 * 1.01
    assert max(run.metrics[f"peak_swing_{k}"] for k in (1, 2, 3)) <= 6.0 * 1.02
    assert min(run[f"tension{i}"][moving].min() for i in (1, 2)) >= 3.5 * 0.97
    assert sim2.run.metrics["peak_swing_1"] > 6.0


def test_actuators_limit_thrust_and_tilt():
    scenario = ml.load("exp1_1")
    found = limit.find(scenario, limit.Limits(limit.of_the_scenario(scenario)))
    assert found.time < limit.find(scenario).time
    assert found.run.metrics["peak_thrust"] <= 30.0 * (1 + 1e-6)
    assert found.run.metrics["peak_tilt"] <= 35.0 * (1 + 1e-6)


def test_least_effort_and_least_swing_for_a_given_time(sim2):
    scenario, force = ml.load("sim2"), sim2.limits.force
    effort, swing = (
        limit.find(scenario, limit.Limits(force), least=least, time=3.0)
        for least in ("effort", "swing")
    )
    for found in (effort, swing):
        assert found.time == 3.0 and found.arrival["position"] < 1e-4
    assert effort.run.metrics["control_effort"] < swing.run.metrics["control_effort"]
    assert swing.run.metrics["swing_integral"] < effort.run.metrics["swing_integral"]
    # The integral of u^2 is the run's own metric.
    assert effort.solutions[-1].objective == pytest.approx(
        effort.run.metrics["control_effort"], rel=1e-3
    )


def test_the_way_back_from_a_push_starts_in_motion():
    scenario = planar.after_push(ml.load("exp2"), 1)
    assert np.abs(scenario.q_dot_start).max() > 0.1
    found = limit.find(scenario)
    assert found.arrival["position"] < 1e-5


def test_a_bar_in_space_is_as_fast_as_in_the_plane():
    # A body's own turning about the bar is stiff: heavy and low enough to be left alone here.
    in_space = ml.load("exp1_1_quadrotors").with_values(
        {"plant.payload_inertia": [0.01, 0.0724, 0.0724]}
    )
    in_plane = ml.load("exp1_1").with_values({"plant.bar_inertia": 0.0724})
    force = bound.law_force(in_plane)
    times = []
    for scenario, limits in (
        (in_plane, limit.Limits(force)),
        (in_space, limit.Limits((force[0], 0.3, force[1]))),
    ):
        move = scenario.model.move(scenario, limits)
        found = collocation.solve(move, Mesh.even(12, 16), least="time")
        _, arrival = bound.fly(scenario, move, found, "time")
        assert arrival["position"] < 1e-3 and arrival["swing"] < 0.05
        times.append(found.time)
    assert times[1] == pytest.approx(times[0], rel=5e-3)


BAD = {
    "start is goal": ("exp2", {}, {}, "there is no move"),
    "nothing to make least": ("sim1", {}, {"least": "fuel"}, "time, effort, swing"),
    "no time": ("sim1", {}, {"least": "effort"}, "--time"),
    "a time for the least": ("sim1", {}, {"time": 2.0}, "leave it out"),
    "no duration": ("sim1", {}, {"least": "effort", "time": -1.0}, "positive"),
    "too short": ("sim2", {}, {"least": "effort", "time": 0.5}, "--time"),
    "too weak to hover": ("exp1_1", {"actuators.thrust_max": 15.0}, {}, "hold a vehicle"),
    "one force": ("sim1", {}, {"limits": limit.Limits(force=(1.0,))}, "2 positive numbers"),
    "no speed": ("sim1", {}, {"limits": limit.Limits(speed=0.0)}, "--speed"),
    "a swing of a right angle": ("sim1", {}, {"limits": limit.Limits(swing=1.6)}, "90 deg"),
    "a tension below 0": ("sim1", {}, {"limits": limit.Limits(tension=-1.0)}, "--tension"),
    "a tension above rest's": ("sim1", {}, {"limits": limit.Limits(tension=9.0)}, "tension"),
    "few intervals": ("sim1", {}, {"intervals": 1}, "4 to 400"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_input(name):
    scenario, values, arguments, told = BAD[name]
    with pytest.raises(MultiliftError) as caught:
        limit.find(ml.load(scenario).with_values(values), **arguments)
    assert told in str(caught.value)


def test_no_thrust_is_limited():
    with pytest.raises(ScenarioError, match=r"actuators\.thrust_max"):
        limit.of_the_scenario(ml.load("sim1"))


def test_no_such_push():
    with pytest.raises(ScenarioError, match="1 to 3"):
        planar.after_push(ml.load("exp2"), 4)


def test_the_command_writes_what_can_be_replayed_and_compared(tmp_path):
    arguments = ["limit", "sim2", "-o", "out", "--intervals", "12", "--beside", "pd"]
    told = multilift(*arguments, cwd=tmp_path)
    assert told.returncode == 0, told.stderr
    kept = json.loads((tmp_path / "out" / "bound.json").read_text())
    assert f"{kept['time']:.4g} s" in told.stdout
    assert kept["laws"]["pd"]["multiple"] > 2.0
    run = saved.read(tmp_path / "out" / "run")
    assert run.finished and run.metrics["combined_settling"] <= kept["time"]
    assert (tmp_path / "out" / "bound.csv").read_text().startswith("t,")
    assert (tmp_path / "out" / "bound.png").stat().st_size > 10_000
    assert output.read_time(tmp_path / "out", "sim2") == kept["time"]
    with pytest.raises(OutputError, match="not the time-optimal bound of sim1"):
        output.read_time(tmp_path / "out", "sim1")
    again = multilift(*arguments, cwd=tmp_path)
    assert again.returncode == 2 and "--force" in again.stderr


def test_the_command_refuses_forces_that_are_none(tmp_path):
    told = multilift("limit", "sim2", "--forces", "strong", cwd=tmp_path)
    assert told.returncode == 2
    assert "law, scenario" in told.stderr
