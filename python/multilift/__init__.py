"""multilift: multirotors that carry one load together on cables.

    import multilift as ml

    run = ml.simulate(ml.load("sim1"))
    print(run.metrics["peak_swing_1"], run.audit["internal_force"])

World axes are y (right) and z (up); SI units and radians inside, degrees only where people read.
"""

from importlib.metadata import version

from multilift.batch import Batch, simulate_batch
from multilift.errors import (
    ControllerError,
    MissingExtraError,
    MultiliftError,
    OutputError,
    ScenarioError,
)
from multilift.gradient import Gradient, gradient
from multilift.models.planar.laws import Measurement
from multilift.run import Run
from multilift.scenario import Scenario, load
from multilift.simulate import simulate
from multilift.worlds import Worlds

__version__ = version("multilift")

__all__ = [
    "Batch",
    "ControllerError",
    "Gradient",
    "Measurement",
    "MissingExtraError",
    "MultiliftError",
    "OutputError",
    "Run",
    "Scenario",
    "ScenarioError",
    "Worlds",
    "__version__",
    "gradient",
    "load",
    "simulate",
    "simulate_batch",
]
