"""How much coupling is enough? ``python examples/03_sweep_k_lambda.py [SCENARIO]``.

Runs one scenario, sim1 unless another is named, under growing k_lambda; 0 is the PD law.
"""

import sys

import multilift as ml

scenario = ml.load(sys.argv[1] if len(sys.argv) > 1 else "sim1").with_law("energy_coupled")

print(scenario.title)
print(f"{'k_lambda':>8}{'peak swing':>14}{'quiet after':>13}{'at goal after':>15}{'effort':>14}")
for k_lambda in (0.0, 0.1, 0.2, 0.4, 0.7, 1.0, 1.4, 2.0, 3.0):
    m = ml.simulate(scenario.with_values({"controller.k_lambda": k_lambda})).metrics
    print(
        f"{k_lambda:5.1f} kg{m['peak_swing_1']:10.2f} deg{m['swing_settling_time']:11.1f} s"
        f"{m['position_settling_time']:13.1f} s{m['control_effort']:8.1f} N^2 s"
    )
print("nan: not within the run.")
