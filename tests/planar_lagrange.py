"""The planar plant's equations of motion, as SymPy derives them from the energies (5) and (6).

Nothing here is copied from (7)-(16) or from the core: position of the bar, energies and closure
are written down, everything else is differentiated.
"""

import sympy as sp
from sympy import cos, sin

half = sp.Rational(1, 2)

m1, m2, m3, l1, l2, J, g = sp.symbols("m1 m2 m3 l1 l2 J g", positive=True)
l0, l3 = sp.symbols("l0 l3", positive=True)
q = y1, z1, y2, z2, th1, th2, th3 = sp.symbols("y1 z1 y2 z2 theta1:4", real=True)
v = sp.symbols("v_y1 v_z1 v_y2 v_z2 w1:4", real=True)  # q_dot
a = sp.symbols("a_y1 a_z1 a_y2 a_z2 alpha1:4", real=True)  # q_ddot
parameters = (m1, m2, m3, l0, l1, l2, l3, J, g)

bar = sp.Matrix(  # (1)
    [
        half * (y1 + y2 + l1 * sin(th1) - l2 * sin(th2)) + l3 * sin(th3),
        half * (z1 + z2 - l1 * cos(th1) - l2 * cos(th2)) - l3 * cos(th3),
    ]
)
closure = sp.Matrix(  # the cables' ends are the bar's ends
    [
        y2 - l2 * sin(th2) - y1 - l1 * sin(th1) - l0 * cos(th3),
        z2 - l2 * cos(th2) - z1 + l1 * cos(th1) - l0 * sin(th3),
    ]
)


def rate(expression):
    """Total time derivative."""
    return sum(
        (expression.diff(q[k]) * v[k] + expression.diff(v[k]) * a[k] for k in range(7)),
        sp.zeros(*expression.shape) if isinstance(expression, sp.MatrixBase) else sp.Integer(0),
    )


algebraic = {  # sines and cosines of the angles as unknowns of polynomials
    function(angle): sp.Symbol(f"{function.__name__}_{angle}")
    for angle in (th1, th2, th3)
    for function in (sin, cos)
}


def vanishes(expression):
    """Whether an expression in sines and cosines of the angles is zero identically.

    With s and c for sine and cosine it is a quotient of polynomials, and zero if and only if
    division of the numerator by s^2 + c^2 - 1 of the three angles leaves nothing.
    """
    numerator = sp.numer(sp.together(sp.expand_trig(expression).xreplace(algebraic)))
    circles = [
        algebraic[sin(angle)] ** 2 + algebraic[cos(angle)] ** 2 - 1 for angle in (th1, th2, th3)
    ]
    cosines = [algebraic[cos(angle)] for angle in (th1, th2, th3)]
    return sp.reduced(sp.expand(numerator), circles, *cosines)[1] == 0


bar_velocity = rate(bar)
kinetic = (  # (5), and the bar's rotation
    half * m3 * bar_velocity.dot(bar_velocity)
    + half * (m1 * (v[0] ** 2 + v[1] ** 2) + m2 * (v[2] ** 2 + v[3] ** 2))
    + half * J * v[6] ** 2
)
potential = m3 * g * bar[1] + m1 * g * z1 + m2 * g * z2  # (6)

# Row k of the Euler-Lagrange equations: momentum_rate[k] = the generalised force along q[k].
momentum_rate = [
    rate(kinetic.diff(v[k])) - kinetic.diff(q[k]) + potential.diff(q[k]) for k in range(7)
]
mass = sp.hessian(kinetic, v)
bar_jacobian = bar.jacobian(q)
closure_jacobian = closure.jacobian(q)

# What the energies of sections 3 and 4 are made of; k is the paper's k_lambda.
k = sp.Symbol("k_lambda", positive=True)
kappa = 4 / m3 + 1 / m1 + 1 / m2
swing = sp.Matrix(
    [
        l1 * sin(th1) - l2 * sin(th2) + 2 * l3 * sin(th3),
        l1 * (1 - cos(th1)) + l2 * (1 - cos(th2)) + 2 * l3 * (1 - cos(th3)),
    ]
)
swing_rate = rate(swing)  # s_y, s_z
mechanical_energy = kinetic + half * m3 * g * swing[1]  # (18)
added_energy = (  # (44), and the bar's rotation
    half * k * (swing_rate.dot(swing_rate) + kappa * J * v[6] ** 2)
    + 2 * k * (1 + m3 / (4 * m1) + m3 / (4 * m2)) * g * swing[1]
)
