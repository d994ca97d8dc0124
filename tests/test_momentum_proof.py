"""The storage function of the momentum-coupled law, proved by SymPy, in the plane and in space.

Whatever masses, lengths, gains, motion and forces inside the formation are, the rate of

    S = E - 1/2 a M |V|^2 + 1/2 sum y_i' K_p y_i + 1/2 g y_p' (sum K_p) y_p + 1/2 w~' Gamma^-1 w~

holds no force inside the formation, and S is positive definite; see docs/momentum-law.
"""

import itertools

import planar_lagrange as lagrange
import pytest
import sympy as sp
from planar_lagrange import (
    J,
    g,
    half,
    k,
    m1,
    m2,
    m3,
    mechanical_energy,
    q,
    rate,
    swing,
    v,
    vanishes,
)

lead = sp.Symbol("lead", positive=True)
follow = lead / (1 + lead)
everything = m1 + m2 + m3

xi_dot, theta_dot = sp.Matrix(v[:4]), sp.Matrix(v[4:])
xi_d, d, d_hat, k_p, k_d, gamma, u, push = (
    sp.Matrix(sp.symbols(f"{name}1:5", positive=True))
    for name in ("xi_d", "d", "d_hat", "k_p", "k_d", "gamma", "u", "push")
)
d_theta = sp.Matrix(sp.symbols("d_theta1:4", positive=True))
mu, bar_push = sp.Matrix(sp.symbols("mu_y mu_z")), sp.Matrix(sp.symbols("F_y F_z"))
torque = sp.Symbol("tau")
weights = [0, (m1 + m3 / 2) * g, 0, (m2 + m3 / 2) * g, 0, 0, 0]
rows = sp.Matrix([row - w for row, w in zip(lagrange.momentum_rate, weights, strict=True)])


def times(x, y):
    return x.multiply_elementwise(y)


def twice(x):
    """(y, z) for both vehicles."""
    return x.col_join(x)


def mean(weight, x):
    """Of both vehicles along each axis, weighed."""
    return sp.Matrix(
        [
            (weight[j] * x[j] + weight[j + 2] * x[j + 2]) / (weight[j] + weight[j + 2])
            for j in range(2)
        ]
    )


def centre(vehicles, of_swing):
    """The common centre of mass from its place at rest; the bar is half the swing off the mean."""
    first, second = vehicles[:2, :], vehicles[2:, :]
    bar = (first + second + of_swing) / 2
    return (m1 * first + m2 * second + m3 * bar) / everything


error = sp.Matrix(q[:4]) - xi_d
X = centre(error, swing)
V = rate(X)
y = error - follow * twice(X)
y_dot = xi_dot - follow * twice(V)
y_p, y_d = mean(k_p, y), mean(k_d, y_dot)
law = (
    -times(k_p, y + lead * twice(y_p))
    - times(k_d, y_dot + lead * twice(y_d))
    + times(d_hat, xi_dot)
)


def spread(weight, x):
    """x' (sum of weights) x of a mean x."""
    return sum((weight[j] + weight[j + 2]) * x[j] ** 2 for j in range(2))


spring = half * y.dot(times(k_p, y)) + half * lead * spread(k_p, y_p)
estimation_rate = -sum((d[i] - d_hat[i]) * -xi_dot[i] * y_dot[i] for i in range(4))
# Rates of quadratic forms by hand, so that the proof stays short: y' K y and y_p' K y_p.
spring_rate = y_dot.dot(times(k_p, y)) + lead * sum(
    (k_p[j] + k_p[j + 2]) * y_p[j] * mean(k_p, y_dot)[j] for j in range(2)
)


def test_spring_rate_is_the_rate_of_the_spring():
    x, x_dot = sp.symbols("x1:5"), sp.symbols("v1:5")
    at, moving = sp.Matrix(x), sp.Matrix(x_dot)
    energy = half * at.dot(times(k_p, at)) + half * lead * spread(k_p, mean(k_p, at))
    slope = sum(energy.diff(a) * b for a, b in zip(x, x_dot, strict=True))
    claimed = moving.dot(times(k_p, at)) + lead * sum(
        (k_p[j] + k_p[j + 2]) * mean(k_p, at)[j] * mean(k_p, moving)[j] for j in range(2)
    )
    assert sp.simplify(slope - claimed) == 0


