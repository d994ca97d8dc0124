"""Many worlds stepped by hand: forces in, one control period, states out."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift import _core, batch
from multilift import isa as instruction_sets
from multilift.errors import ControllerError, ScenarioError
from multilift.models.planar import MODEL, layout
from multilift.models.planar.scenario import planar_only
from multilift.overrides import Columns
from multilift.scenario import Scenario

if TYPE_CHECKING:
    import pandas as pd

#: Names of a world's statuses by their code; -1, the last, while it runs.
STATUSES = np.array([*MODEL.statuses, "running"])


class Worlds:
    """Worlds of one scenario under a law of your own, which may be vectorised over all of them.

    ::

        worlds = ml.Worlds(scenario, count=1000)
        while worlds.running.any():
            worlds.step(law(worlds.measured_q, worlds.measured_q_dot))

    A step commands each world's forces for one control period, ``1 / controller.rate``, with the
    plant, actuators, sensors, integrator and pushes of ``simulate``: given the commands of the
    scenario's law on what is measured, a world goes through the same states to the last bit. The
    force commanded to a vehicle is u plus the gravity share of the masses that
    ``controller.assumed`` holds. With ideal actuators it acts at once and without limits; otherwise
    it goes through the scenario's limits, delay and lags.

    Actuators and sensors are taken as ideal where those of every world are at construction. If one
    world has an imperfection, all go through the simulated actuators and sensors, which give a
    world that has none its states to round-off.

    Noise follows from each world's ``simulation.seed`` and its own samples alone. Worlds that share
    a seed, as they do unless overrides say otherwise, see the same noise, and a world that is reset
    sees its own again.

    A world ends when its duration is over or an assumption breaks, and stays as it was then.

    The arrays are views that each step overwrites: copy what you want to keep. They must not be
    used, nor another step begun, while a step runs in another thread.

    Attributes:
        scenario: what the worlds have in common.
        count: number of worlds.
        period: control period, s.
        q: coordinates y1, z1, y2, z2, m, theta1..3, rad; shape (count, 7).
        q_dot: their rates, shape (count, 7).
        measured_q: the same coordinates as the sensors tell them at this control instant, with
            noise, delay and sampling period; ``q`` itself where all is ideal; shape (count, 7).
        measured_q_dot: their rates, likewise, shape (count, 7).
        saturated: whether each vehicle's last command hit a limit, shape (count, 2).
        ideal: whether actuators and sensors are.
        tension: of both cables at the end of the period, under the forces held until then; those of
            u = 0 before the first step, those that ended it after a world's end; N, shape
            (count, 2).
        t: each world's time since its start, s, shape (count,).
        culprit: index of the slack cable or of the angle at its limit; -1 for none; shape (count,).
    """

    q: NDArray[np.float64]
    q_dot: NDArray[np.float64]
    measured_q: NDArray[np.float64]
    measured_q_dot: NDArray[np.float64]
    saturated: NDArray[np.bool_]
    tension: NDArray[np.float64]
    t: NDArray[np.float64]
    culprit: NDArray[np.int8]

    def __init__(
        self,
        scenario: Scenario,
        overrides: Mapping[str, ArrayLike] | pd.DataFrame | None = None,
        *,
        count: int | None = None,
        threads: int | None = None,
        isa: str | None = None,
    ) -> None:
        """Puts every world at its start.

        Args:
            scenario: what the worlds have in common.
            overrides: as of :func:`multilift.simulate_batch`; keys of the clock excepted.
            count: number of worlds, where no override says.
            threads: None for one a processor.
            isa: instruction set to use; None for the widest (:mod:`multilift.isa`).

        Raises:
            ScenarioError: for a scenario that is not planar, for overrides that no scenario file
                may hold, and for those that would give worlds clocks of their own.
        """
        self.scenario = scenario = planar_only(scenario, "multilift.Worlds")
        self.period = scenario.control_period()
        self._given: dict[str, ArrayLike] = dict(batch.as_mapping(overrides) or {})
        columns = self._columns(self._given, count)
        self.count = columns.count
        self.ideal = layout.is_ideal(columns)
        self._threads = threads or os.cpu_count() or 1
        self._rows, self._seeds = layout.rows(columns, np.arange(self.count))
        values = scenario.values["simulation"]
        arrays: dict[str, NDArray[Any]] = {
            "q": np.zeros((self.count, 7)),
            "q_dot": np.zeros((self.count, 7)),
            "saturated": np.zeros((self.count, 2), dtype=bool),
            "tension": np.zeros((self.count, 2)),
            "t": np.zeros(self.count),
            "status": np.zeros(self.count, dtype=np.int8),
            "culprit": np.zeros(self.count, dtype=np.int8),
        }
        for name in ("q", "q_dot"):
            measured = arrays[name] if self.ideal else np.zeros((self.count, 7))
            arrays[f"measured_{name}"] = measured
        self._core = instruction_sets.kernel(isa).Worlds(
            law=scenario.law,
            rows=self._rows,
            seeds=self._seeds,
            pushes=layout.push_shapes(scenario),
            step=values["step"],
            steps=round(values["duration"] / values["step"]),
            control_steps=round(self.period / values["step"]),
            ideal=self.ideal,
            **arrays,
        )
        for name, array in arrays.items():
            view = array.view()
            view.flags.writeable = False
            setattr(self, "_status" if name == "status" else name, view)

    _status: NDArray[np.int8]

    @property
    def status(self) -> NDArray[np.str_]:
        """Each world's "running", "finished", "slack", "swing_limit" or "diverged"; (count,)."""
        return STATUSES[self._status]

    @property
    def running(self) -> NDArray[np.bool_]:
        """Which worlds have not ended, shape (count,)."""
        return np.less(self._status, 0)

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which worlds ended by a slack cable, an angle at its limit or divergence; (count,)."""
        return np.greater(self._status, 0)

    @property
    def goal(self) -> NDArray[np.float64]:
        """Where each world's vehicles shall come to rest, y1, z1, y2, z2, m, shape (count, 4)."""
        end = self._rows.shape[1] - 6 * len(self.scenario.values["push"])
        return self._rows[:, end - 4 : end].copy()

    def step(self, forces: Any) -> None:
        """Commands forces for one control period and updates the arrays.

        Args:
            forces: u1, u2, u3, u4 of each world, N, shape (count, 4): a NumPy array, or one of any
                library that shares memory by DLPack (PyTorch, JAX, CuPy after a copy to the CPU).
                What ended worlds are given does not matter.

        Raises:
            ControllerError: for anything but (count, 4) numbers.
        """
        shape = tuple(getattr(forces, "shape", ()))
        if not shape:
            forces = np.asarray(forces, dtype=float)
            shape = forces.shape
        if shape != (self.count, 4):
            raise ControllerError(
                f"forces have the shape {shape}\n"
                f"  permitted: ({self.count}, 4), u1, u2, u3, u4 in N for each world"
            )
        try:
            self._core.step(forces, self._threads)
        except TypeError:
            raise ControllerError(
                f"forces are a {type(forces).__name__} of {getattr(forces, 'dtype', '?')}\n"
                "  permitted: real numbers in the memory of the processor, as NumPy or DLPack holds"
                " them"
            ) from None

    def reset(
        self, mask: ArrayLike | None = None, overrides: Mapping[str, ArrayLike] | None = None
    ) -> None:
        """Puts worlds back to their starts.

        Args:
            mask: which, booleans of shape (count,); None for all.
            overrides: new numbers for them, with one entry for every world; only those of the mask
                are looked at. Keys that are not given keep what was given last. For noise that
                differs from the last time, a new ``simulation.seed``.

        Raises:
            ScenarioError: as on construction, for a mask of another shape, and for actuators or
                sensors that are not ideal where all were.
        """
        chosen = np.ones(self.count, dtype=bool) if mask is None else np.asarray(mask)
        if chosen.shape != (self.count,) or chosen.dtype != np.bool_:
            raise ScenarioError(
                f"the mask is {chosen.dtype} of shape {chosen.shape}",
                where="Worlds.reset",
                permitted=f"booleans of shape ({self.count},)",
            )
        which = np.flatnonzero(chosen)
        if overrides is not None and len(which) > 0:
            given = {**self._given, **overrides}
            columns = self._columns(given, self.count)
            if self.ideal and not layout.is_ideal(columns):
                raise ScenarioError(
                    "gets actuators or sensors that are not ideal, where those of all worlds were",
                    where=f"{self.scenario.where}, Worlds.reset",
                    advice="give one world an imperfection when you make the Worlds",
                )
            self._rows[which], self._seeds[which] = layout.rows(columns, which)
            self._given = given
        self._core.reset(np.ascontiguousarray(chosen))

    def _columns(self, given: Mapping[str, ArrayLike], count: int | None) -> Columns:
        columns = Columns(self.scenario, given, count)
        own_clock = [key for key in MODEL.clock if columns.is_own(key)]
        if own_clock:
            raise ScenarioError(
                "differs from world to world, but worlds are stepped by one clock",
                where=f"{self.scenario.where}, overrides",
                key=own_clock[0],
                advice="change the scenario by with_values, and make Worlds for each value",
            )
        layout.check_worlds(columns)
        self._check_samples(columns)
        return columns

    def _check_samples(self, columns: Columns) -> None:
        """Refuses more samples under way than there is room for.

        Worlds side by side may begin at different control instants, so that together they sample
        as often as the common divisor of sampling and control period.
        """
        step = self.scenario["simulation.step"]
        control = round(self.period / step)
        sampling = round(self.scenario["sensors.period"] / step) or control
        longest = round(float(columns.numbers("sensors.delay").max()) / step)
        if longest + control > (_core.planar_delay_capacity - 2) * math.gcd(sampling, control):
            raise ScenarioError(
                "is too long for worlds that are reset one by one",
                where=self.scenario.where,
                key="sensors.delay",
                value=longest * step,
                advice="make sensors.period a multiple of the control period, or a part of it",
            )
