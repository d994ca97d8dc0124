"""Who is compared: laws, the numbers that tuning draws for them, and their gains from these."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift.errors import MultiliftError
from multilift.models.spatial import lqr
from multilift.models.spatial.scenario import SpatialScenario
from multilift.scenario import Scenario

Array = NDArray[np.float64]

#: A quadrotor turns too slowly to damp what swings with a shorter lever, m; see `lqr.lqr_gains`.
_QUADROTOR_LEVER = 0.2
#: k_rate = this times the root of k_attitude: damping of 0.85, as of the law's defaults.
_ATTITUDE_DAMPING = 1.7
#: Of the drag estimate, N s^2/m^3, where the scenario gives none.
_GAMMA = 0.5


@dataclass(frozen=True)
class Contender:
    """A law as it takes part.

    Attributes:
        name: for files and tables.
        label: for people.
        law: the compiled law.
        ranges: what tuning draws, each between two numbers, uniformly in their logarithms.
        gains: from a scenario and drawn numbers, each an array of N, the law's gains by their
            fields' names, each with N rows.
    """

    name: str
    label: str
    law: str
    ranges: Mapping[str, tuple[float, float]]
    gains: Callable[[SpatialScenario, Mapping[str, Array]], dict[str, Array]]

    def fly(self, scenario: SpatialScenario, drawn: Mapping[str, float]) -> Scenario:
        """A task under this law with one set of drawn numbers.

        Raises:
            MultiliftError: if the law has no gains for this formation.
        """
        gains = self.gains(scenario, {name: np.array([x]) for name, x in drawn.items()})
        raw = scenario.raw()
        old = raw["controller"]
        kept = {key: old[key] for key in ("rate", "assumed") if key in old}
        own = {name: rows[0].tolist() for name, rows in gains.items()}
        raw["controller"] = {"law": self.law, **kept, **own}
        return Scenario(raw, scenario.where)

    def overrides(
        self, scenario: SpatialScenario, drawn: Mapping[str, Array]
    ) -> dict[str, ArrayLike]:
        """The gains of N sets of drawn numbers as `multilift.simulate_batch` takes them."""
        table = scenario.model.controller_table(self.law)
        result: dict[str, ArrayLike] = {}
        for name, rows in self.gains(scenario, drawn).items():
            missing = len(table.field(name).shape) - (rows.ndim - 1)
            result[f"controller.{name}"] = rows.reshape(len(rows), *[1] * missing, *rows.shape[1:])
        return result


def _feedback(scenario: SpatialScenario, drawn: Mapping[str, Array]) -> dict[str, Array]:
    count = len(drawn["k_p[x,y]"])

    def axes(name: str) -> Array:
        across = drawn[f"{name}[x,y]"]
        return np.stack([across, across, drawn[f"{name}[z]"]], axis=1)

    gamma = scenario["controller.gamma"] if scenario.gives("controller.gamma") else _GAMMA
    gains = {
        "k_p": axes("k_p"),
        "k_d": axes("k_d"),
        "gamma": np.tile(np.asarray(gamma, dtype=float), (count, *[1] * np.ndim(gamma))),
        "feedforward": np.ones(count),
    }
    for name in ("k_i", "k_lambda"):
        if name in drawn:
            gains[name] = drawn[name]
    return gains


def _geometric(scenario: SpatialScenario, drawn: Mapping[str, Array]) -> dict[str, Array]:
    integral = drawn.get("k_integral", np.zeros_like(drawn["k_position"]))
    rate = _ATTITUDE_DAMPING * np.sqrt(drawn["k_attitude"])
    return {**drawn, "k_integral": integral, "k_rate": rate}


def _regulator(scenario: SpatialScenario, drawn: Mapping[str, Array]) -> dict[str, Array]:
    plant, force = scenario.plant, scenario.rest.cable_force[0]
    lever = _QUADROTOR_LEVER if scenario["vehicle.kind"] == "quadrotor" else 1e-6
    sets = []
    for k in range(len(drawn["r_force"])):
        weights = lqr.Weights(**{name: float(rows[k]) for name, rows in drawn.items()})
        try:
            gains = lqr.lqr_gains(
                plant.vehicle_mass, plant.cable_length, plant.attachment, plant.payload_mass,
                plant.payload_inertia, force, weights, vehicle_drag=plant.vehicle_drag,
                payload_drag=plant.payload_drag, least_lever=lever,
            )  # fmt: skip
        except ValueError as error:
            raise MultiliftError(f"{scenario.where}: no gains of the law lqr: {error}") from None
        sets.append(gains)
    rows = {name: np.stack([gains[name] for gains in sets]) for name in sets[0]}
    return {**rows, "feedforward": np.ones(len(sets))}


_FEEDBACK = {
    "k_p[x,y]": (1.5, 12.0),
    "k_p[z]": (2.0, 18.0),
    "k_d[x,y]": (2.0, 18.0),
    "k_d[z]": (2.5, 25.0),
}
_COUPLED = {**_FEEDBACK, "k_lambda": (0.03, 0.7)}
_GEOMETRIC = {
    "k_position": (0.3, 5.0),
    "k_velocity": (0.6, 5.0),
    "k_attitude": (0.6, 10.0),
    "k_cable": (2.5, 40.0),
    "k_cable_rate": (1.2, 14.0),
}
_WEIGHTS = {
    "q_position": (0.3, 20.0),
    "q_velocity": (0.1, 10.0),
    "q_attitude": (0.4, 40.0),
    "q_swing": (0.4, 40.0),
    "r_force": (0.03, 2.0),
}
_INTEGRAL = {"k_i": (0.2, 5.0)}

#: The ranges' geometric middles are about the shipped scenarios' gains, or the law's defaults.
CONTENDERS = (
    Contender("pd", "PD", "pd", _FEEDBACK, _feedback),
    Contender("pd_integral", "PD + integral", "pd", {**_FEEDBACK, **_INTEGRAL}, _feedback),
    Contender("energy_coupled", "energy-coupled", "energy_coupled", _COUPLED, _feedback),
    Contender("energy_coupled_integral", "energy-coupled + integral", "energy_coupled",
              {**_COUPLED, **_INTEGRAL}, _feedback),
    Contender("geometric", "geometric", "geometric", _GEOMETRIC, _geometric),
    Contender("geometric_integral", "geometric + integral", "geometric",
              {**_GEOMETRIC, "k_integral": (0.03, 1.0)}, _geometric),
    Contender("lqr", "LQR", "lqr", _WEIGHTS, _regulator),
)  # fmt: skip
