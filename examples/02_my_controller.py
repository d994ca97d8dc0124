"""Two control laws of one's own against the paper's: ``python examples/02_my_controller.py``.

The command line takes them from this file too:
``multilift run sim1 --controller examples/02_my_controller.py:MyLaw``.
"""

import multilift as ml
import numpy as np


class MyLaw:
    """PD towards a goal that leans after the load.

    Each vehicle's goal is shifted along y by `lean` times the load's displacement from below the
    vehicles. The vehicles follow this moving goal with their own lag, and a pivot that follows a
    pendulum late takes energy out of its swing. At rest the load hangs straight, and the goal is
    the scenario's.
    """

    title = "PD, its goal leaning after the load"
    lean = 1.5

    def __init__(self, scenario):
        self.k_p, self.k_d = scenario.controller.k_p, scenario.controller.k_d
        l1, l2 = scenario.plant.cable_length
        self.arms = np.array([0.5 * l1, -0.5 * l2, scenario.plant.bar_half_thickness])

    def step(self, m):
        """u1..u4, N, as one pair (y, z) for each vehicle."""
        displacement = self.arms @ np.sin(m.theta)  # of the load along y, m
        goal = m.goal + np.array([self.lean * displacement, 0.0])
        return -self.k_p * (m.xi - goal) - self.k_d * m.xi_dot


def plain_pd(m):
    """PD, blind to the load; a law without memory or gains to look up can be a function."""
    return -6.0 * (m.xi - m.goal) - 7.0 * m.xi_dot


if __name__ == "__main__":
    print(f"{'test':8}{'law':16}{'peak swing':>12}{'quiet after':>13}{'at goal after':>15}")
    for name in ("sim1", "sim2", "exp1_1", "exp1_2"):
        scenario = ml.load(name)
        for law in ("energy_coupled", "pd", plain_pd, MyLaw):
            run = ml.simulate(scenario, law)
            peak, quiet, there = (
                run.metrics[k]
                for k in ("peak_swing_1", "swing_settling_time", "position_settling_time")
            )
            print(f"{name:8}{run.controller:16}{peak:8.2f} deg{quiet:11.1f} s{there:13.1f} s")
