"""A scenario, a run, its numbers: ``python examples/01_first_run.py [FOLDER]``.

With FOLDER, the result is saved there; otherwise nothing is written.
"""

import sys

import multilift as ml

run = ml.simulate(ml.load("sim1"))
print(run)

print("\nMetrics")
for name, quantity in run.quantities.metrics.items():
    print(f"  {name:24}{run.metrics[name]:12.4f} {quantity.unit}")

print("\nWhere the energy went")
for name, quantity in run.quantities.audit.items():
    print(f"  {name:26}{run.audit[name]:12.3e} {quantity.unit}")

if len(sys.argv) > 1:
    print("\nSaved in", run.save(sys.argv[1]))
