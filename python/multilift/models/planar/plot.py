"""Figures of planar runs in the paper's layout."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from multilift.models.planar.scenario import planar_only
from multilift.plot import Panel, stack

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from multilift.run import Run

_DEGREE = 180 / np.pi


def response(runs: Sequence[Run]) -> Figure:
    """Positions, angles and drag estimates of runs of one scenario: the paper's Figs. 2, 4, 7, ...

    Args:
        runs: of the same scenario, one for each controller.
    """
    estimates = [
        Panel(f"d_hat_{axis}", rf"$\hat d_{{{axis[0]}{axis[1]}}}$ (N s/m)", 0.02)
        for axis in ("y1", "z1", "y2", "z2")
    ]
    return stack(runs, [*_positions(runs), *_angles(desired=0.0), *estimates], height=1.05)


def commands(runs: Sequence[Run]) -> Figure:
    """The commands u1..u4 of runs of one scenario: the paper's Figs. 3, 5, 8, ..."""
    return stack(runs, _commands(), height=1.4)


def overview(runs: Sequence[Run]) -> Figure:
    """Response and commands in one figure, with the tensions."""
    tensions = [Panel(f"tension{k}", f"$T_{k}$ (N)", 1.0) for k in (1, 2)]
    panels = [*_positions(runs), *_angles(), *_commands(), *tensions]
    return stack(runs, panels, height=0.95)


def _positions(runs: Sequence[Run]) -> list[Panel]:
    goal = planar_only(runs[0].scenario, "this figure").goal_vector()
    return [
        Panel(name, f"${name[0]}_{name[1]}$ (m)", 0.1, desired=float(goal[k]))
        for k, name in enumerate(("y1", "z1", "y2", "z2"))
    ]


def _angles(desired: float | None = None) -> list[Panel]:
    return [Panel(f"theta{k}", rf"$\theta_{k}$ (deg)", 1.0, _DEGREE, desired) for k in (1, 2, 3)]


def _commands() -> list[Panel]:
    return [Panel(f"u{k}", f"$u_{k}$ (N)", 0.2) for k in (1, 2, 3, 4)]
