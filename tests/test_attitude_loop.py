"""A quadrotor's attitude loop, I and D terms and sampling included, against its linear model.

About each axis: angle a, rate w, torque u per unit by rotors with their lag, the autopilot's
integral and filtered derivative. Between two of its instants, a period p apart,

    a' = w,   J w' = G l,   T l' = u - l,

at them, with a_set the angle wanted and K, P, I, D, f the gains and the filter's part,

    e = K (a_set - a) - w,   c <- c + f ((w - w_before) / p - c),
    u = P e + s - D c,       s <- s + p I e.

The cable is tied to the centre of mass, so that nothing else turns the vehicle.
"""

import multilift as ml
import numpy as np
import pytest
from scipy.linalg import expm
from spatial_scenarios import plate

AXES = ("x", "y", "z")
ANGLE = 1e-5  # rad: what is not linear goes with it
STEP = 0.001  # s
BEGIN = 0.05  # s, of the setpoint's step


def scenario(changes=None, duration=1.0):
    """One quadrotor over a point mass; its law has the autopilot follow a setpoint of tilt."""
    return plate(
        1,
        {
            "plant.payload_inertia": 0.0, "plant.attachment": 0.0, "plant.payload_mass": 0.3,
            "formation.tilt": 0.0, "vehicle.type": "paper_craft", "limits.tilt_max": 1.0,
            "goal.payload_position": [0.0, 0.0, 1.0], "controller.rate": 1 / STEP,
            "simulation.record_period": STEP, "simulation.duration": duration, **(changes or {}),
        },
    )  # fmt: skip


def fly(changes, axis, duration=1.0):
    """The angle wanted and the angle about an axis, rad, and the rate, at every step."""
    if axis == "z":
        # The heading comes from the reference: a turn within ten steps.
        turn = {"goal.payload_yaw": ANGLE, "reference.kind": "min_snap",
                "reference.start": BEGIN, "reference.duration": 0.01}  # fmt: skip
        run = ml.simulate(scenario({**turn, **changes}, duration), lambda m: m.holding)
        wanted = run["target_yaw"]
    else:
        # A turn about y leans forwards, one about x to the right, away from y.
        lean = {"x": [0.0, -ANGLE, 1.0], "y": [ANGLE, 0.0, 1.0]}[axis]

        def law(m):
            up = m.holding[0, 2]
            return [[up * x for x in lean]] if m.t > BEGIN - 0.5 * STEP else [[0.0, 0.0, up]]

        run = ml.simulate(scenario(changes, duration), law)
        wanted = np.where(run["t"] > BEGIN - 0.5 * STEP, ANGLE, 0.0)
    assert run.status == "finished"
    return wanted, 2.0 * run[f"vehicle1_q{axis}"], run[f"vehicle1_rate_{axis}"]


class Loop:
    """The linear loop of a scenario about an axis: state (a, w, l, s, w_before, c) at instants.

    Attributes:
        once: from one instant to the next without setpoint, shape (6, 6).
        push: what a setpoint of 1 adds, shape (6,).
        period: between two instants, s.
    """

    def __init__(self, of, axis):
        k = AXES.index(axis)
        craft = {key: np.asarray(value)[0] for key, value in of.values["vehicle"].items()
                 if isinstance(value, list)}  # fmt: skip
        gains = {key: np.asarray(value)[0] for key, value in of.values["autopilot"].items()
                 if isinstance(value, list)}  # fmt: skip
        self.period = p = 1.0 / of["autopilot.rate"]
        greatest = craft["thrust_coefficient"] * craft["rotor_speed_max"] ** 2
        lever = 4.0 * craft["torque_ratio"] if axis == "z" else 2.0 * craft["arm_length"]
        lag = craft["rotor_time_constant"]
        # With the torque u held: rows of a, w, l, u.
        held = expm(p * np.array([
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, lever * greatest / craft["inertia"][k], 0.0],
            [0.0, 0.0, -1.0 / lag, 1.0 / lag],
            [0.0, 0.0, 0.0, 0.0],
        ]))  # fmt: skip
        cut = 2.0 * np.pi * p * gains["rate_filter"]
        f = cut / (1.0 + cut)
        gain, proportional, integral, derivative = (
            gains[key][k] for key in ("attitude_gain", "rate_p", "rate_i", "rate_d")
        )
        # Rows of what is worked out at an instant from (a, w, l, s, w_before, c, a_set).
        error = np.array([-gain, -1.0, 0, 0, 0, 0, gain])
        change = np.array([0, f / p, 0, 0, -f / p, 1 - f, 0])
        total = np.array([0, 0, 0, 1.0, 0, 0, 0])
        torque = proportional * error + total - derivative * change
        now = np.eye(7)[:3]
        rows = [
            *(held[:3, :3] @ now + np.outer(held[:3, 3], torque)),
            total + p * integral * error,
            np.eye(7)[1],
            change,
        ]
        self.once, self.push = np.array(rows)[:, :6], np.array(rows)[:, 6]

    def respond(self, wanted):
        """Angles at the instants, to setpoints at them."""
        state, angles = np.zeros(6), []
        for a in wanted:
            angles.append(state[0])
            state = self.once @ state + self.push * a
        return np.array(angles)

    def growth(self):
        """Of what decays most slowly or grows fastest, 1/s."""
        return np.log(np.abs(np.linalg.eigvals(self.once)).max()) / self.period


