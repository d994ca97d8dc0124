"""The result of one simulated scenario."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from multilift import provenance, storage
from multilift.controllers import PythonLaw
from multilift.errors import MissingExtraError, ScenarioError
from multilift.quantities import Quantity

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from multilift.controllers import CompiledLaw
    from multilift.quantities import Quantities
    from multilift.saved import SavedLaw
    from multilift.scenario import Scenario


class Run:
    """Trajectory, metrics and audit of a run, and how it ended.

    A run is of its model's class, which may have more to say of it: a
    :class:`~multilift.models.planar.run.PlanarRun` of a planar scenario.

    Attributes:
        scenario: what was simulated, complete.
        controller: name of the law; ``controller_title`` is its line for figures.
        status: "finished", or what ended it early: one of the model's.
        culprit: index of what ended it, of its kind; -1 for none.
        end_time: when it ended, s; the scenario's duration if it finished.
        metrics: by name, in the units of ``quantities.metrics``; NaN where there is no value,
            such as the settling time of a swing that never settled.
        audit: energy audit by entry, J; see ``docs/audit``.
    """

    def __init__(
        self,
        scenario: Scenario,
        law: CompiledLaw | PythonLaw | SavedLaw,
        result: dict[str, Any],
    ) -> None:
        self.scenario = scenario
        self.controller = law.name
        self.controller_title = law.title
        self.status = str(result["status"])
        self.culprit = int(result["culprit"])
        self.end_time = float(result["end_time"])
        self._least_time: float | None = None
        self.metrics: dict[str, float] = dict(result["metrics"])
        self.audit: dict[str, float] = dict(result["audit"])
        columns = result.get("columns")  # where they were saved
        if columns is None:
            columns = zip(self.quantities.columns, np.asarray(result["samples"]).T, strict=True)
        self._columns: dict[str, NDArray[np.float64]] = dict(columns)
        if isinstance(law, PythonLaw):
            for name in self.quantities.law_columns:  # of what a law of one's own does not tell
                del self._columns[name]

    def compare_with(self, least_time: float) -> None:
        """Compares its combined settling with a move's bound, where it is shown or saved.

        Args:
            least_time: of the time-optimal move of this scenario (`multilift.limit`), s.
        """
        self._least_time = least_time

    def beyond_metrics(self) -> list[tuple[Quantity, float]]:
        """What is shown after the metrics: the move's bound, and the settling as its multiple."""
        if self._least_time is None:
            return []
        multiple = self.metrics["combined_settling"] / self._least_time
        return [
            (Quantity("least_time", "s", "bound: the time-optimal move, from rest to rest"),
             self._least_time),
            (Quantity("settling_multiple", "", "combined_settling in parts of the bound"),
             multiple),
        ]  # fmt: skip

    @property
    def quantities(self) -> Quantities:
        """Names, units and meanings of columns, metrics and audit entries."""
        return self.scenario.quantities

    @property
    def t(self) -> NDArray[np.float64]:
        """Times of the rows, s."""
        return self._columns["t"]

    @property
    def columns(self) -> list[str]:
        """Names of the trajectory's columns; ``quantities.columns`` has units and meanings."""
        return list(self._columns)

    @property
    def finished(self) -> bool:
        """Whether the run reached its end with every assumption intact."""
        return self.status == "finished"

    @property
    def ending(self) -> str:
        """How the run ended, as a sentence."""
        when = f"at t = {self.end_time:.3f} s"
        if self.finished:
            return f"ran to its end {when}"
        return f"stopped {when}: {self.scenario.model.reason(self.status, self.culprit)}"

    @property
    def residuals(self) -> dict[str, float]:
        """Largest amounts by which the run missed what must hold exactly, by name."""
        return {name: float(np.nanmax(self._columns[name])) for name in self.quantities.residuals}

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        """A column of the trajectory, such as ``run["theta1"]``; SI and radians."""
        try:
            return self._columns[column]
        except KeyError:
            raise KeyError(f"no column {column!r}; there are {', '.join(self._columns)}") from None

    def __repr__(self) -> str:
        return f"Run({self.scenario.name!r}, {self.controller!r}: {self.ending})"

    def to_dataframe(self) -> pd.DataFrame:
        """The trajectory as a pandas table: ``columns`` and the controller's name.

        Raises:
            MissingExtraError: without pandas (``multilift[data]``).
        """
        try:
            import pandas as pd  # noqa: PLC0415
        except ImportError:
            raise MissingExtraError("pandas", "data", "Run.to_dataframe()") from None
        frame = pd.DataFrame(self._columns)
        frame["controller"] = pd.Categorical([self.controller] * len(frame))
        return frame

    def plot(self) -> Figure:
        """One figure of the whole run: positions, angles, commands.

        Raises:
            MissingExtraError: without matplotlib (``multilift[plot]``).
        """
        return self.scenario.model.overview([self])

    def summary(self) -> dict[str, Any]:
        """Status, metrics and audit as JSON-ready values; numbers that do not exist are None."""
        return {
            "controller": self.controller,
            "status": self.status,
            "ending": self.ending,
            "end_time": self.end_time,
            "metrics": {k: finite(v) for k, v in self.metrics.items()},
            "audit": {k: finite(v) for k, v in self.audit.items()},
            **{quantity.name: finite(v) for quantity, v in self.beyond_metrics()},
            **{k: finite(v) for k, v in self.residuals.items()},
        }

    def save(self, target: str | Path, *, force: bool = False) -> Path:
        """Writes trajectory, metrics, scenario and provenance into a new folder.

        Args:
            target: folder to make; it appears only when complete.
            force: replace an earlier result there.

        Returns:
            The folder, with ``trajectory.parquet``, ``metrics.json``, ``scenario.toml``,
            ``run.json`` and, as far as ``multilift[report]`` is installed, ``overview.png`` and
            ``report.html``, the run's replay, figure and numbers as one offline page.

        Raises:
            OutputError: if the folder is taken or cannot be written.
            MissingExtraError: without pyarrow (``multilift[data]``).
        """
        target = Path(target)
        with storage.new_folder(target, force=force) as folder:
            write_parquet(self, folder / "trajectory.parquet")
            result = {self.scenario.name: {self.controller: self.summary()}}
            write_json(folder / "metrics.json", result)
            (folder / "scenario.toml").write_text(self.scenario.to_toml(), encoding="utf-8")
            write_json(folder / "run.json", self.provenance())
            try:
                figure = self.plot()
            except MissingExtraError:
                return target  # data without a picture, where matplotlib is not installed
            figure.savefig(folder / "overview.png")
            page = self._page((folder / "overview.png").read_bytes())
            if page is not None:
                (folder / "report.html").write_text(page, encoding="utf-8")
        return target

    def _page(self, overview: bytes) -> str | None:
        """The run's page; None where the page's packages are missing or the run has no shape."""
        try:
            from multilift.report import flight  # noqa: PLC0415 - loads the plotting packages

            return flight.render(self, overview)
        except (ImportError, ScenarioError):
            return None

    def provenance(self) -> dict[str, Any]:
        """What made this run: versions, platform, seed, law, and how it ended."""
        return {
            **provenance.describe(),
            "scenario": self.scenario.name,
            "controller": self.controller,
            "seed": self.scenario.values["simulation"]["seed"],
            "ending": self.ending,
            "culprit": self.culprit,
        }


