"""Draws docs/_static/hero.png, the README's picture: one move under both laws."""

from pathlib import Path

import multilift as ml
import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from multilift import plot

SNAPSHOTS = (0.0, 0.7, 1.4, 2.1, 2.8, 3.5)  # s
LAWS = ("pd", "energy_coupled")


def draw_system(ax, run, time, colour, alpha):
    """Vehicles, cables and bar at a time."""
    k = int(np.searchsorted(run.t, time))
    plant = run.scenario.plant
    ends = []
    for i, side in ((1, 1.0), (2, -1.0)):
        y, z, theta = run[f"y{i}"][k], run[f"z{i}"][k], run[f"theta{i}"][k]
        length = plant.cable_length[i - 1]
        end = (y + side * length * np.sin(theta), z - length * np.cos(theta))
        ax.plot([y, end[0]], [z, end[1]], color="0.35", lw=0.8, alpha=alpha)
        phi = run.thrust_attitude()[f"attitude{i}_applied"][k]
        arm = 0.17 * np.array([np.cos(phi), -np.sin(phi)])
        up = 0.06 * np.array([np.sin(phi), np.cos(phi)])
        ax.plot([y - arm[0], y + arm[0]], [z - arm[1], z + arm[1]], color=colour, lw=2.2,
                alpha=alpha, solid_capstyle="round")  # fmt: skip
        for sign in (-1, 1):
            hub = np.array([y, z]) + sign * arm + up
            blade = 0.6 * arm
            ax.plot([hub[0] - blade[0], hub[0] + blade[0]], [hub[1] - blade[1], hub[1] + blade[1]],
                    color=colour, lw=1.0, alpha=alpha)  # fmt: skip
        ends.append(end)
    ax.plot(*zip(*ends, strict=True), color=colour, lw=4.5, alpha=alpha, solid_capstyle="butt")


def main():
    """Draws and saves the picture."""
    scenario = ml.load("sim2").with_values(
        {
            "start.vehicle_position": [[-1.7, 2.2], [0.1, 2.2]],
            "goal.vehicle_position": [[1.9, 2.9], [3.7, 2.9]],
            "simulation.duration": 12.0,
        }
    )
    runs = {law: ml.simulate(scenario, law) for law in LAWS}
    looks = dict(zip(LAWS, plot.styles(list(runs.values())), strict=True))
    with rc_context({**plot.RC, "axes.grid": False}):
        figure = Figure(figsize=(10.4, 4.6), layout="constrained")
        axes = figure.subplot_mosaic(
            [["pd", "swing"], ["energy_coupled", "swing"]], width_ratios=[1.35, 1]
        )
        for law, look in looks.items():
            ax = axes[law]
            for k, time in enumerate(SNAPSHOTS):
                draw_system(
                    ax, runs[law], time, look.colour, 0.18 + 0.82 * (k + 1) / len(SNAPSHOTS)
                )
            ax.plot(runs[law]["bar_y"], runs[law]["bar_z"], color=look.colour, lw=0.9, alpha=0.6)
            ax.set_aspect("equal")
            ax.set_xlim(-2.0, 4.3)
            ax.set_ylim(0.3, 3.15)
            ax.set_axis_off()
            ax.set_title(f"{look.label}, every {SNAPSHOTS[1]:g} s", loc="left", color=look.colour,
                         fontweight="bold", fontsize=10)  # fmt: skip
            axes["swing"].plot(runs[law].t, np.degrees(runs[law]["theta1"]), color=look.colour,
                               ls=look.dash, label=look.label, lw=1.6)  # fmt: skip
        ax = axes["swing"]
        ax.axhspan(-1, 1, color="0.93", lw=0)
        ax.annotate("±1°", (11.9, 1.1), ha="right", va="bottom", color="0.45")
        ax.set_xlabel("time (s)")
        ax.set_ylabel(r"cable angle $\theta_1$ (deg)")
        ax.set_xlim(0, 12)
        ax.legend(frameon=False, loc="lower right")
        figure.savefig(Path(__file__).with_name("_static") / "hero.png", dpi=130)


if __name__ == "__main__":
    main()
