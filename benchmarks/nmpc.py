"""NMPC on the paper's moves: settling, and what a plan costs.

python benchmarks/nmpc.py

The table of docs/planning.md. Ideal: the planar plant, and the spatial one with ideal forces.
Testbed: lag, delay and noise as the scenarios have them, in space with quadrotors. Same limits of
force as the bound.
"""

from __future__ import annotations

import multilift as ml
import numpy as np
from multilift.controllers import PythonLaw
from multilift.nmpc import Nmpc

#: Time-optimal from rest to rest, s: multilift limit, docs/limit.md.
BOUND = {"sim1": 1.93, "sim2": 2.03, "exp1_1": 1.88, "exp1_2": 1.87}
#: From measurement to force in space, where the attitude loop is no first-order lag: by trial, s.
LEAD = {"spatial": 0.15}


def row(name: str, *, ideal: bool) -> str:
    """Flies one scenario."""
    scenario = ml.load(name).with_values({"simulation.duration": 8.0})
    if ideal:
        scenario = scenario.with_values(scenario.model.unhindered(scenario))
    made: list[Nmpc] = []
    lead = 0.0 if ideal else LEAD.get(scenario.model.name)

    def make(given: ml.Scenario) -> object:
        made.append(Nmpc(given, lead=lead))
        return made[-1].step

    run = ml.simulate(scenario, PythonLaw("nmpc", "NMPC", make))
    plans = made[0].plans
    seconds = 1e3 * np.array([p.seconds for p in plans])
    settled = run.metrics["combined_settling"]
    swing = run.metrics["peak_swing" if "peak_swing" in run.metrics else "peak_swing_1"]
    bound = BOUND[name.removesuffix("_quadrotors")]
    return (
        f"| {name} | {'ideal' if ideal else 'testbed'} | {settled:.2f} | {settled / bound:.2f} | "
        f"{swing:.1f} | {np.median(seconds):.0f} | {seconds.max():.0f} | "
        f"{sum(not p.solved for p in plans)} of {len(plans)} |"
    )


def main() -> None:
    """Prints a row a flight."""
    for name in BOUND:
        print(row(name, ideal=True), flush=True)
    for name in ("exp1_1", "exp1_2"):
        print(row(name, ideal=False), flush=True)
    for name in ("exp1_1_quadrotors", "exp1_2_quadrotors"):
        for ideal in (True, False):
            print(row(name, ideal=ideal), flush=True)


if __name__ == "__main__":
    main()
