"""Tuning: any numbers of a scenario so that its metrics become best; see ``docs/tuning``.

A tuning says what varies (`space`), what makes a set of numbers better than another (`goals`) and
how sets are chosen (`strategies`); `search` flies them and remembers every one, so that it goes on
where it was killed; `judge` says what it was worth::

    from multilift import tune
    from multilift.tune.run import run

    result = run(tune.load("settle", scenario="sim1"), "out/tuned")
    print(result.after.numbers)
"""

from multilift.tune.goals import Constraint, Goal, Objective
from multilift.tune.space import Space
from multilift.tune.spec import Tuning, load, parse

__all__ = ["Constraint", "Goal", "Objective", "Space", "Tuning", "load", "parse"]
