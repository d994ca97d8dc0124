"""Nonlinear model-predictive control: the strong law to compare with; see ``docs/planning``.

It is given what no other law has: the plant's equations, and time to solve an optimal control
problem at each of its steps. ``multilift run exp1_1 --controller nmpc``.
"""

from multilift.nmpc.horizon import Horizon, Plan, Weights
from multilift.nmpc.law import Nmpc

__all__ = ["Horizon", "Nmpc", "Plan", "Weights"]
