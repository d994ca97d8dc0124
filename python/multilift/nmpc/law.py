"""NMPC as a law of one's own, for the planar and the spatial plant."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np

from multilift.limit.bound import law_force
from multilift.limit.bounds import Limits
from multilift.nmpc.horizon import Array, Horizon, Plan, Weights
from multilift.scenario import Scenario

#: Between two plans, s; the input is held meanwhile.
PERIOD = 0.05


class Nmpc:
    """Plans anew every `period` from what is measured and commands the plan's first input.

    It believes the plant of ``controller.assumed`` and keeps to the greatest force that the
    scenario's own law commands, as `multilift limit` does: both are of one move. Of delay and lag
    it knows `lead` alone: it plans from where its commands will have brought the plant by then.

    Attributes:
        title: for figures.
        plans: everything that was planned.
    """

    title = "NMPC"

    def __init__(
        self,
        scenario: Scenario,
        *,
        length: float = 2.5,
        intervals: int = 20,
        period: float = PERIOD,
        weights: Weights | None = None,
        solver: str = "fatrop",
        force: Sequence[float] | None = None,
        lead: float | None = None,
    ) -> None:
        """Builds the program for a scenario.

        Args:
            scenario: with a move from its start to its goal.
            length: of the horizon, s.
            intervals: of it.
            period: between two plans, s.
            weights: of the objective.
            solver: "fatrop" or "ipopt".
            force: greatest along each axis, N; None: that of the scenario's own law.
            lead: from a measurement to when its command acts, s; None: the scenario's delays and
                first-order lags, summed.

        Raises:
            ScenarioError: where start and goal are one, or the model has no such equations.
            MissingExtraError: without CasADi.
        """
        assumed = scenario.values["controller"]["assumed"]
        believed = {f"plant.{k}": v for k, v in assumed.items() if isinstance(v, (float, list))}
        self._scenario = scenario.with_values(believed)
        limits = Limits(force=tuple(force) if force else law_force(scenario))
        move = scenario.model.move(self._scenario, limits)
        self._rest = move.input_start
        self._horizon = Horizon(move, length=length, intervals=intervals, weights=weights,
                                solver=solver)  # fmt: skip
        self._period = period
        self._lead = _lead(scenario) if lead is None else lead
        self._sent: deque[tuple[float, Array]] = deque()
        self._next = 0.0
        self._held: list[float] = []
        self.plans: list[Plan] = []

    def step(self, measured: Any) -> list[float]:
        """Forces on the vehicles, in the model's order, N."""
        if measured.t >= self._next - 1e-9:
            q, q_dot = self._scenario.model.free_coordinates(self._scenario, measured)
            if self._lead > 0.0:
                then = self._horizon.ahead(q, q_dot, self._on_their_way(measured.t))
                q, q_dot = then[: len(q)], then[len(q) :]
            plan = self._horizon.plan(q, q_dot)
            self.plans.append(plan)
            if plan.solved or not self._held:
                self._held = np.asarray(plan.inputs[0]).tolist()
            self._sent.append((measured.t, np.array(self._held)))
            self._next = measured.t + self._period
        return self._held

    def _on_their_way(self, now: float) -> list[tuple[float, Array]]:
        """Inputs that act from now until what is planned now will, and for how long each."""
        while len(self._sent) > 1 and self._sent[1][0] + self._lead <= now:
            self._sent.popleft()
        if not self._sent:
            return [(self._lead, self._rest)]
        ends = [*[t + self._lead for t, _ in self._sent][1:], now + self._lead]
        result, begun = [], now
        first = self._sent[0][0] + self._lead
        if first > begun:
            result.append((first - begun, self._rest))
            begun = first
        for end, (_, force) in zip(ends, self._sent, strict=True):
            if end > begun:
                result.append((end - begun, force))
                begun = end
        return result


def _lead(scenario: Scenario) -> float:
    """Delays and lags of the way from a measurement to a force, s."""
    lags = ("actuators.thrust_time_constant", "actuators.attitude_time_constant")
    known = [key for key in (*scenario.model.delays, *lags) if _has(scenario, key)]
    return float(sum(float(np.max(scenario[key])) for key in known if "period" not in key))


def _has(scenario: Scenario, key: str) -> bool:
    try:
        scenario[key]
    except KeyError:
        return False
    return True
