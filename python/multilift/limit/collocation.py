"""Direct collocation: an optimal control problem as a nonlinear program for IPOPT.

Each interval holds its inputs, as a sampled law does, and carries coordinates and rates as
polynomials that satisfy the equations of motion at Radau's points (Biegler, Nonlinear Programming,
SIAM 2010, chapter 10). The mesh is halved where inputs jump.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.limit.errors import LimitError, casadi
from multilift.limit.mesh import Mesh, jumps
from multilift.limit.move import Move, Vector

Array = NDArray[np.float64]

#: Degree of the polynomials; the error of an interval is of the order 2 x this.
DEGREE = 3
#: Weight of the inputs' mean square, in parts of their scales, beside what is asked for. What the
#: objective leaves open, such as the climb while the swing decides the time, is then smooth.
REST_OF_EFFORT = 1e-4
#: Of a load while it is carried, rad: scale of the swing's squares.
SWING = 0.1
#: A move longer than this many guesses is not looked for.
LONGEST = 20.0
#: IPOPT's, where the search begins afresh; the second is tried where the first does not converge.
FRESH = (
    {"mu_strategy": "adaptive", "max_iter": 250},
    {"mu_strategy": "monotone", "max_iter": 250},
)
#: And where it begins at a coarser mesh's answer.
WARM = ({"mu_strategy": "monotone", "mu_init": 1e-4, "max_iter": 100},)
#: For both. Many motions of many vehicles hardly matter to the time: the search may end where the
#: objective stands, since what it found is flown.
COMMON = {
    "print_level": 0, "sb": "yes", "linear_solver": "mumps", "tol": 1e-8,
    "constr_viol_tol": 1e-9, "acceptable_tol": 1e-4, "acceptable_constr_viol_tol": 1e-8,
    "acceptable_obj_change_tol": 1e-6, "acceptable_iter": 6,
}  # fmt: skip

OBJECTIVES = ("time", "effort", "swing")


@dataclass(frozen=True)
class Solution:
    """An optimal move on a mesh.

    Attributes:
        mesh: of its inputs.
        time: how long it takes, s.
        q: coordinates at the mesh's edges, shape (intervals + 1, coordinates).
        q_dot: their rates.
        inputs: held in each interval, shape (intervals, inputs).
        objective: of what was asked for, without the rest of effort: s, or the integral of the
            inputs' or the swing's squares.
        iterations: of IPOPT.
        points: coordinates and rates at Radau's points, for the next mesh's start, shape
            (intervals, degree, 2, coordinates).
    """

    mesh: Mesh
    time: float
    q: Array
    q_dot: Array
    inputs: Array
    objective: float
    iterations: int
    points: Array


def solve(
    move: Move, mesh: Mesh, *, least: str, time: float | None = None, guess: Solution | None = None
) -> Solution:
    """Solves a move on one mesh.

    Args:
        move: what is asked for.
        mesh: of its inputs.
        least: "time", "effort" or "swing".
        time: how long the move lasts, s; None where it is what is sought.
        guess: of an earlier, coarser mesh.

    Raises:
        LimitError: if IPOPT finds no point that satisfies everything, or does not converge.
        MissingExtraError: without CasADi.
    """
    ca = casadi()
    count, n, m = len(mesh.widths), move.coordinates, move.inputs
    roots = np.array(ca.collocation_points(DEGREE, "radau"))
    slope, _, weights = (np.array(x) for x in ca.collocation_coeff(roots.tolist()))
    weights = weights.ravel()
    limit_count = len(move.lower)

    instant = _instant(ca, move, limit_count)
    total = ca.MX.sym("T")
    edges = ca.MX.sym("edges", 2 * n, count + 1)
    inner = [ca.MX.sym(f"inner{j}", 2 * n, count) for j in range(DEGREE - 1)]
    held = ca.MX.sym("inputs", m, count)
    scale = ca.DM(move.input_scale)
    inputs = held * ca.repmat(scale, 1, count)
    width = total * ca.DM(mesh.fractions).T
    # Radau's last point is the interval's end.
    at = [edges[:, :-1], *inner, edges[:, 1:]]
    constraints, lower, upper = [], [], []
    swing = 0
    evaluate = instant.map(count)
    for j in range(1, DEGREE + 1):
        # collocation_coeff's C: derivative of the polynomial through all points at the j-th.
        rate = sum(float(slope[r, j - 1]) * at[r] for r in range(DEGREE + 1))
        rate = rate / ca.repmat(width, 2 * n, 1)
        residual, limited, swinging = evaluate(at[j][:n, :], at[j][n:, :], rate[n:, :], inputs)
        constraints += [ca.vec(rate[:n, :] - at[j][n:, :]), ca.vec(residual)]
        lower += [np.zeros(2 * n * count)]
        upper += [np.zeros(2 * n * count)]
        if limit_count:
            constraints.append(ca.vec(limited))
            lower.append(np.tile(move.lower, count))
            upper.append(np.tile(move.upper, count))
        swing = swing + float(weights[j - 1]) * ca.dot(width, swinging)
    effort = ca.dot(ca.repmat(width, m, 1), inputs**2)
    mean_square = ca.dot(ca.repmat(ca.DM(mesh.fractions).T, m, 1), held**2) / m
    wanted = {"time": total, "effort": effort, "swing": swing}[least]
    size = {"time": move.time_guess, "effort": 1.0, "swing": SWING**2 * (time or 1.0)}[least]
    blend = wanted / size if least == "effort" else wanted / size + REST_OF_EFFORT * mean_square

    unknowns = ca.veccat(total, edges, *inner, held)
    begin = _guess(move, mesh, guess, roots, time)
    low, high = _bounds(move, mesh, time)
    problem = {"x": unknowns, "f": blend, "g": ca.vertcat(*constraints)}
    for tried in FRESH if guess is None else (*WARM, *FRESH):
        options = {"ipopt": {**COMMON, **tried}, "print_time": False}
        solver = ca.nlpsol("limit", "ipopt", problem, options)
        found = solver(
            x0=begin, lbx=low, ubx=high, lbg=np.concatenate(lower), ubg=np.concatenate(upper)
        )
        told = solver.stats()
        if told["success"]:
            break
    else:
        raise _failure(told, least, time, count)
    parts = ca.Function("parts", [unknowns], [total, edges, held, wanted, *inner])
    t, e, h, value, *points = (np.array(x) for x in parts(found["x"]))
    all_points = np.stack([*points, e[:, 1:]], axis=0)  # (degree, 2n, count)
    return Solution(
        mesh,
        float(t[0, 0]),
        e[:n].T.copy(),
        e[n:].T.copy(),
        h.T * move.input_scale,
        float(value[0, 0]),
        int(told["iter_count"]),
        all_points.transpose(2, 0, 1).reshape(count, DEGREE, 2, n),
    )


def refine(
    move: Move,
    *,
    least: str,
    time: float | None = None,
    intervals: int = 24,
    levels: int = 4,
    cells: int = 16,
    within: float = 1e-3,
) -> list[Solution]:
    """Solves a move on meshes that are halved where inputs jump, until the objective stands.

    Args:
        move: what is asked for.
        least: "time", "effort" or "swing".
        time: how long the move lasts, s; None where it is what is sought.
        intervals: of the first mesh.
        levels: meshes at most.
        cells: of each of the first intervals; how often it can be halved.
        within: relative change of the objective between two meshes at which to stop.

    Returns:
        One solution a mesh, the finest that converged last.

    Raises:
        LimitError: as `solve`, on the first mesh.
    """
    mesh = Mesh.even(intervals, cells)
    # The swing's squares alone are nearly flat about many moves: begin at one that is not.
    guess = solve(move, mesh, least="effort", time=time) if least == "swing" else None
    solutions = [solve(move, mesh, least=least, time=time, guess=guess)]
    while len(solutions) < levels:
        last = solutions[-1]
        # The whole first mesh is halved once: without a jump, too, an answer is checked by another.
        chosen = jumps(last.mesh, last.inputs, move.input_scale) | (len(solutions) == 1)
        finer = last.mesh.split(chosen)
        if len(finer.widths) == len(last.mesh.widths):
            break
        try:
            solutions.append(solve(move, finer, least=least, time=time, guess=last))
        except LimitError:
            break  # what the coarser mesh found is a move all the same
        before, now = last.objective, solutions[-1].objective
        if abs(before - now) <= within * abs(now):
            break
    return solutions


def _instant(ca: Any, move: Move, limit_count: int) -> Any:
    n, m = move.coordinates, move.inputs
    q, v, a, u = (ca.SX.sym(name, size) for name, size in zip("qvau", (n, n, n, m), strict=True))
    found = move.equations(q, v, a, u)
    limited = found.limited if limit_count else ca.SX(0, 1)
    return ca.Function("instant", [q, v, a, u], [found.residual, limited, ca.sumsqr(found.swing)])


def _bounds(move: Move, mesh: Mesh, time: float | None) -> tuple[Vector, Vector]:
    """Of all unknowns, in the order of `solve`."""
    count, n = len(mesh.widths), move.coordinates
    total = (0.02 * move.time_guess, LONGEST * move.time_guess) if time is None else (time, time)
    low = np.full((2 * n, count + 1), -np.inf)
    high = -low
    low[:n, 0] = high[:n, 0] = move.start
    low[n:, 0] = high[n:, 0] = move.start_rate if len(move.start_rate) else 0.0
    low[:n, -1] = high[:n, -1] = move.goal
    low[n:, -1] = high[n:, -1] = 0.0
    free = np.full(2 * n * count * (DEGREE - 1), np.inf)
    least, most = (
        np.tile(x / move.input_scale, count) for x in (move.input_lower, move.input_upper)
    )
    return (
        np.concatenate([[total[0]], low.ravel(order="F"), -free, least]),
        np.concatenate([[total[1]], high.ravel(order="F"), free, most]),
    )


def _guess(
    move: Move, mesh: Mesh, guess: Solution | None, roots: Vector, time: float | None
) -> Vector:
    """Where IPOPT begins: a smooth straight move at rest, or a coarser mesh's solution."""
    count, edges = len(mesh.widths), mesh.edges
    inside = [edges[:-1] + r * mesh.fractions for r in roots[:-1]]
    if guess is None:
        total = move.time_guess if time is None else time

        def state(s: Vector) -> Array:
            way = s**3 * (10 - 15 * s + 6 * s**2)
            speed = 30 * s**2 * (1 - s) ** 2 / total
            q = move.start + np.outer(way, move.goal - move.start)
            return np.concatenate([q, np.outer(speed, move.goal - move.start)], axis=1)

        u = move.input_start + np.outer(edges[:-1], move.input_goal - move.input_start)
    else:
        total = guess.time
        n = move.coordinates
        known_at = (
            guess.mesh.edges[:-1, None] + np.outer(guess.mesh.fractions, roots)
        ).ravel()  # the last root is the end
        known_at = np.concatenate([[0.0], known_at])
        known = np.concatenate(
            [
                np.concatenate([guess.q[:1], guess.q_dot[:1]], axis=1),
                guess.points.reshape(-1, 2 * n),
            ]
        )

        def state(s: Vector) -> Array:
            return np.stack([np.interp(s, known_at, column) for column in known.T], axis=1)

        u = guess.inputs[guess.mesh.owner(edges[:-1] + 0.5 * mesh.fractions)]
    held = u / move.input_scale
    assert held.shape == (count, move.inputs)
    return np.concatenate(
        [[total], state(edges).ravel(), *(state(s).ravel() for s in inside), held.ravel()]
    )


def _failure(told: dict[str, Any], least: str, time: float | None, intervals: int) -> LimitError:
    status = str(told["return_status"])
    asked = f"least {least}" + ("" if time is None else f" in {time:g} s")
    if "Infeasible" in status:
        return LimitError(
            f"{asked}: no move within the limits was found on {intervals} intervals\n"
            "  what to do: "
            + ("give a longer --time, or " if time is not None else "")
            + "wider limits of force, tilt, speed, swing or tension"
        )
    return LimitError(
        f"{asked}: the search did not converge on {intervals} intervals ({status}, "
        f"{told['iter_count']} iterations)\n"
        "  what to do: "
        + ("try another --time, or " if time is not None else "")
        + "widen limits that leave little room, or try --intervals with another number"
    )
