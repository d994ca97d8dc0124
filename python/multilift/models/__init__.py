"""The models: each is a plant with its tables, laws, numbers, endings and figures, by name.

``plant.model`` of a scenario names its model; everything general asks the model and knows none:

* A model is one object, a :class:`Model`, in a package of its own that is imported when it is
  first asked for. :func:`by_name` finds it, :func:`of` the one that a scenario's tables name.
* Its tables say what a file may hold. Shapes may hold names of sizes, such as ``("n", 3)``; a
  field with ``size="n"`` says what n is in a scenario. ``Model.tables_of`` gives a scenario's own
  tables, with numbers for names and the gains of its law.
* A scenario is of its model's class (``Model.scenario_type``), which checks what the tables must
  satisfy together and works out the start; a run is of the class that ``Model.simulate`` returns.
* Columns, metrics and audit entries, with units and meanings, are ``Model.quantities(scenario)``.
* Batches: a model checks all worlds at once, lays them out as rows and calls its kernel; timing,
  chunks, threads and results are general.
* Studies, reports, figures and the command line ask for endings and names, nothing more.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.schema import Table, controller_fields

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from multilift.controllers import CompiledLaw, PythonLaw
    from multilift.limit.bounds import Limits
    from multilift.limit.move import Move
    from multilift.overrides import Columns
    from multilift.quantities import Quantities
    from multilift.replay.scene import Scene
    from multilift.report.contents import View
    from multilift.run import Run
    from multilift.scenario import Scenario
    from multilift.steps import Steps

DEFAULT = "planar"

#: Where each model of multilift is; a module is imported when its model is first asked for.
_MODULES = {"planar": "multilift.models.planar", "spatial": "multilift.models.spatial"}
_FOUND: dict[str, Model] = {}


@dataclass(frozen=True)
class LawInfo:
    """A compiled law: one line for figures and tables, and its gains in the core's order."""

    title: str
    gains: tuple[Field, ...]


