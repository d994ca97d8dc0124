"""Exact derivatives of a run with respect to any numbers of its scenario.

The rollout itself runs over dual numbers, a value with its derivatives, so that what is
differentiated is the simulation as it is, step by step, and not an approximation of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from multilift import isa
from multilift.errors import ControllerError, MissingExtraError, ScenarioError
from multilift.fields import Field
from multilift.models.planar import layout, quantities
from multilift.models.planar.quantities import FINAL_STATE
from multilift.models.planar.scenario import PlanarScenario, planar_only
from multilift.models.planar.tables import (
    ACTUATORS,
    GOAL,
    LAWS,
    PLANT_NUMBERS,
    PUSH_NUMBERS,
    SENSORS,
    START,
)
from multilift.scenario import Scenario

if TYPE_CHECKING:
    import pandas as pd

#: Metrics without a derivative: they count integration steps, so that they stand still and jump.
WITHOUT_DERIVATIVE = ("swing_settling_time", "position_settling_time", "rest_settling_time")

_KEY = re.compile(r"(?P<key>(?P<table>[a-z_]+(?:\[\d+\])?(?:\.[a-z_]+)*)\.[a-z_]+)(?:\[\d+\])*")

_COUNTED = "it counts integration steps, between which nothing changes"
#: Keys that cannot be differentiated along, with the reason.
_REFUSED = {
    "simulation.duration": _COUNTED,
    "simulation.step": _COUNTED,
    "simulation.record_period": _COUNTED,
    "simulation.seed": "it is no quantity",
    "controller.rate": _COUNTED,
    "sensors.period": _COUNTED,
    "sensors.delay": _COUNTED,
    "actuators.command_delay": _COUNTED,
}


class Gradient:
    """A run's final state, metrics and audit, and their derivatives along some scenario keys.

    A derivative is in the unit of the quantity per SI unit of the key: ``peak_swing_1`` along
    ``plant.bar_mass`` in deg/kg.

    Attributes:
        scenario: what was differentiated, under the law it flew.
        keys: along what, in order.
        status: how the run ended, as of a single run.
        culprit: index of the slack cable or of the angle at its limit; -1 for none.
        end_time: when it ended, s. A run that ended early is differentiated with its end held at
            that time.
        values: the run's own numbers by name: the final state by ``FINAL_STATE``, the metrics, and
            ``audit.<entry>``. To the last bit those of ``simulate``, but for keys of ``actuators``
            where these are ideal: then they are simulated, which rounds otherwise.
        final_state: derivatives, shape (10, keys), rows in the order of ``FINAL_STATE``.
        metrics: derivatives of each metric, shape (keys,); NaN for those in
            ``WITHOUT_DERIVATIVE``.
        audit: derivatives of each audit entry, shape (keys,).
    """

    def __init__(
        self, scenario: PlanarScenario, keys: Sequence[str], result: dict[str, Any]
    ) -> None:
        self.scenario = scenario
        self.keys = tuple(keys)
        self.status = str(result["status"])
        self.culprit = int(result["culprit"])
        self.end_time = float(result["end_time"])
        audit = [f"audit.{name}" for name in quantities.AUDIT]
        names = [*FINAL_STATE, *quantities.METRICS, *audit]
        self.values: dict[str, float] = dict(zip(names, result["values"], strict=True))
        rows = np.array(result["derivatives"]).reshape(len(names), len(keys))
        rows[[names.index(name) for name in WITHOUT_DERIVATIVE]] = np.nan
        self._rows: dict[str, NDArray[np.float64]] = dict(zip(names, rows, strict=True))
        self.final_state: NDArray[np.float64] = rows[: len(FINAL_STATE)]
        self.metrics = {name: self._rows[name] for name in quantities.METRICS}
        self.audit = {name: self._rows[f"audit.{name}"] for name in quantities.AUDIT}

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
        ScenarioError: for unknown keys, and for those along which nothing can be differentiated,
            with the reason.
    """
    scenario = planar_only(scenario, "multilift.gradient")
    if controller is not None and controller not in LAWS:
        raise ControllerError(
            f"derivatives go through compiled laws: {', '.join(LAWS)}, not {controller!r}"
        )
    if controller is not None and controller != scenario.law:
        scenario = scenario.with_law(controller)
    keys = [keys] if isinstance(keys, str) else [str(key) for key in keys]
    values, sources = _layout(scenario)
    tangents = np.array([_tangent(scenario, key, sources) for key in keys])
    simulation = scenario.values["simulation"]
    step = simulation["step"]
    testbed = any(key.startswith(("actuators.", "sensors.")) for key in keys)
    result = isa.kernel().gradient(
        law=scenario.law,
        values=values,
        tangents=tangents.reshape(len(keys), len(values)),
        pushes=layout.push_shapes(scenario),
        at_rest=scenario.values["start"]["angle"] is None,
        step=step,
        steps=round(simulation["duration"] / step),
        control_steps=round(scenario.control_period() / step),
        ideal=scenario.is_ideal() and not testbed,
        seed=simulation["seed"],
    )
    return Gradient(scenario, keys, result)


