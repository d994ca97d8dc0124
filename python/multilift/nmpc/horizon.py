"""The optimal control problem of one step: from a state, over a horizon, towards rest at the goal.

The plant's equations are those of `multilift.limit`, in Radau collocation of second degree; inputs
are held in each interval. Variables and constraints are laid out stage by stage, as the solver
fatrop (Vanroye, Sathya, De Schutter, Decre, IROS 2023) wants them, which comes with CasADi.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.limit.errors import casadi
from multilift.limit.move import Move, Vector

Array = NDArray[np.float64]

#: Against which what is off the goal is weighed, m and rad.
OFF = 0.1

#: Of the look ahead, s.
_STEP = 0.01

#: Radau points of an interval.
DEGREE = 2

SOLVERS = ("fatrop", "ipopt")
_OPTIONS: dict[str, dict[str, Any]] = {
    "fatrop": {"print_level": 0, "max_iter": 60, "tol": 1e-5, "mu_init": 1e-2},
    "ipopt": {"print_level": 0, "sb": "yes", "max_iter": 60, "tol": 1e-5, "mu_init": 1e-2,
              "mu_strategy": "monotone"},
}  # fmt: skip


@dataclass(frozen=True)
class Weights:
    """Of the squares in the objective, each against its scale; dimensionless.

    Attributes:
        place: of coordinates off the goal; lengths against 0.1 m, angles against 0.1 rad.
        rate: of their rates, against 1 m/s and 1 rad/s.
        force: of inputs off what holds the goal, against the inputs' scale.
        end: of both at the horizon's end, as many times as on the way.
    """

    place: float = 1.0
    rate: float = 1.0
    force: float = 1.0
    end: float = 20.0


@dataclass(frozen=True)
class Plan:
    """What was found from one state.

    Attributes:
        inputs: held in each interval, shape (intervals, inputs), N.
        q: coordinates at the intervals' ends, the start first, shape (intervals + 1, coordinates).
        seconds: that the solver took.
        iterations: of it.
        solved: whether it converged; the last iterate is given in any case.
    """

    inputs: Array
    q: Array
    seconds: float
    iterations: int
    solved: bool


class Horizon:
    """The problem, set up once and solved from state after state."""

    def __init__(
        self, move: Move, *, length: float, intervals: int, weights: Weights | None = None,
        solver: str = "fatrop",
    ) -> None:  # fmt: skip
        """Builds the program.

        Args:
            move: plant, goal and limits.
            length: of the horizon, s.
            intervals: of it.
            weights: of the objective.
            solver: "fatrop" or "ipopt".

        Raises:
            MissingExtraError: without CasADi.
        """
        ca = casadi()
        self._move, self._intervals = move, intervals
        self._width = length / intervals
        self._last: Any = None
        self._acceleration = _acceleration(ca, move)
        begin = ca.MX.sym("begin", 2 * move.coordinates)
        made = _program(ca, move, self._width, intervals, weights or Weights(), begin)
        options: dict[str, Any] = {solver: _OPTIONS[solver], "print_time": False, "expand": True}
        if solver == "fatrop":
            options |= {"structure_detection": "auto", "equality": made.equal}
        x = ca.veccat(*made.variables)
        problem = {"x": x, "p": begin, "f": made.objective, "g": ca.vertcat(*made.constraints)}
        self._solver = ca.nlpsol("nmpc", solver, problem, options)
        self._parts = ca.Function(
            "parts", [x], [ca.horzcat(*made.held), ca.horzcat(*made.places)[: move.coordinates, :]]
        )
        self._bounds = {
            "lbx": np.concatenate(made.low), "ubx": np.concatenate(made.high),
            "lbg": np.concatenate(made.lower), "ubg": np.concatenate(made.upper),
        }  # fmt: skip

    def ahead(self, q: Vector, q_dot: Vector, held: Sequence[tuple[float, Vector]]) -> Array:
        """Where the plant goes under inputs that are on their way already.

        Args:
            q: coordinates now.
            q_dot: their rates.
            held: for how long each input is held, s, and the input, N, in order.

        Returns:
            Coordinates and rates then, shape (2 coordinates,).
        """
        n = self._move.coordinates
        state = np.concatenate([q, q_dot])

        def slope(at: Vector, force: Vector) -> Vector:
            bend = np.array(self._acceleration(at[:n], at[n:], force)).ravel()
            return np.concatenate([at[n:], bend])

        for seconds, force in held:
            steps = max(1, math.ceil(seconds / _STEP))
            h = seconds / steps
            for _ in range(steps):
                k1 = slope(state, force)
                k2 = slope(state + 0.5 * h * k1, force)
                k3 = slope(state + 0.5 * h * k2, force)
                k4 = slope(state + h * k3, force)
                state = state + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return state

    def plan(self, q: Vector, q_dot: Vector) -> Plan:
        """The best way from a state; the search begins at the last one found.

        Args:
            q: coordinates of the move, shape (coordinates,).
            q_dot: their rates.
        """
        begin = np.concatenate([q, q_dot])
        guess = self._straight(begin) if self._last is None else self._last
        clock = time.perf_counter()
        found = self._solver(x0=guess, p=begin, **self._bounds)
        seconds = time.perf_counter() - clock
        told = self._solver.stats()
        solved = bool(told["success"])
        values = np.array(found["x"]).ravel()
        # What did not converge is no place to begin from again.
        self._last = values if solved and np.isfinite(values).all() else None
        inputs, places = (np.array(x).T for x in self._parts(found["x"]))
        return Plan(
            inputs * self._move.input_scale, places, seconds, int(told["iter_count"]), solved
        )

    def _straight(self, begin: Vector) -> Vector:
        """At rest along a straight line to the goal."""
        n = self._move.coordinates
        goal = self._move.goal
        held = self._move.input_goal / self._move.input_scale
        parts = [begin]
        for k in range(self._intervals):
            ends = [begin[:n] + (goal - begin[:n]) * (k + r) / self._intervals
                    for r in (1 / 3, 1.0)]  # fmt: skip
            states = [np.concatenate([x, np.zeros(n)]) for x in ends]
            parts += [*states, held, states[-1]]
        return np.concatenate(parts)


@dataclass
class _Program:
    """Variables and constraints in the order of stages."""

    variables: list[Any] = field(default_factory=list)
    low: list[Vector] = field(default_factory=list)
    high: list[Vector] = field(default_factory=list)
    constraints: list[Any] = field(default_factory=list)
    lower: list[Vector] = field(default_factory=list)
    upper: list[Vector] = field(default_factory=list)
    equal: list[bool] = field(default_factory=list)
    held: list[Any] = field(default_factory=list)
    places: list[Any] = field(default_factory=list)
    objective: Any = 0

    def vary(self, variable: Any, low: Vector | float, high: Vector | float) -> Any:
        """Takes a variable in."""
        self.variables.append(variable)
        for kept, bound in ((self.low, low), (self.high, high)):
            kept.append(np.broadcast_to(np.asarray(bound, dtype=float), variable.numel()))
        return variable

    def hold(self, rows: Any, low: Vector, high: Vector, *, equal: bool) -> None:
        """Takes a constraint in."""
        self.constraints.append(rows)
        self.lower.append(low)
        self.upper.append(high)
        self.equal += [equal] * rows.numel()


def _program(ca: Any, move: Move, width: float, intervals: int, w: Weights, begin: Any) -> _Program:
    """The whole problem, a stage an interval."""
    n, m = move.coordinates, move.inputs
    slope, _, quadrature = (
        np.array(x) for x in ca.collocation_coeff(ca.collocation_points(DEGREE, "radau"))
    )
    quadrature = quadrature.ravel()
    instant = _instant(ca, move)
    scale = ca.DM(move.input_scale)
    made = _Program()

    def cost(state: Any) -> Any:
        off = (state[:n] - ca.DM(move.goal)) / OFF
        return w.place * ca.sumsqr(off) + w.rate * ca.sumsqr(state[n:])

    state = made.vary(ca.MX.sym("x0", 2 * n), -np.inf, np.inf)
    made.places.append(state)
    for k in range(intervals):
        points = [made.vary(ca.MX.sym(f"c{k}_{j}", 2 * n), -np.inf, np.inf) for j in range(DEGREE)]
        force = made.vary(ca.MX.sym(f"u{k}", m), move.input_lower / move.input_scale,
                          move.input_upper / move.input_scale)  # fmt: skip
        following = made.vary(ca.MX.sym(f"x{k + 1}", 2 * n), -np.inf, np.inf)
        # First of a stage, where fatrop looks for it: what becomes the next stage's state.
        rows = [following - points[-1]]
        if k == 0:
            rows.append(state - begin)
        at = [state, *points]
        for j in range(1, DEGREE + 1):
            rate = sum(float(slope[r, j - 1]) * at[r] for r in range(DEGREE + 1)) / width
            residual, limited = instant(at[j][:n], at[j][n:], rate[n:], scale * force)
            rows += [rate[:n] - at[j][n:], residual]
            made.objective += width * float(quadrature[j - 1]) * cost(at[j])
        made.objective += width * w.force * ca.sumsqr(force - ca.DM(move.input_goal) / scale)
        together = ca.vertcat(*rows)
        zero = np.zeros(together.numel())
        made.hold(together, zero, zero, equal=True)
        if len(move.lower):
            # At the interval's end alone: the state at hand may break a limit already.
            made.hold(limited, move.lower, move.upper, equal=False)
        made.places.append(following)
        made.held.append(force)
        state = following
    made.objective += w.end * width * cost(state)
    return made


def _acceleration(ca: Any, move: Move) -> Any:
    """Accelerations from coordinates, rates and inputs: residuals are linear in them."""
    n, m = move.coordinates, move.inputs
    q, v, a, u = (ca.SX.sym(name, size) for name, size in zip("qvau", (n, n, n, m), strict=True))
    residual = move.equations(q, v, a, u).residual
    matrix = ca.jacobian(residual, a)
    free = ca.substitute(residual, a, ca.SX.zeros(n))
    return ca.Function("acceleration", [q, v, u], [-ca.solve(matrix, free)])


def _instant(ca: Any, move: Move) -> Any:
    """Residual and what is limited, as a function of coordinates, rates, accelerations, inputs."""
    n, m = move.coordinates, move.inputs
    q, v, a, u = (ca.SX.sym(name, size) for name, size in zip("qvau", (n, n, n, m), strict=True))
    found = move.equations(q, v, a, u)
    limited = found.limited if len(move.lower) else ca.SX(0, 1)
    return ca.Function("instant", [q, v, a, u], [found.residual, limited])