#: Gains as shipped, and others in which each term matters.
SETTINGS = {
    "shipped": {},
    "no integral, no derivative": {"autopilot.rate_i": 0.0, "autopilot.rate_d": 0.0},
    "much integral": {"autopilot.rate_i": 2.0},
    "much derivative": {"autopilot.rate_d": 0.01, "autopilot.rate_filter": 60.0},
    "slow autopilot": {"autopilot.rate": 250.0},
    "a + frame": {"vehicle.frame_angle": 0.0},
}


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("setting", SETTINGS)
def test_small_steps_are_answered_as_the_linear_model_does(setting, axis):
    changes = SETTINGS[setting]
    wanted, angle, _ = fly(changes, axis)
    loop = Loop(scenario(changes), axis)
    every = round(loop.period / STEP)
    expected = loop.respond(wanted[::every])
    assert expected.max() > 0.3 * ANGLE
    # The rotors' lag by Runge-Kutta steps is exact to 1e-8; squares of the angle are 1e-5 of it,
    # times what rotors' speeds change per torque.
    assert np.abs(angle[::every] - expected).max() < 1e-3 * ANGLE


def scaled(changes, factor):
    """The changes with all rate gains times a factor."""
    default = scenario().values["autopilot"]
    names = ("rate_p", "rate_i", "rate_d")
    given = {name: changes.get(f"autopilot.{name}", default[name][0]) for name in names}
    return {
        **changes,
        **{f"autopilot.{name}": (factor * np.asarray(x)).tolist() for name, x in given.items()},
    }


def greatest_gain(changes, axis):
    """The factor on all rate gains at which the linear model stops decaying."""

    def grows(factor):
        return Loop(scenario(scaled(changes, factor)), axis).growth() > 0

    high = 1.0
    while not grows(high):
        high *= 1.25
    low = high / 1.25
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if grows(middle) else (middle, high)
    return low


@pytest.mark.parametrize("axis", ["x", "z"])
@pytest.mark.parametrize("setting", ["shipped", "much derivative", "slow autopilot"])
def test_gains_below_the_linear_limit_decay_and_beyond_it_grow(setting, axis):
    limit = greatest_gain(SETTINGS[setting], axis)
    for part in (0.97, 1.03):
        changes = scaled(SETTINGS[setting], part * limit)
        loop = Loop(scenario(changes), axis)
        growth = loop.growth()
        assert (growth > 0) == (part > 1)
        # For as long as what lasts longest changes sevenfold once the rest is gone.
        wanted, angle, rate = fly(changes, axis, round(BEGIN + 0.5 + 2.0 / abs(growth), 2))
        every = round(loop.period / STEP)
        expected = loop.respond(wanted[::every])
        assert np.abs(angle[::every] - expected).max() < 0.01 * np.abs(expected).max()
        begun = rate[round(BEGIN / STEP) :]
        early, late = (np.abs(each).max() for each in np.array_split(begun, 4)[1::2])
        assert (late > early) == (part > 1)
