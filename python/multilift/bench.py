"""How fast multilift is, and MuJoCo on the same system, measured in one process.

Everything runs on one thread and in turns, so that what else the machine does falls on all alike:
compare numbers of one run only.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rich.console import Console
from rich.table import Table

from multilift import _core
from multilift.models.planar.scenario import PlanarScenario, planar_only
from multilift.scenario import Scenario, load
from multilift.simulate import simulate

GOAL_RATIO = 20  # times MuJoCo's speed
GOAL_LAW = 100.0  # ns a step of the control law

#: What one repetition does: simulations of 15000 steps, steps of MuJoCo, steps of the law.
_RUNS = 5
_MUJOCO_STEPS = 10_000
_LAW_STEPS = 1_000_000

_MUJOCO_TREE = """
<mujoco>
  <option timestep="{step}" gravity="0 0 -{gravity}" integrator="RK4">
    <flag contact="disable"/>
  </option>
  <worldbody>
    <body name="bar">
      <inertial pos="0 0 0" mass="{m3}" diaginertia="{bar} {bar} {bar}"/>
      <joint type="slide" axis="0 1 0"/>
      <joint type="slide" axis="0 0 1"/>
      <joint type="hinge" axis="1 0 0"/>
      <body name="vehicle_1" pos="0 -{half} {l3}">
        <inertial pos="0 0 {l1}" mass="{m1}" diaginertia="{rod} {rod} {rod}"/>
        <joint type="hinge" axis="1 0 0"/>
      </body>
      <body name="vehicle_2" pos="0 {half} {l3}">
        <inertial pos="0 0 {l2}" mass="{m2}" diaginertia="{rod} {rod} {rod}"/>
        <joint type="hinge" axis="1 0 0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@dataclass(frozen=True)
class Row:
    """One measured number.

    Attributes:
        label: what was measured.
        median: over the repetitions; None if it could not be measured.
        best: the least time or, of a ratio, that of the least times.
        unit: of both; "" for a ratio.
        note: the goal it stands against, or what it leaves out.
    """

    label: str
    median: float | None
    best: float | None
    unit: str
    note: str


def run_benchmarks(repetitions: int = 7) -> list[Row]:
    """Measures a simulation, MuJoCo beside it, their ratio, and the control law alone.

    Args:
        repetitions: how many turns everything takes.
    """
    scenario = load("sim1")
    scenario = scenario.with_values({"simulation.record_period": scenario["simulation.duration"]})
    scenario = planar_only(scenario, "the benchmark")
    ours, theirs, law = _simulation(scenario), _mujoco(scenario), _law(scenario)
    times: dict[str, list[float]] = {"ours": [], "theirs": [], "law": []}
    for _ in range(repetitions):
        times["ours"].append(ours())
        if theirs is not None:
            times["theirs"].append(theirs())
        times["law"].append(law())
    rows = [
        _row(
            "multilift: Sim 1, RK4, with control, metrics and energy audit",
            times["ours"],
            "simulate(), called from Python, recording start and end",
        )
    ]
    if theirs is None:
        rows.append(Row("MuJoCo on the same plant", None, None, "", "is not installed"))
    else:
        rows.append(
            _row(
                "MuJoCo: the same plant as a tree of hinges, RK4",
                times["theirs"],
                "under a constant force: no control, metrics or audit",
            )
        )
        ratio = statistics.median(times["theirs"]) / statistics.median(times["ours"])
        best = min(times["theirs"]) / min(times["ours"])
        rows.append(Row("ratio", ratio, best, "", f"goal: {GOAL_RATIO}"))
    rows.append(_row("energy-coupled law alone", times["law"], f"goal: at most {GOAL_LAW:.0f}"))
    return rows


def print_rows(rows: list[Row], console: Console) -> None:
    """Prints what run_benchmarks measured, as a table."""
    table = Table("measured", "median", "best", "", "note", box=None, header_style="bold")
    for row in rows:
        table.add_row(row.label, _whole(row.median), _whole(row.best), row.unit, row.note)
    console.print(table)


def mujoco_tree(scenario: Scenario, step: float, inertia: float = 1e-12) -> str:
    """The plant as an MJCF model without any constraint; tests/test_mujoco.py flies it.

    The bar slides and turns; each vehicle is a point mass on a massless rod that is hinged at the
    bar's end. MuJoCo's y and z are ours. The damping (14) is left out.

    Args:
        scenario: whose plant.
        step: of the integrator, s.
        inertia: rotational inertia of each rod, and of a bar that has none, kg m^2; MuJoCo
            refuses bodies without any.
    """
    plant = planar_only(scenario, "MuJoCo's model").plant
    return _MUJOCO_TREE.format(
        step=step,
        gravity=plant.gravity,
        m1=plant.vehicle_mass[0],
        m2=plant.vehicle_mass[1],
        m3=plant.bar_mass,
        l1=plant.cable_length[0],
        l2=plant.cable_length[1],
        l3=plant.bar_half_thickness,
        half=0.5 * plant.bar_length,
        bar=max(plant.bar_inertia, inertia),
        rod=inertia,
    )


def _simulation(scenario: Scenario) -> Callable[[], float]:
    """Measures a simulation of the scenario, ns a step."""
    steps = round(scenario["simulation.duration"] / scenario["simulation.step"])
    return lambda: _nanoseconds(lambda: [simulate(scenario) for _ in range(_RUNS)], _RUNS * steps)


def _mujoco(scenario: Scenario) -> Callable[[], float] | None:
    """Measures MuJoCo from the same start, ns a step; None if it is not installed."""
    try:
        import mujoco  # noqa: PLC0415 - an optional package
    except ImportError:
        return None
    xml = mujoco_tree(scenario, scenario["simulation.step"])
    model: Any = mujoco.MjModel.from_xml_string(xml)
    data: Any = mujoco.MjData(model)
    plant = scenario.plant
    shares = (plant.vehicle_mass + 0.5 * plant.bar_mass) * plant.gravity

    def measure() -> float:
        mujoco.mj_resetData(model, data)
        data.qpos[2:] = [0.02, 0.05, -0.05]
        data.xfrc_applied[2:, 2] = shares
        return _nanoseconds(lambda: mujoco.mj_step(model, data, _MUJOCO_STEPS), _MUJOCO_STEPS)

    return measure


def _law(scenario: PlanarScenario) -> Callable[[], float]:
    """Measures the scenario's compiled law alone, ns a step."""
    return lambda: float(
        _core.planar_law_nanoseconds(
            scenario.law,
            scenario.gain_values(),
            scenario.assumed_values(),
            scenario.goal_vector().tolist(),
            scenario.control_period(),
            _LAW_STEPS,
        )
    )


def _nanoseconds(work: Callable[[], Any], steps: int) -> float:
    start = time.perf_counter_ns()
    work()
    return (time.perf_counter_ns() - start) / steps


def _row(label: str, times: list[float], note: str) -> Row:
    return Row(label, statistics.median(times), min(times), "ns a step", note)


def _whole(x: float | None) -> str:
    return "" if x is None else f"{x:.0f}"
