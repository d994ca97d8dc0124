"""How fast multilift is, MuJoCo on the same system beside it, and the core's own limit.

Everything runs in one process and in turns, so that what else the machine does falls on all alike:
compare numbers of one run only.
"""

from multilift.bench.free_bodies import mujoco_free_bodies
from multilift.bench.rows import Row, print_rows
from multilift.bench.run import run_benchmarks
from multilift.bench.tree import mujoco_tree

__all__ = ["Row", "mujoco_free_bodies", "mujoco_tree", "print_rows", "run_benchmarks"]
