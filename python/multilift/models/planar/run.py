"""A run of the planar plant: recoveries after pushes, thrust and attitude, how it ended."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import ScenarioError
from multilift.models.planar import endings
from multilift.models.planar.scenario import PlanarScenario
from multilift.run import Run, finite


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


class PlanarRun(Run):
    """Trajectory, metrics and audit of a planar run; see :class:`multilift.Run`.

    ``status`` is "finished", "slack", "swing_limit" or "diverged"; ``culprit`` the index of the
    slack cable or of the angle at its limit.
    """

    scenario: PlanarScenario

    @property
    def ending(self) -> str:
        """How the run ended, as a sentence."""
        return endings.sentence(self)

    @property
    def closure_residual(self) -> float:
        """Largest distance by which the seven coordinates miss the bar's geometry, m."""
        return self.residuals["closure_residual"]

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

    def summary(self) -> dict[str, Any]:
        """As of any run, and the recoveries."""
        recoveries = [{k: finite(v) for k, v in asdict(r).items()} for r in self.recoveries()]
        return {**super().summary(), "recoveries": recoveries}


def planar_run(run: Run) -> PlanarRun:
    """The run as a planar one, for what knows no other plant.

    Raises:
        ScenarioError: for a run of another model.
    """
    if not isinstance(run, PlanarRun):
        raise ScenarioError(
            "is not the plant of a planar run", where=run.scenario.where, key="plant.model",
            value=run.scenario.model.name, permitted="planar",
        )  # fmt: skip
    return run
