"""The result of one simulated scenario."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from multilift import provenance, quantities, storage
from multilift.controllers import PythonLaw
from multilift.errors import MissingExtraError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from multilift.controllers import CompiledLaw
    from multilift.scenario import Scenario


@dataclass(frozen=True)
class Recovery:
    """The swing after a push, until the next one.

    Attributes:
        push_start: when the push began, s.
        peak_swing: greatest |theta1| or |theta2|, deg.
        time: from the push's start until both stay below 1 degree, s; NaN if they did not.
    """

    push_start: float
    peak_swing: float
    time: float


class Run:
    """Trajectory, metrics and audit of a run, and how it ended.

    Attributes:
        scenario: what was simulated, complete.
        controller: name of the law; ``controller_title`` is its line for figures.
        status: "finished", "slack", "swing_limit" or "diverged".
        end_time: when it ended, s; the scenario's duration if it finished.
        metrics: by name, in the units of ``quantities.METRICS``; NaN where there is no value,
            such as the settling time of a swing that never settled.
        audit: energy audit by entry, J; see ``docs/audit``.
    """

    def __init__(
        self, scenario: Scenario, law: CompiledLaw | PythonLaw, result: dict[str, Any]
    ) -> None:
        self.scenario = scenario
        self.controller = law.name
        self.controller_title = law.title
        self.status = str(result["status"])
        self.culprit = int(result["culprit"])
        self.end_time = float(result["end_time"])
        self.metrics: dict[str, float] = dict(result["metrics"])
        self.audit: dict[str, float] = dict(result["audit"])
        samples = np.asarray(result["samples"])
        self._columns: dict[str, NDArray[np.float64]] = {
            name: samples[:, k] for k, name in enumerate(quantities.COLUMNS)
        }
        if isinstance(law, PythonLaw):
            for name in quantities.LAW_COLUMNS:  # a law of one's own has no drag estimate here
                del self._columns[name]

    @property
    def t(self) -> NDArray[np.float64]:
        """Times of the rows, s."""
        return self._columns["t"]

    @property
    def columns(self) -> list[str]:
        """Names of the trajectory's columns; ``quantities.COLUMNS`` has units and meanings."""
        return list(self._columns)

    @property
    def finished(self) -> bool:
        """Whether the run reached its end with every assumption intact."""
        return self.status == "finished"

    @property
    def closure_residual(self) -> float:
        """Largest distance by which the seven coordinates miss the bar's geometry, m."""
        return float(np.nanmax(self._columns["closure_residual"]))

    @property
    def ending(self) -> str:
        """How the run ended, as a sentence."""
        when = f"at t = {self.end_time:.3f} s"
        if self.status == "finished":
            return f"ran to its end {when}, cables taut throughout"
        if self.status == "slack":
            return (
                f"stopped {when}: cable {self.culprit + 1} would go slack, where the taut-cable "
                "model ends"
            )
        if self.status == "swing_limit":
            return f"stopped {when}: |theta{self.culprit + 1}| reached 90 degrees, assumption 3"
        last = ", ".join(
            f"{name} = {self._columns[name][-1]:.4g}"
            for name in ("y1", "z1", "y2", "z2", "theta1", "theta2", "theta3")
        )
        return f"diverged {when}: {last}"

    def __getitem__(self, column: str) -> NDArray[np.float64]:
        """A column of the trajectory, such as ``run["theta1"]``; SI and radians."""
        try:
            return self._columns[column]
        except KeyError:
            raise KeyError(f"no column {column!r}; there are {', '.join(self._columns)}") from None

    def __repr__(self) -> str:
        return f"Run({self.scenario.name!r}, {self.controller!r}: {self.ending})"

    def thrust_attitude(self) -> dict[str, NDArray[np.float64]]:
        """Thrust f_i, N, and attitude phi_i, rad towards +y, as commanded and as applied.

        From u by the paper's definition below (6); keys ``thrust1``, ``attitude1``,
        ``thrust1_applied``, ``attitude1_applied`` and the same for vehicle 2.
        """
        result = {}
        # A command is worked out with what the law assumes; what acts, with what is.
        for suffix, table in (("", "controller.assumed"), ("_applied", "plant")):
            masses, bar = (self.scenario[f"{table}.{k}"] for k in ("vehicle_mass", "bar_mass"))
            gravity = self.scenario[f"{table}.gravity"]
            for i in (1, 2):
                along = self[f"u{2 * i - 1}{suffix}"]
                up = self[f"u{2 * i}{suffix}"] + (masses[i - 1] + 0.5 * bar) * gravity
                result[f"thrust{i}{suffix}"] = np.hypot(along, up)
                result[f"attitude{i}{suffix}"] = np.arctan2(along, up)
        return result

    def recoveries(self) -> list[Recovery]:
        """How the swing died away after each push; pushes that start together count as one."""
        starts = sorted({float(push["start"]) for push in self.scenario.values["push"]})
        swing = np.degrees(np.maximum(np.abs(self["theta1"]), np.abs(self["theta2"])))
        result = []
        for start, until in zip(starts, [*starts[1:], math.inf], strict=False):
            window = (self.t >= start - 1e-9) & (self.t < until - 1e-9)
            if not window.any():
                break  # the run ended before
            outside = self.t[window][swing[window] > 1.0]
            settled = outside.size == 0 or outside[-1] < self.t[window][-1]
            cut = not self.finished and until > self.end_time
            last = float(outside[-1]) if outside.size else start
            time = last - start if settled and not cut else math.nan
            result.append(Recovery(start, float(swing[window].max()), time))
        return result

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
        """Positions, angles, estimates and commands as the paper draws them.

        Raises:
            MissingExtraError: without matplotlib (``multilift[plot]``).
        """
        from multilift import plot  # noqa: PLC0415 - loads matplotlib

        return plot.overview([self])

    def summary(self) -> dict[str, Any]:
        """Status, metrics and audit as JSON-ready values; numbers that do not exist are None."""
        return {
            "controller": self.controller,
            "status": self.status,
            "ending": self.ending,
            "end_time": self.end_time,
            "metrics": {k: _finite(v) for k, v in self.metrics.items()},
            "audit": {k: _finite(v) for k, v in self.audit.items()},
            "closure_residual": _finite(self.closure_residual),
            "recoveries": [
                {k: _finite(v) for k, v in asdict(r).items()} for r in self.recoveries()
            ],
        }

    def save(self, target: str | Path, *, force: bool = False) -> Path:
        """Writes trajectory, metrics, scenario and provenance into a new folder.

        Args:
            target: folder to make; it appears only when complete.
            force: replace an earlier result there.

        Returns:
            The folder, with ``trajectory.parquet``, ``metrics.json``, ``scenario.toml``,
            ``run.json`` and, where matplotlib is installed, ``overview.png``.

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
                figure = None  # data without a picture, where matplotlib is not installed
            if figure is not None:
                figure.savefig(folder / "overview.png")
        return target

    def provenance(self) -> dict[str, Any]:
        """What made this run: versions, platform, seed, law, and how it ended."""
        return {
            **provenance.describe(),
            "scenario": self.scenario.name,
            "controller": self.controller,
            "seed": self.scenario.values["simulation"]["seed"],
            "ending": self.ending,
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
        quantity = quantities.COLUMNS[name]
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


def _finite(x: float) -> float | None:
    return x if math.isfinite(x) else None