class Model(ABC):
    """What a model offers to everything general; subclasses are stateless, one object each.

    Attributes:
        name: what ``plant.model`` says.
        title: the plant, one phrase.
        tables: what a file may hold besides ``[controller]``, by name, in the order of a written
            file; ``[plant]`` has the field ``model``. The one of a name such as
            ``controller.assumed`` lies inside another.
        laws: the compiled laws by name.
        statuses: how a run can end, in the order of the core's codes; "finished" is the first.
        outcomes: the same in the order in which tables and figures show them.
        culprit_doc: what a culprit is the index of, a phrase for tables.
        clock: keys that set when things happen; worlds that agree in all of them share a rollout.
        delays: keys of times that count whole integration steps, none permitted.
        random_keys: keys of numbers that, where not 0, let a run draw from ``simulation.seed``.
        without_derivative: metrics that count integration steps, so that they stand still and jump.
        described: what runs return, for the reference page; where names depend on the scenario, one
            stands for all of its kind.
        study_metrics: what a study summarises unless it says otherwise.
    """

    name: str
    title: str
    tables: Mapping[str, Table]
    laws: Mapping[str, LawInfo]
    statuses: tuple[str, ...]
    outcomes: tuple[str, ...]
    culprit_doc: str
    clock: tuple[str, ...] = (
        "simulation.duration",
        "simulation.step",
        "simulation.record_period",
        "controller.rate",
    )
    delays: tuple[str, ...] = ()
    random_keys: tuple[str, ...] = ()
    without_derivative: tuple[str, ...] = ()
    described: Quantities
    study_metrics: tuple[str, ...]

    # Tables.

    def given(self, raw: Mapping[str, Any], where: str) -> Mapping[str, Any]:
        """A file's tables with what they name elsewhere, such as a vehicle's own file.

        Raises:
            ScenarioError: if there is no such thing.
        """
        return raw

    def sizes(self, raw: Mapping[str, Any], where: str) -> dict[str, int]:
        """What the names of sizes in shapes are in a scenario, from its tables as given.

        Raises:
            ScenarioError: if a field that says a size is wrong or missing.
        """
        result = {}
        for table in self.tables.values():
            for field in table.fields:
                if field.size:
                    given = raw.get(table.name, {})
                    if isinstance(given, Mapping):
                        given = {k: v for k, v in given.items() if k == field.name}
                    own = Table(table.name, table.doc, (field,)).normalise(given, where)
                    result[field.size] = own[field.name]
        return result

    def controller_table(self, law: str) -> Table:
        """The ``[controller]`` table for a compiled law."""
        fields = (*controller_fields(tuple(self.laws)), *self.laws[law].gains)
        return Table("controller", self.laws[law].title, fields)

    def tables_of(self, values: Mapping[str, Any], where: str = "scenario") -> dict[str, Table]:
        """Every table of a scenario by name, its law's among them, with numbers for sizes.

        Args:
            values: complete, as ``Scenario.values``.
            where: for errors.
        """
        sizes = self.sizes(values, where)
        tables = {**self.tables, "controller": self.controller_table(values["controller"]["law"])}
        return {name: table.resolved(sizes) for name, table in tables.items()}

    def controller_keys(self, law: str) -> set[str]:
        """What ``[controller]`` may hold under a law: its fields, and tables inside it."""
        inside = {name.split(".")[1] for name in self.tables if name.startswith("controller.")}
        return {field.name for field in self.controller_table(law).fields} | inside

    # Scenarios and runs.

    @property
    @abstractmethod
    def scenario_type(self) -> type[Scenario]:
        """The class of this model's scenarios; its ``_check`` checks it and works out the start."""

    @abstractmethod
    def quantities(self, scenario: Scenario) -> Quantities:
        """Names, units and meanings of what a run of this scenario returns."""

    @property
    def run_type(self) -> type[Run]:
        """The class of this model's runs."""
        from multilift.run import Run  # noqa: PLC0415 - a run asks its model

        return Run

    @abstractmethod
    def simulate(self, scenario: Scenario, law: CompiledLaw | PythonLaw) -> Run:
        """Runs a scenario under a law that `controllers.resolve` found."""

    def move(self, scenario: Scenario, limits: Limits) -> Move:
        """The scenario's move as an optimal control problem (`multilift.limit`).

        Raises:
            ScenarioError: if this model has none, or the scenario or the limits leave no move.
        """
        raise ScenarioError(
            "is a plant without equations for a bound", where=scenario.where, key="plant.model",
            value=self.name, permitted="planar or spatial",
        )  # fmt: skip

    def free_coordinates(
        self, scenario: Scenario, measured: Any
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """What a law has measured, in the coordinates of `move`.

        Args:
            scenario: whose plant it is.
            measured: as the model's laws are told.

        Returns:
            The coordinates and their rates, shape (coordinates,) each.
        """
        raise NotImplementedError

    def unhindered(self, scenario: Scenario) -> Mapping[str, Any]:
        """Values of a scenario in which forces act at once and nothing disturbs or ends a move."""
        raise NotImplementedError

    def thrust_limit(self, scenario: Scenario) -> tuple[str, float]:
        """The key that limits a vehicle's thrust, and the greatest that it permits any, N."""
        raise NotImplementedError

    def command_peaks(self, run: Run) -> tuple[float, ...]:
        """The greatest force commanded along each axis, beyond what holds a vehicle at rest, N."""
        raise NotImplementedError

    def arrival(self, run: Run, row: int) -> Mapping[str, float]:
        """How far a run is from rest at its goal in one of its rows.

        Returns:
            ``position``, the farthest vehicle from its goal, m; ``speed``, the fastest vehicle's,
            m/s; ``swing``, the greatest angle of the load, deg.
        """
        raise NotImplementedError

    @abstractmethod
    def culprits(self, scenario: Scenario) -> int:
        """How many things of a kind can end a run: culprits are counted from 0 to below this."""

    @abstractmethod
    def reason(self, status: str, culprit: int) -> str:
        """Why a run ended, in a few words for tables; empty if it finished."""

    # Batches.

    @abstractmethod
    def check_worlds(self, columns: Columns) -> None:
        """What the scenario's class checks, for every world at once; see `multilift.layout`.

        Raises:
            ScenarioError: for the first world that no scenario file may hold.
        """

    def kinds(self, columns: Columns) -> NDArray[np.intp]:
        """A code for each world; worlds of different codes are run apart."""
        return np.zeros(columns.count, dtype=np.intp)

    @abstractmethod
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
        """Simulates worlds of one clock and one kind with the batch kernel.

        Args:
            kernel: of `multilift.isa.kernel`.
            columns: the numbers of all worlds.
            worlds: which to run.
            steps: their times in integration steps.
            results: arrays to fill, one row for each of `worlds`: metrics, audit, final_state,
                end_time, status (the code), culprit and samples (None: not wanted).
            threads: how many.
            progress: told how many worlds are done.

        Raises:
            ScenarioError: for a world that turns out impossible as its start is worked out.
        """

    # Figures, pages and analysis.

    @abstractmethod
    def overview(self, runs: Sequence[Run]) -> Figure:
        """One figure of runs of one scenario, saved with every run; see `multilift.plot.stack`."""

    def scene(self, run: Run) -> Scene:
        """What a run looks like in space, for replays; not every model has a shape.

        Raises:
            ScenarioError: if this one has none.
        """
        raise ScenarioError(
            "has no shape to replay", where=run.scenario.where, key="plant.model", value=self.name
        )

    def view(self) -> View:
        """What the report's animation and curves show of a run, if the model has such a page."""
        raise NotImplementedError(f"the model {self.name!r} has no report page")

    def differentiate(self, scenario: Scenario, keys: Sequence[str]) -> Mapping[str, Any]:
        """A run over dual numbers, for `multilift.gradient`; not every model has one.

        Returns:
            A table with "status", "culprit" and "end_time" as of a run, and with the "values" of
            final state, metrics and audit in the order of ``scenario.quantities`` and the
            "derivatives" of each, key by key.

        Raises:
            ScenarioError: for keys along which there are no derivatives.
        """
        raise ScenarioError(
            "has no derivatives", where=scenario.where, key="plant.model", value=self.name
        )

    def closed_loop_matrix(self, scenario: Scenario) -> NDArray[np.float64]:
        """See `multilift.linear.closed_loop_matrix`; not every model has one."""
        raise ScenarioError(
            "has no linearisation", where=scenario.where, key="plant.model", value=self.name
        )


def names() -> tuple[str, ...]:
    """The models there are, multilift's own first."""
    return tuple(dict.fromkeys([*_MODULES, *_FOUND]))


def law_names() -> tuple[str, ...]:
    """The compiled laws of all models."""
    return tuple(dict.fromkeys(law for name in names() for law in by_name(name).laws))


def register(model: Model) -> None:
    """Makes a model known by its name, beside those of multilift."""
    _FOUND[model.name] = model


def by_name(name: str) -> Model:
    """The model of a name.

    Raises:
        KeyError: if there is none.
    """
    if name not in _FOUND:
        register(import_module(_MODULES[name]).MODEL)
    return _FOUND[name]


def of(raw: Mapping[str, Any], where: str) -> Model:
    """The model that a scenario's tables name in ``plant.model``.

    Args:
        raw: as a TOML file holds them, or complete.
        where: for errors.

    Raises:
        ScenarioError: if there is no such model.
    """
    plant = raw.get("plant")
    name = plant.get("model", DEFAULT) if isinstance(plant, Mapping) else DEFAULT
    return by_name(
        Field("model", "", "text", choices=names()).normalise(name, where, "plant.model")
    )
