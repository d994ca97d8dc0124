"""Exact derivatives of a run with respect to any numbers of its scenario.

The rollout itself runs over dual numbers, a value with its derivatives, so that what is
differentiated is the simulation as it is, step by step, and not an approximation of it. Which
numbers there are, each model says.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import ControllerError, MissingExtraError, ScenarioError
from multilift.scenario import Scenario

if TYPE_CHECKING:
    import pandas as pd

#: Why there is no derivative along what sets when things happen.
COUNTED = "it counts integration steps, between which nothing changes"

#: Keys of every model along which there is none, with the reason.
REFUSED = {
    "simulation.duration": COUNTED,
    "simulation.step": COUNTED,
    "simulation.record_period": COUNTED,
    "simulation.seed": "it is no quantity",
    "controller.rate": COUNTED,
}


class Gradient:
    """A run's final state, metrics and audit, and their derivatives along some scenario keys.

    A derivative is in the unit of the quantity per SI unit of the key: ``peak_swing_1`` along
    ``plant.bar_mass`` in deg/kg.

    Attributes:
        scenario: what was differentiated, under the law it flew.
        keys: along what, in order.
        status: how the run ended, as of a single run.
        culprit: what ended it, as of a single run; -1 for none.
        end_time: when it ended, s. A run that ended early is differentiated with its end held at
            that time.
        values: the run's own numbers by name: those of ``scenario.quantities.final_state``, the
            metrics, and ``audit.<entry>``. To the last bit those of ``simulate``, but for keys of
            ``actuators`` where these are ideal: then they are simulated, which rounds otherwise.
        final_state: derivatives, shape (numbers, keys), rows in the order of
            ``scenario.quantities.final_state``.
        metrics: derivatives of each metric, shape (keys,); NaN for those that count integration
            steps, the model's ``without_derivative``.
        audit: derivatives of each audit entry, shape (keys,).
    """

    def __init__(self, scenario: Scenario, keys: Sequence[str], result: Mapping[str, Any]) -> None:
        self.scenario = scenario
        self.keys = tuple(keys)
        self.status = str(result["status"])
        self.culprit = int(result["culprit"])
        self.end_time = float(result["end_time"])
        of = scenario.quantities
        names = [*of.final_state, *of.metrics, *(f"audit.{name}" for name in of.audit)]
        self.values: dict[str, float] = dict(zip(names, result["values"], strict=True))
        rows = np.array(result["derivatives"]).reshape(len(names), len(keys))
        rows[[names.index(name) for name in scenario.model.without_derivative]] = np.nan
        self._rows: dict[str, NDArray[np.float64]] = dict(zip(names, rows, strict=True))
        self.final_state: NDArray[np.float64] = rows[: len(of.final_state)]
        self.metrics = {name: self._rows[name] for name in of.metrics}
        self.audit = {name: self._rows[f"audit.{name}"] for name in of.audit}

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """Derivatives of one quantity of ``values`` along each key, shape (keys,)."""
        return self._rows[name]

    def __repr__(self) -> str:
        return f"Gradient({self.scenario.name!r}, {self.status}, along {', '.join(self.keys)})"

    def to_dataframe(self) -> pd.DataFrame:
        """One row a key, one column a quantity.

        Raises:
            MissingExtraError: without pandas (``multilift[data]``).
        """
        try:
            import pandas as pd  # noqa: PLC0415
        except ImportError:
            raise MissingExtraError("pandas", "data", "Gradient.to_dataframe()") from None
        return pd.DataFrame(self._rows, index=pd.Index(self.keys, name="key"))


def gradient(
    scenario: Scenario, keys: str | Iterable[str], *, controller: str | None = None
) -> Gradient:
    """Simulates a scenario together with its exact derivatives.

    Exact is meant of the simulation with its fixed step: the derivatives are right to round-off,
    not to the order of some difference. Where a quantity has a kink, such as a greatest value that
    passes from one swing to the next or a thrust at its limit, they are those of the side that the
    run is on.

    What follows from a key in a scenario follows here: the law's assumed masses follow the plant's
    unless ``controller.assumed`` gives them, and without ``start.angle`` the load's rest angles
    follow the plant and the vehicles' positions.

    Args:
        scenario: what to simulate.
        keys: dotted keys of numbers, optionally with indices, such as ``plant.bar_mass``,
            ``plant.vehicle_mass[0]``, ``controller.k_p[1][0]``, ``push[0].force[1]``. A key of
            several numbers means that all of them grow together.
        controller: name of a compiled law; None for the scenario's own.

    Raises:
        ControllerError: if the law is not compiled.
        ScenarioError: for unknown keys, for those along which nothing can be differentiated, with
            the reason, and for a model that has no derivatives.
    """
    laws = scenario.model.laws
    if controller is not None and controller not in laws:
        raise ControllerError(
            f"derivatives go through compiled laws: {', '.join(laws)}, not {controller!r}"
        )
    if controller is not None and controller != scenario.law:
        scenario = scenario.with_law(controller)
    keys = [keys] if isinstance(keys, str) else [str(key) for key in keys]
    return Gradient(scenario, keys, scenario.model.differentiate(scenario, keys))


def refusal(scenario: Scenario, key: str, reason: str) -> ScenarioError:
    """The error for a key that a run cannot be differentiated along."""
    return ScenarioError(
        f"has no derivative: {reason}", where=f"{scenario.where}, gradient", key=key
    )


def no_number(scenario: Scenario, key: str, tables: str) -> ScenarioError:
    """The error for a key that no number follows; `tables` says which there are."""
    return ScenarioError(
        "is not the key of a number of this scenario",
        where=f"{scenario.where}, gradient",
        key=key,
        permitted=f"keys of {tables}, with indices inside their shapes",
    )


def push_refusal(scenario: Scenario, key: str) -> str:
    """Why there is no derivative along a time or frequency of a push, or ""."""
    push = re.fullmatch(r"push\[(\d+)\]\.(start|duration|frequency)", key)
    if not push or int(push[1]) >= len(scenario.values["push"]):
        return ""
    shape = scenario.values["push"][int(push[1])]["shape"]
    if push[2] == "frequency":
        return "" if shape == "sine" else "only a push of shape 'sine' has one"
    if shape == "half_sine":
        return ""
    return (
        f"a push of shape {shape!r} begins or ends with a jump, which the integrator sees at its "
        "own instants only"
    )