def test_no_force_inside_the_formation_moves_the_common_centre():
    total = sp.Matrix([rows[j] + rows[j + 2] for j in range(2)])
    assert all(vanishes(entry) for entry in everything * rate(V) - total)
    inside = lagrange.closure_jacobian.T * mu
    assert sp.simplify(inside[0] + inside[2]) == sp.simplify(inside[1] + inside[3]) == 0


def test_the_storage_function_changes_by_named_powers_and_no_internal_force():
    friction = times(d, xi_dot).col_join(times(d_theta, theta_dot))
    right_sides = (u + push).col_join(sp.Matrix([0, 0, torque])) - friction
    right_sides += lagrange.closure_jacobian.T * mu + lagrange.bar_jacobian.T * bar_push
    chi = y_dot.col_join(theta_dot)
    kinetic_part = rate(mechanical_energy) - follow * everything * V.dot(rate(V))
    powers = (
        -y_dot.dot(times(k_d, y_dot))
        - lead * spread(k_d, y_d)
        - theta_dot.dot(times(d_theta, theta_dot))
        + y_dot.dot(push)
        + bar_push.dot(lagrange.bar_velocity - follow * V)
        + torque * v[6]
        + y_dot.dot(u - law)
    )
    closure_rate = rate(lagrange.closure)
    # Zero along every motion: multiples of the rows' residuals and of the closure's rate.
    zero = chi.dot(rows - right_sides) + mu.dot(closure_rate)
    # What holds E and what holds the gains never meet but through the signals: prove each alone.
    motion = kinetic_part - chi.dot(rows)
    assert vanishes(motion)
    feedback = sp.expand(motion * 0 + spring_rate + estimation_rate + chi.dot(rows) - powers - zero)
    signals = dict(zip(X, sp.symbols("X_y X_z"), strict=True))
    rates = dict(zip(V, sp.symbols("V_y V_z"), strict=True))
    assert vanishes(feedback.subs(signals).subs(rates))


