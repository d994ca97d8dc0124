"""A second model, as small as one can be: n masses in three dimensions, each drawn to its goal.

Its shapes depend on n, and so do its columns, bodies and culprits; everything general must take it
as it is. Each coordinate obeys x' = -k x / m, stepped by Euler.
"""

import numpy as np
from multilift import layout, models, plot, pushes, validation
from multilift.fields import Field
from multilift.models import LawInfo, Model
from multilift.quantities import Quantities, Quantity
from multilift.run import Run
from multilift.scenario import Scenario
from multilift.schema import SIMULATION, Table
from multilift.steps import Steps

PLANT = Table(
    "plant",
    "masses in a row",
    (
        Field("model", "which plant", "text", default="row", choices=("row",)),
        Field("vehicles", "how many", "whole", default=2, least=1, most=64, size="n"),
    ),
)
VEHICLES = Table(
    "vehicles",
    "each of them",
    (
        Field("mass", "of each", shape=("n",), unit="kg", range="positive", required=True),
        Field("attachment", "on the load", shape=("n", 3), unit="m", default=0.0),
        Field("start", "where they begin", shape=("n", 3), unit="m", required=True),
        Field("wait", "before they move", unit="s", range="non_negative", default=0.0),
    ),
)
ASSUMED = Table("controller.assumed", "what the law believes", (), follows="")
ASSUMED_VEHICLES = Table(
    "controller.assumed.vehicles", "of the vehicles", VEHICLES.fields, follows="vehicles"
)
PUSH = Table(
    "push",
    "a force",
    (
        Field("body", "on what", "text", required=True, choices=("load", "vehicle_{n}")),
        pushes.START,
        pushes.DURATION,
        *pushes.PROFILE,
    ),
    repeated=True,
)
TABLES = (PLANT, SIMULATION, VEHICLES, ASSUMED, ASSUMED_VEHICLES, PUSH)
SWING = Quantity("largest", "m", "greatest distance at the end")


class RowScenario(Scenario):
    """A scenario of the row."""

    def _check(self):
        validation.check_timing(self.model, self.values, self.where)
        for k, push in enumerate(self.values["push"]):
            pushes.check_profile(push, f"push[{k}]", self.where)
        pushes.check_steps(self.values, self.where)


class Row(Model):
    """See `multilift.models.Model`."""

    name = "row"
    title = "masses in a row"
    tables = {t.name: t for t in TABLES}  # noqa: RUF012 - as in every model
    laws = {"spring": LawInfo("A spring", (Field("k", "stiffness", shape=("n",), default=1.0),))}  # noqa: RUF012
    statuses = ("finished", "diverged", "far")
    outcomes = ("finished", "far", "diverged")
    culprit_doc = "which vehicle, counted from 0; -1 if none"
    delays = ("vehicles.wait",)
    study_metrics = ("largest",)

    @property
    def scenario_type(self):
        return RowScenario

    def quantities(self, scenario):
        n = int(scenario["plant.vehicles"])
        columns = {"t": Quantity("t", "s", "time")} | {
            f"x{i}_{axis}": Quantity(f"x{i}_{axis}", "m", f"vehicle {i}")
            for i in range(1, n + 1)
            for axis in "xyz"
        }
        metrics = {"largest": SWING, "end_m": Quantity("end_m", "", "of a name")}
        return Quantities(
            columns, metrics, {"work": Quantity("work", "J", "done")}, tuple(columns)[1:]
        )

    def culprits(self, scenario):
        return int(scenario["plant.vehicles"])

    def reason(self, status, culprit):
        return {"far": f"vehicle {culprit + 1} was far", "finished": ""}.get(status, status)

    def simulate(self, scenario, law):
        plant = scenario.vehicles
        if hasattr(law, "begin"):
            answer = law.begin(scenario, plant.mass.size, "one stiffness for each vehicle")
            k = np.array(answer(0.0, plant.start))
        else:
            k = scenario.controller.k
        steps = Steps.of(scenario)
        rows, status, culprit = fly(
            plant.mass[None], k[None], plant.start[None], np.array([plant.wait]), steps
        )
        n = len(plant.mass)
        samples = np.column_stack(
            [steps.step * np.arange(steps.steps + 1), rows[:, 0].reshape(-1, 3 * n)]
        )[:: steps.record_steps]
        end = rows[-1, 0]
        return Run(
            scenario,
            law,
            {
                "status": self.statuses[status[0]],
                "culprit": culprit[0],
                "end_time": steps.steps * steps.step,
                "metrics": {"largest": np.linalg.norm(end, axis=1).max(), "end_m": 1.0},
                "audit": {"work": (end**2).sum()},
                "samples": samples,
            },
        )

    def check_worlds(self, columns):
        layout.refuse_first(columns, layout.bad_timing(columns) | pushes.bad_worlds(columns))

    def run_worlds(self, kernel, columns, worlds, steps, results, *, threads, progress):
        n = int(columns.scenario["plant.vehicles"])
        by_name = {f.name: f for f in VEHICLES.resolved({"n": n}).fields}
        mass, start, wait = (
            layout.block(columns, worlds, "vehicles", (by_name[name],))
            for name in ("mass", "start", "wait")
        )
        gain = models.by_name("row").tables_of(columns.scenario.values)["controller"].field("k")
        k = layout.block(columns, worlds, "controller", (gain,))
        start = start.reshape(-1, n, 3)
        rows, status, culprit = fly(mass, k, start, wait[:, 0], steps)
        end = rows[-1]
        results["final_state"][:] = end.reshape(len(worlds), -1)
        results["metrics"][:, 0] = np.linalg.norm(end, axis=2).max(axis=1)
        results["metrics"][:, 1] = 1.0
        results["audit"][:, 0] = (end**2).sum(axis=(1, 2))
        results["end_time"][:] = steps.steps * steps.step
        results["status"][:], results["culprit"][:] = status, culprit

    def overview(self, runs):
        panels = [plot.Panel(f"x1_{axis}", f"$x_{axis}$ (m)", 0.1, desired=0.0) for axis in "xyz"]
        return plot.stack(runs, panels, height=1.0)

    @property
    def described(self):
        return self.quantities(Scenario(raw()))


def fly(mass, k, start, wait, steps):
    """All positions, shape (steps + 1, worlds, n, 3), statuses and culprits; world by world."""
    x = np.array(start, dtype=float)
    rows = [x]
    for step in range(steps.steps):
        moving = (step * steps.step >= wait)[:, None, None]
        x = x - moving * steps.step * (k / mass)[:, :, None] * x
        rows.append(x)
    far = np.linalg.norm(x, axis=2) > 5.0
    status = np.where(far.any(axis=1), 2, 0)
    return np.array(rows), status, np.where(status == 2, far.argmax(axis=1), -1)


def raw(n=2, **tables):
    """The tables of a scenario with n vehicles."""
    base = {
        "plant": {"model": "row", "vehicles": n},
        "simulation": {"duration": 1.0, "step": 0.01, "record_period": 0.1},
        "vehicles": {"mass": 1.5, "start": [1.0, 2.0, 3.0]},
        "controller": {"law": "spring", "rate": 100.0},
    }
    return base | tables