def write_json(file: Path, content: Any) -> None:
    """Writes JSON that people can read and diff."""
    file.write_text(json.dumps(content, indent=2, allow_nan=False) + "\n", encoding="utf-8")


def write_parquet(run: Run, file: Path) -> None:
    """Writes the trajectory with each column's unit and meaning in its field metadata.

    Raises:
        MissingExtraError: without pyarrow (``multilift[data]``).
    """
    try:
        import pyarrow as pa  # noqa: PLC0415
        import pyarrow.parquet as pq  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError("pyarrow", "data", "writing Parquet") from None
    fields, arrays = [], []
    for name in run.columns:
        quantity = run.quantities.columns[name]
        meta = {"unit": quantity.unit, "description": quantity.doc}
        fields.append(pa.field(name, pa.float64(), metadata=meta))
        arrays.append(pa.array(run[name]))
    codes = pa.array(np.zeros(len(run.t), dtype=np.int32))
    arrays.append(pa.DictionaryArray.from_arrays(codes, pa.array([run.controller])))
    fields.append(
        pa.field("controller", arrays[-1].type, metadata={"description": "name of the law"})
    )
    meta = {"scenario": run.scenario.name, "multilift": provenance.describe()["multilift"]}
    pq.write_table(pa.table(arrays, schema=pa.schema(fields, metadata=meta)), file)


def finite(x: float) -> float | None:
    """A number, or None where it is no finite one, for JSON."""
    return x if math.isfinite(x) else None
