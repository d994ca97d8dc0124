"""multilift: multirotors that carry one load together on cables.

    import multilift as ml

    run = ml.simulate(ml.load("sim1"))
    print(run.metrics["peak_swing_1"], run.audit["internal_force"])

World axes are y (right) and z (up); SI units and radians inside, degrees only where people read.
"""

from importlib.metadata import version

from multilift.batch import Batch, simulate_batch
from multilift.controllers import Measurement
from multilift.errors import (
    ControllerError,
    MissingExtraError,
    MultiliftError,
    OutputError,
    ScenarioError,
)
from multilift.run import Run
from multilift.scenario import Scenario, load
from multilift.simulate import simulate

__version__ = version("multilift")

__all__ = [
    "Batch",
    "ControllerError",
    "Measurement",
    "MissingExtraError",
    "MultiliftError",
    "OutputError",
    "Run",
    "Scenario",
    "ScenarioError",
    "__version__",
    "load",
    "simulate",
    "simulate_batch",
]
