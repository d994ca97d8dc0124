"""All spatial laws on the same tasks, tuned with the same effort; see ``docs/comparison``.

Each contender draws its gains N times from its own ranges by a Sobol sequence, flies all of them at
once, keeps the set of least cost and flies that again under the scenario's own seed.
"""

from multilift.compare.contenders import CONTENDERS, Contender
from multilift.compare.run import DRAWS, SEED, TASKS, Comparison, Task, compare
from multilift.compare.tuning import Tuned, costs, tune

__all__ = [
    "CONTENDERS",
    "DRAWS",
    "SEED",
    "TASKS",
    "Comparison",
    "Contender",
    "Task",
    "Tuned",
    "compare",
    "costs",
    "tune",
]
