"""The figure of docs/planning.md: the same move four ways.

python docs/planning.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import multilift as ml
import numpy as np
from multilift.models.planar.tables import ACTUATORS, SENSORS

#: Ideal actuators and sensors, the law at 1 kHz.
IDEAL = {
    **{f"{t.name}.{f.name}": f.default for t in (ACTUATORS, SENSORS) for f in t.fields},
    "controller.rate": 1000.0,
    "simulation.duration": 8.0,
}
LIMITS = {
    "reference.speed_max": 2.0,
    "reference.acceleration_max": 2.5,
    "reference.jerk_max": 15.0,
    "reference.snap_max": 60.0,
}
KINDS = {
    "step": "step to the goal",
    "flat": "flat move",
    "zv": "ZV shaper",
    "ei": "EI shaper",
    "antiswing": "two parts",
}


def main() -> None:
    """Draws Exp 1-1 of the paper with ideal actuators along each kind of reference."""
    figure, (place, angle) = plt.subplots(2, 1, figsize=(7.0, 5.0), sharex=True)
    for kind, label in KINDS.items():
        scenario = ml.load("exp1_1").with_values({**IDEAL, **LIMITS, "reference.kind": kind})
        run = ml.simulate(scenario)
        style = {"color": "0.6", "linestyle": "--"} if kind == "step" else {}
        place.plot(run["t"], run["y1"], label=label, **style)
        angle.plot(run["t"], np.degrees(run["theta1"]), **style)
        late = run["t"] >= max(scenario.path[1], 3.0)
        print(f"{kind:10s} ends at {scenario.path[1]:.2f} s, then swings "
              f"{np.degrees(np.abs(run['theta1'][late]).max()):.2f} deg")  # fmt: skip
    place.axhline(-0.3, color="0.85", zorder=0)
    place.set_ylabel("vehicle 1, y / m")
    place.legend(frameon=False, fontsize=8)
    angle.axhspan(-1.0, 1.0, color="0.93", zorder=0)
    angle.set_ylabel("$\\theta_1$ / deg")
    angle.set_xlabel("time / s")
    for axes in (place, angle):
        axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(Path(__file__).parent / "_static" / "planning.png", dpi=150)


if __name__ == "__main__":
    main()
