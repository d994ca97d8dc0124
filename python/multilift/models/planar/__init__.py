"""The paper's plant: two vehicles, two taut cables and a bar in a vertical plane."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from multilift.controllers import CompiledLaw, PythonLaw
from multilift.models import Model
from multilift.models.planar import endings, gradient, layout, linear, quantities, rollout
from multilift.models.planar.run import PlanarRun
from multilift.models.planar.scenario import PlanarScenario, planar_only
from multilift.models.planar.tables import LAWS, SENSORS, TABLES
from multilift.overrides import Columns
from multilift.quantities import Quantities
from multilift.run import Run
from multilift.scenario import Scenario
from multilift.steps import Steps

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from multilift.limit.bounds import Limits
    from multilift.limit.move import Move
    from multilift.replay.scene import Scene
    from multilift.report.contents import View


class Planar(Model):
    """See `multilift.models.Model`."""

    name = "planar"
    title = "two vehicles, two taut cables and a bar in a vertical plane"
    tables = TABLES
    laws = LAWS
    statuses = endings.STATUSES
    outcomes = endings.OUTCOMES
    culprit_doc = "which cable or angle, counted from 0; -1 if none"
    clock = (*Model.clock, "sensors.period")
    delays = ("actuators.command_delay", "sensors.period", "sensors.delay")
    random_keys = tuple(f"sensors.{f.name}" for f in SENSORS.fields if f.name.endswith("noise"))
    without_derivative = gradient.WITHOUT_DERIVATIVE
    described = quantities.QUANTITIES
    study_metrics = ("peak_swing_1", "peak_swing_2", "swing_settling_time",
                     "position_settling_time", "storage_rise")  # fmt: skip

    @property
    def scenario_type(self) -> type[PlanarScenario]:
        return PlanarScenario

    def quantities(self, scenario: Scenario) -> Quantities:
        return quantities.QUANTITIES

    @property
    def run_type(self) -> type[PlanarRun]:
        return PlanarRun

    def simulate(self, scenario: Scenario, law: CompiledLaw | PythonLaw) -> PlanarRun:
        return rollout.simulate(planar_only(scenario, "the planar rollout"), law)

    def differentiate(self, scenario: Scenario, keys: Sequence[str]) -> Mapping[str, Any]:
        return gradient.differentiate(planar_only(scenario, "multilift.gradient"), keys)

    def move(self, scenario: Scenario, limits: Limits) -> Move:
        from multilift.models.planar import move  # noqa: PLC0415 - needs CasADi

        return move.move(planar_only(scenario, "multilift.limit"), limits)

    def unhindered(self, scenario: Scenario) -> Mapping[str, Any]:
        return {"actuators": {}, "sensors": {}, "push": []}

    def thrust_limit(self, scenario: Scenario) -> tuple[str, float]:
        return "actuators.thrust_max", float(scenario.values["actuators"]["thrust_max"])

    def command_peaks(self, run: Run) -> tuple[float, ...]:
        return tuple(
            max(float(np.abs(run[name]).max()) for name in names)
            for names in (("u1", "u3"), ("u2", "u4"))
        )

    def arrival(self, run: Run, row: int) -> Mapping[str, float]:
        from multilift.models.planar import move  # noqa: PLC0415 - few runs are a move's

        return move.arrival(cast("PlanarRun", run), row)

    def culprits(self, scenario: Scenario) -> int:
        return endings.CULPRITS

    def reason(self, status: str, culprit: int) -> str:
        return endings.reason(status, culprit)

    def check_worlds(self, columns: Columns) -> None:
        layout.check_worlds(columns)

    def kinds(self, columns: Columns) -> NDArray[np.intp]:
        return layout.ideal_worlds(columns).astype(np.intp)

    def run_worlds(
        self,
        kernel: ModuleType,
        columns: Columns,
        worlds: NDArray[np.intp],
        steps: Steps,
        results: Mapping[str, NDArray[Any] | None],
        *,
        threads: int,
        progress: Callable[[int], None] | None,
    ) -> None:
        layout.run_worlds(
            kernel, columns, worlds, steps, results, threads=threads, progress=progress
        )

    def scene(self, run: Run) -> Scene:
        from multilift.models.planar import scene  # noqa: PLC0415 - few runs are looked at

        return scene.scene(cast("PlanarRun", run))

    def overview(self, runs: Sequence[Run]) -> Figure:
        from multilift.models.planar import plot  # noqa: PLC0415 - loads matplotlib

        return plot.overview(runs)

    def view(self) -> View:
        from multilift.models.planar.page import VIEW  # noqa: PLC0415 - loads the report

        return VIEW

    def closed_loop_matrix(self, scenario: Scenario) -> NDArray[np.float64]:
        return linear.closed_loop_matrix(planar_only(scenario, "this linearisation"))


MODEL = Planar()
