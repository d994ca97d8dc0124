"""A flight beside its simulation, and the folder that shows both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np

from multilift import storage
from multilift.flight.replay.flown import Flown
from multilift.flight.replay.ulog import Compared
from multilift.models.spatial.run import SpatialRun
from multilift.run import finite, write_json, write_parquet
from multilift.simulate import simulate


@dataclass(frozen=True)
class Difference:
    """How far the flight was from its simulation, over the time that both have.

    Attributes:
        name: of a body.
        rms, most: distances of its positions, m.
    """

    name: str
    rms: float
    most: float


@dataclass(frozen=True)
class Replay:
    """A flight, its simulation, and what the autopilots recorded of it.

    Attributes:
        flown: the log.
        compared: with recordings, by the vehicles' numbers from 1.
    """

    flown: Flown
    compared: Mapping[int, Compared]

    @cached_property
    def flight(self) -> SpatialRun:
        """The course of the scenario as it was flown."""
        return self.flown.course_run()

    @cached_property
    def simulation(self) -> SpatialRun:
        """The same scenario simulated."""
        run = cast("SpatialRun", simulate(self.flown.scenario))
        run.controller, run.controller_title = "simulation", "simulation"
        return run

    @cached_property
    def differences(self) -> Sequence[Difference]:
        """Of the payload, then of the vehicles."""
        flight, simulated = self.flight, self.simulation
        both = flight.t <= simulated.t[-1]
        found = []
        for name in ("payload", *(f"vehicle{k + 1}" for k in range(flight.scenario.count))):
            there = np.column_stack(
                [np.interp(flight.t[both], simulated.t, axis) for axis in simulated.vector(name).T]
            )
            apart = np.linalg.norm(flight.vector(name)[both] - there, axis=1)
            found.append(Difference(name, float(np.sqrt(np.mean(apart**2))), float(apart.max())))
        return found

    @property
    def unexplained(self) -> float:
        """What the storage function did that no entry of the audit explains, part of its start."""
        audit = self.flight.audit
        return audit["largest_integration_error"] / max(abs(audit["storage_start"]), 1e-9)

    def summary(self) -> dict[str, Any]:
        """Everything in numbers, ready for JSON."""
        return {
            "log": self.flown.path.name,
            "scenario": self.flown.scenario.name,
            "complete": self.flown.complete,
            "ticks": len(self.flown.t),
            "unread": self.flown.unread,
            "flight": self.flight.summary(),
            "simulation": self.simulation.summary(),
            "differences": {d.name: {"rms": d.rms, "most": d.most} for d in self.differences},
            "states": [
                {"time": c.time, "state": c.state, "problems": list(c.problems)}
                for c in self.flown.changes
            ],
            "ulog": {
                f"vehicle_{k}": {name: finite(x) for name, x in c.numbers.items()}
                for k, c in self.compared.items()
            },
        }

    def save(self, target: Path, *, force: bool = False) -> None:
        """Writes everything into a new folder; see docs/flight-replay.md.

        Raises:
            OutputError: if the folder is taken or cannot be written.
            MissingExtraError: without ``multilift[report]``.
        """
        from multilift.flight.replay import page  # noqa: PLC0415 - loads the plotting packages

        whole = self.flown.whole_run()
        with storage.new_folder(target, force=force) as folder:
            self.flight.save(folder / "flight")
            self.simulation.save(folder / "simulation")
            write_parquet(whole, folder / "whole.parquet")
            write_json(folder / "replay.json", self.summary())
            write_json(folder / storage.MARKER, self.flight.provenance())
            for k, compared in self.compared.items():
                compared.to_csv(folder / f"ulog_vehicle_{k}.csv")
            (folder / "report.html").write_text(page.render(self, whole), encoding="utf-8")
