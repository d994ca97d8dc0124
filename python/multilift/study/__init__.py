"""Studies: many worlds of one scenario, what varies, under several laws on the same draws.

A study is a TOML file; ``docs/studies`` explains it. Its result is one Parquet row for each world
and law, a summary and one offline report::

    from multilift import study
    from multilift.study.run import run

    result = run(study.load("robustness_sim1", count=1024), "out/robustness")
"""

from multilift.study.spec import Criterion, Map, Study, load
from multilift.study.vary import Target, Vary

__all__ = ["Criterion", "Map", "Study", "Target", "Vary", "load"]
