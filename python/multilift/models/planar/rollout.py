"""The planar rollout in the compiled core, under a compiled law or one written in Python."""

from __future__ import annotations

from multilift import _core
from multilift.controllers import CompiledLaw, PythonLaw
from multilift.models.planar import laws
from multilift.models.planar.run import PlanarRun
from multilift.models.planar.scenario import PlanarScenario
from multilift.models.planar.tables import ACTUATORS, SENSORS
from multilift.schema import flatten
from multilift.steps import Steps


def simulate(scenario: PlanarScenario, law: CompiledLaw | PythonLaw) -> PlanarRun:
    """Runs a scenario to its end or to the first broken assumption."""
    setup = _setup(scenario)
    if isinstance(law, CompiledLaw):
        result = _core.planar_rollout(setup, law.name, scenario.gain_values())
    else:
        result = _core.planar_rollout_python(setup, laws.callback(law, scenario))
    return PlanarRun(scenario, law, result)


def _setup(scenario: PlanarScenario) -> _core.PlanarSetup:
    values = scenario.values
    steps = Steps.of(scenario)
    pieces, path_end = scenario.path
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
        step=steps.step,
        steps=steps.steps,
        control_steps=steps.control_steps,
        record_steps=steps.record_steps,
        actuators=flatten(values["actuators"], ACTUATORS.fields),
        sensors=flatten(values["sensors"], SENSORS.fields),
        ideal=scenario.is_ideal(),
        seed=values["simulation"]["seed"],
        pieces=pieces,
        path_end=path_end,
        view=scenario.view(),
    )
