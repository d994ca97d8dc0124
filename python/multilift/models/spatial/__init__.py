"""n vehicles and a payload on cables in three dimensions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from multilift import _core, layout, pushes
from multilift.controllers import CompiledLaw, PythonLaw
from multilift.errors import ScenarioError
from multilift.models import Model
from multilift.models.spatial import endings, gradient, laws, quantities, rows, vehicles
from multilift.models.spatial.checks import MOST_MASS_RATIO
from multilift.models.spatial.flying import FlyingLaw
from multilift.models.spatial.formation import BALANCE_TOLERANCE
from multilift.models.spatial.run import SpatialRun
from multilift.models.spatial.scenario import SpatialScenario, spatial_only
from multilift.models.spatial.tables import LAWS, MOTION_CAPTURE, TABLES
from multilift.models.spatial.world import SpatialWorld
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

__all__ = ["MODEL", "FlyingLaw", "Spatial", "SpatialWorld"]


class Spatial(Model):
    """See `multilift.models.Model`."""

    name = "spatial"
    title = "n vehicles, a payload and cables that may go slack, in space"
    tables = TABLES
    laws = LAWS
    statuses = endings.STATUSES
    outcomes = endings.OUTCOMES
    culprit_doc = "always -1"
    clock = (*Model.clock, "motion_capture.period")
    delays = ("link.delay", "link.jitter", "motion_capture.period", "motion_capture.delay")
    random_keys = (
        "link.jitter",
        "link.loss",
        "wind.gust_speed",
        "motion_capture.dropout",
        *(f"motion_capture.{f.name}" for f in MOTION_CAPTURE.fields if f.name.endswith("noise")),
    )
    without_derivative = gradient.WITHOUT_DERIVATIVE
    described = quantities.quantities(2, quadrotors=True)
    study_metrics = ("peak_swing", "swing_settling_time", "position_settling_time",
                     "payload_error_rms", "storage_rise")  # fmt: skip

    def given(self, raw: Mapping[str, Any], where: str) -> Mapping[str, Any]:
        return vehicles.fill_in(raw, where)

    @property
    def scenario_type(self) -> type[SpatialScenario]:
        return SpatialScenario

    def quantities(self, scenario: Scenario) -> Quantities:
        return quantities.quantities(
            scenario["plant.vehicles"], scenario["vehicle.kind"] == "quadrotor"
        )

    @property
    def run_type(self) -> type[SpatialRun]:
        return SpatialRun

    def simulate(self, scenario: Scenario, law: CompiledLaw | PythonLaw) -> SpatialRun:
        frame, row, seed = rows.problem(scenario)
        own = None
        if isinstance(law, PythonLaw):
            own = laws.callback(law, cast("SpatialScenario", scenario))
        result = _core.spatial_run(_core.SpatialFrame(**frame), row, seed, own)
        return SpatialRun(scenario, law, {**result, "culprit": -1})

    def differentiate(self, scenario: Scenario, keys: Sequence[str]) -> Mapping[str, Any]:
        return gradient.differentiate(spatial_only(scenario, "multilift.gradient"), keys)

    def move(self, scenario: Scenario, limits: Limits) -> Move:
        from multilift.models.spatial import move  # noqa: PLC0415 - needs CasADi

        return move.move(spatial_only(scenario, "multilift.limit"), limits)

    def unhindered(self, scenario: Scenario) -> Mapping[str, Any]:
        return {
            "vehicle.kind": "ideal", "start.rotors": "running",
            **{name: {} for name in ("link", "motion_capture", "wind", "safety", "ground")},
            "push": [], "event": [],
        }  # fmt: skip

    def thrust_limit(self, scenario: Scenario) -> tuple[str, float]:
        return "limits.thrust_max", float(max(scenario.values["limits"]["thrust_max"]))

    def command_peaks(self, run: Run) -> tuple[float, ...]:
        from multilift.models.spatial import move  # noqa: PLC0415 - few runs are a move's

        return move.command_peaks(cast("SpatialRun", run))

    def arrival(self, run: Run, row: int) -> Mapping[str, float]:
        from multilift.models.spatial import move  # noqa: PLC0415 - few runs are a move's

        return move.arrival(cast("SpatialRun", run), row)

    def culprits(self, scenario: Scenario) -> int:
        return 1

    def reason(self, status: str, culprit: int) -> str:
        return endings.reason(status)

    def check_worlds(self, columns: Columns) -> None:
        with np.errstate(all="ignore"):  # what is not finite is caught by the comparisons
            bad = layout.bad_timing(columns) | pushes.bad_worlds(columns)
            bad |= _bad_rest(columns) | _too_heavy(columns)
        layout.refuse_first(columns, bad)
        _refuse_moved_paths(columns)

    def kinds(self, columns: Columns) -> NDArray[np.intp]:
        return rows.ideal_worlds(columns).astype(np.intp)

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
        table, seeds = rows.rows(columns, worlds)
        told = not rows.ideal_worlds(columns)[worlds[0]]
        frame = kernel.SpatialFrame(**rows.frame(columns.scenario, steps, motion_capture=told))
        kernel.run_spatial(
            frame=frame, rows=table, seeds=seeds, **results, threads=threads, progress=progress
        )

    def scene(self, run: Run) -> Scene:
        from multilift.models.spatial import scene  # noqa: PLC0415 - few runs are looked at

        return scene.scene(cast("SpatialRun", run))

    def overview(self, runs: Sequence[Run]) -> Figure:
        from multilift.models.spatial import plot  # noqa: PLC0415 - loads matplotlib

        return plot.overview(cast("Sequence[SpatialRun]", runs))


def _bad_rest(columns: Columns) -> NDArray[np.bool_]:
    """Worlds whose formation does not hold, or whose cables would start stretched."""
    block = rows.Block(columns, np.arange(columns.count))
    rest = rows.rest_of(block)
    bad = ~(rest.unbalanced <= BALANCE_TOLERANCE) | ~(rest.least_tension > 0)
    if columns.scenario["plant.cables"] == "rigid":
        payload, places = rows.starts(block, rest)
        excess = rows.cable_lengths(block, payload, places) - block.numbers("plant", "cable_length")
        bad |= ~(excess.max(axis=1) <= 1e-6)
    return np.asarray(bad)


def _too_heavy(columns: Columns) -> NDArray[np.bool_]:
    """Worlds in which a vehicle is so heavy beside the payload that tensions are lost."""
    heaviest = columns.numbers("plant.vehicle_mass").max(axis=1)
    return np.asarray(~(heaviest <= MOST_MASS_RATIO * columns.numbers("plant.payload_mass")))


def _refuse_moved_paths(columns: Columns) -> None:
    """A path is worked out once for all worlds, from the scenario's own start and goal."""
    if columns.scenario["reference.kind"] == "step":
        return
    for key in ("start.payload_position", "start.payload_yaw", "goal.payload_position",
                "goal.payload_yaw"):  # fmt: skip
        if columns.is_own(key):
            raise ScenarioError(
                "differs from world to world, but the reference's path is the same for all",
                where=columns.scenario.where, key=key,
                advice='use reference.kind = "step", or a batch for each path',
            )  # fmt: skip


MODEL = Spatial()
