"""From a scenario to a run."""

from __future__ import annotations

from typing import Any

from multilift import _core, controllers, schema
from multilift.run import Run
from multilift.scenario import Scenario


def simulate(scenario: Scenario, controller: Any = None) -> Run:
    """Simulates a scenario to its end or to the first broken assumption.

    Args:
        scenario: what to simulate; see :func:`multilift.load`.
        controller: None for the scenario's own law, a compiled law's name, "FILE.py:NAME", or a
            Python function or class (:mod:`multilift.controllers`).

    Returns:
        Trajectory, metrics and audit of the run, and how it ended.

    Raises:
        ControllerError: for a law that cannot be found or stepped.
        ScenarioError: if the scenario lacks a gain that the law needs.
    """
    law, scenario = controllers.resolve(controller, scenario)
    setup = _setup(scenario)
    if isinstance(law, controllers.CompiledLaw):
        result = _core.planar_rollout(setup, law.name, scenario.gain_values())
    else:
        result = _core.planar_rollout_python(setup, law.callback(scenario))
    return Run(scenario, law, result)


def _setup(scenario: Scenario) -> _core.PlanarSetup:
    values = scenario.values
    simulation = values["simulation"]
    step = simulation["step"]
    return _core.PlanarSetup(
        plant=scenario.plant_values(),
        assumed_plant=scenario.assumed_values(),
        q=scenario.q_start.tolist(),
        q_dot=scenario.q_dot_start.tolist(),
        goal=scenario.goal_vector().tolist(),
        pushes=[
            _core.PlanarPush(
                push["body"],
                push["force"],
                push["torque"],
                push["shape"],
                push["start"],
                push["duration"],
                push["frequency"] or 0.0,
                push["sample_times"] or [],
                push["sample_values"] or [],
            )
            for push in values["push"]
        ],
        step=step,
        steps=round(simulation["duration"] / step),
        control_steps=round(scenario.control_period() / step),
        record_steps=round(simulation["record_period"] / step),
        actuators=schema.flatten(values["actuators"], schema.ACTUATORS.fields),
        sensors=schema.flatten(values["sensors"], schema.SENSORS.fields),
        ideal=scenario.is_ideal(),
        seed=simulation["seed"],
    )