def _layout(scenario: PlanarScenario) -> tuple[NDArray[np.float64], list[frozenset[str]]]:
    """The run's numbers as the core reads them, and the keys that each of them follows."""
    tables = scenario.values
    values: list[float] = []
    sources: list[frozenset[str]] = []

    def add(table: str, fields: Iterable[Field], also: str = "") -> None:
        for field in fields:
            value = _table(tables, table)[field.name]
            numbers = np.broadcast_to(0.0 if value is None else value, field.dims)
            values.extend(float(x) for x in numbers.ravel())
            follows = also and not scenario.assumes(field.name)
            for place in np.ndindex(*field.dims):
                index = "".join(f"[{k}]" for k in place)
                names = {f"{table}.{field.name}{index}"}
                sources.append(
                    frozenset(names | ({f"{also}.{field.name}{index}"} if follows else set()))
                )

    add("plant", PLANT_NUMBERS)
    add("controller.assumed", PLANT_NUMBERS, also="plant")
    add("controller", LAWS[scenario.law].gains)
    add("actuators", ACTUATORS.fields)
    add("sensors", SENSORS.fields)
    add("start", START.fields)
    add("goal", GOAL.fields[:1])
    for k in range(len(tables["push"])):
        add(f"push[{k}]", PUSH_NUMBERS)
    return np.array(values), sources


def _table(tables: dict[str, Any], name: str) -> dict[str, Any]:
    push = re.fullmatch(r"push\[(\d+)\]", name)
    if push:
        return dict(tables["push"][int(push[1])])
    node: Any = tables
    for part in name.split("."):
        node = node[part]
    return dict(node)


def _tangent(
    scenario: Scenario, key: str, sources: Sequence[frozenset[str]]
) -> NDArray[np.float64]:
    """How the run's numbers change with a key."""

    def belongs(source: str) -> bool:
        return source == key or source.startswith(key + "[")

    tangent = np.array([float(any(map(belongs, names))) for names in sources])
    match = _KEY.fullmatch(key)
    bare = match["key"] if match else key
    reason = _REFUSED.get(bare, "") or _refusal(scenario, bare)
    if reason:
        raise ScenarioError(
            f"has no derivative: {reason}", where=f"{scenario.where}, gradient", key=key
        )
    if not tangent.any():
        raise ScenarioError(
            "is not the key of a number of this scenario",
            where=f"{scenario.where}, gradient",
            key=key,
            permitted="keys of plant, start, goal, controller, controller.assumed, actuators, "
            "sensors and push[K], with indices inside their shapes",
        )
    return tangent


def _refusal(scenario: Scenario, key: str) -> str:
    """Why this scenario cannot be differentiated along a key, or ""."""
    if key == "start.angle" and scenario.values["start"]["angle"] is None:
        return "the load starts at rest, so that its angles follow; give start.angle to free them"
    noise = key.startswith("sensors.") and key.endswith("_noise")
    if noise and scenario.values["sensors"].get(key.removeprefix("sensors.")) == 0.0:
        return "without noise nothing is drawn that could grow; give it a value above 0"
    lags = ("actuators.thrust_time_constant", "actuators.attitude_time_constant")
    if key in lags and scenario[key] == 0.0:
        return "a lag below one step changes nothing; give it a value above 0"
    push = re.fullmatch(r"push\[(\d+)\]\.(start|duration|frequency)", key)
    if push and int(push[1]) < len(scenario.values["push"]):
        shape = scenario.values["push"][int(push[1])]["shape"]
        if push[2] == "frequency" and shape != "sine":
            return "only a push of shape 'sine' has one"
        if push[2] != "frequency" and shape != "half_sine":
            return (
                f"a push of shape {shape!r} begins or ends with a jump, which the integrator sees "
                "at its own instants only"
            )
    return ""
