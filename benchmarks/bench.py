"""Prints how fast multilift is beside MuJoCo: ``python benchmarks/bench.py [REPETITIONS]``."""

import sys

from multilift.bench import print_rows, run_benchmarks
from rich.console import Console

print_rows(run_benchmarks(*map(int, sys.argv[1:2])), Console(width=160))