def test_for_equal_masses_and_gains_the_command_is_the_papers():
    same = (
        {m2: m1} | {k_p[j + 2]: k_p[j] for j in range(2)} | {k_d[j + 2]: k_d[j] for j in range(2)}
    )
    paper = {lead: 4 * k * everything / ((m1 + m2) * m3)}
    eta = -k / m1 * twice(swing)  # (47)
    eps, eps_dot = error + eta, xi_dot + rate(eta)  # (48)
    printed = -times(k_p, eps) - times(k_d, eps_dot) + times(d_hat, xi_dot)  # (55)
    for ours, theirs in zip(law, printed, strict=True):
        assert vanishes((ours.subs(paper) - theirs).subs(same))


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_in_space_with_n_vehicles(n):
    def vectors(name):
        return [sp.Matrix(sp.symbols(f"{name}{i}_x {name}{i}_y {name}{i}_z")) for i in range(n)]

    def vector(name):
        return sp.Matrix(sp.symbols(f"{name}_x {name}_y {name}_z"))

    masses, m_L = sp.symbols(f"m1:{n + 1}", positive=True), sp.Symbol("m_L", positive=True)
    p, p_dot, arm, pull, hold, kp, kd = map(vectors, ("e", "v", "r", "R", "h", "kp", "kd"))
    x, x_dot, spin, weight = vector("x"), vector("w"), vector("omega"), vector("g")
    whole = m_L + sum(masses)

    def common(payload, vehicles):
        moment = m_L * payload
        for m, each in zip(masses, vehicles, strict=True):
            moment += m * each
        return moment / whole

    def weighed(gains, xs):
        top, below = sp.zeros(3, 1), sp.zeros(3, 1)
        for gain, each in zip(gains, xs, strict=True):
            top, below = top + times(gain, each), below + gain
        return sp.Matrix([a / b for a, b in zip(top, below, strict=True)]), below

    centre, velocity = common(x, p), common(x_dot, p_dot)
    ys = [each - follow * centre for each in p]
    y_dots = [each - follow * velocity for each in p_dot]
    (mean_p, all_p), (mean_d, all_d) = weighed(kp, ys), weighed(kd, y_dots)
    us = [
        -times(a, y + lead * mean_p) - times(b, z + lead * mean_d)
        for a, b, y, z in zip(kp, kd, ys, y_dots, strict=True)
    ]
    # Newton for vehicles, that hold themselves and h_i, sum h_i = m_L g; R_i pulls the payload.
    hold[-1] = m_L * weight - sum(hold[:-1], sp.zeros(3, 1))
    forces = [u + h - r for u, h, r in zip(us, hold, pull, strict=True)]
    on_payload = sum(pull, sp.zeros(3, 1)) - m_L * weight
    # d/dt of: kinetic energies of points and payload, whose turning takes up omega . sum r x R;
    power = sum(a.dot(b) for a, b in zip(p_dot, forces, strict=True)) + x_dot.dot(on_payload)
    power += spin.dot(sum((a.cross(b) for a, b in zip(arm, pull, strict=True)), sp.zeros(3, 1)))
    # - 1/2 a M |V|^2; m_L g x - sum h_i p_i; and the springs.
    power -= follow * velocity.dot(sum(forces, sp.zeros(3, 1)) + on_payload)
    power += m_L * weight.dot(x_dot) - sum(a.dot(b) for a, b in zip(hold, p_dot, strict=True))
    power += sum(z.dot(times(a, y)) for a, y, z in zip(kp, ys, y_dots, strict=True))
    power += lead * weighed(kp, y_dots)[0].dot(times(all_p, mean_p))
    # Each cable's force works on the rate at which its two ends part, and on nothing else.
    stretch = sum(
        r.dot(a - x_dot - spin.cross(b)) for r, a, b in zip(pull, p_dot, arm, strict=True)
    )
    dissipated = sum(z.dot(times(b, z)) for b, z in zip(kd, y_dots, strict=True))
    dissipated += lead * mean_d.dot(times(all_d, mean_d))
    assert sp.expand(sp.numer(sp.together(sp.expand(power + stretch + dissipated)))) == 0


@pytest.mark.parametrize("n", [2, 3, 4])
def test_the_kinetic_part_is_positive(n):
    masses = sp.symbols(f"m1:{n + 1}", positive=True)
    speeds = sp.symbols(f"v1:{n + 1}", real=True)
    whole = sum(masses)
    mean_speed = sum(m * s for m, s in zip(masses, speeds, strict=True)) / whole
    kinetic = half * sum(m * s**2 for m, s in zip(masses, speeds, strict=True))
    apart = sum(
        masses[i] * masses[j] * (speeds[i] - speeds[j]) ** 2
        for i, j in itertools.combinations(range(n), 2)
    )
    positive = half * (1 - follow) * whole * mean_speed**2 + apart / (2 * whole)
    assert sp.simplify(kinetic - half * follow * whole * mean_speed**2 - positive) == 0


def test_the_least_spring_energy_over_translations_holds_the_deformation_alone():
    e1, e2, shift = sp.symbols("e1 e2 shift", real=True)
    a, b, s = sp.symbols("a b s", real=True)  # centre of mass: a e1 + b e2 + s, a + b = 1
    k1, k2 = k_p[0], k_p[2]
    X_y = (a * (e1 + shift) + (1 - a) * (e2 + shift) + s).subs(b, 1 - a)
    y1, y2 = e1 + shift - follow * X_y, e2 + shift - follow * X_y
    energy = half * (k1 * y1**2 + k2 * y2**2) + half * lead * (k1 * y1 + k2 * y2) ** 2 / (k1 + k2)
    (best,) = sp.solve(energy.diff(shift), shift)
    least = sp.simplify(energy.subs(shift, best))
    assert sp.simplify(least - half * k1 * k2 / (k1 + k2) * (e1 - e2) ** 2) == 0


def test_the_bars_inertia_takes_part_as_kinetic_energy_only():
    assert sp.simplify(mechanical_energy.diff(J) - half * v[6] ** 2) == 0
