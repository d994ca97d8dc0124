"""The paper's job: its five tests, figures and claims, from scenario files to one report.

Chai, Liang, Yang, Han (2022), Energy-based nonlinear adaptive control for collaborative
transportation systems, Aerospace Science and Technology 126, 107510.
"""

from multilift.paper.reproduce import Result, reproduce, summary_table

__all__ = ["Result", "reproduce", "summary_table"]
