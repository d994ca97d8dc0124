"""From a scenario to a run."""

from __future__ import annotations

from typing import Any

from multilift import controllers
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
    return scenario.model.simulate(scenario, law)
