"""The physical bound of a move: time-optimal, least-effort and least-swing control.

See ``docs/limit``. The search needs CasADi, the extra ``limit``.
"""

from multilift.limit.bound import Bound, find, of_the_scenario
from multilift.limit.bounds import Limits
from multilift.limit.errors import LimitError

__all__ = ["Bound", "LimitError", "Limits", "find", "of_the_scenario"]
