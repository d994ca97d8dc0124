"""The shipped flights end as their files say."""

import multilift as ml
import numpy as np


def test_a_set_down_load_and_its_vehicles_rest_on_the_floor_with_slack_cables():
    run = ml.simulate(ml.load("takeoff_to_setdown"))
    assert run.finished
    assert run.metrics["payload_tilt_max"] < 5.0  # it is carried level
    resting = run.t > run.end_time - 2.0
    standing = {"payload": 0.05} | {f"vehicle{k}": 0.15 for k in (1, 2, 3)}  # m, as the file says
    for body, height in standing.items():
        # The floor is a spring that gives way by millimetres, and holds sideways by a friction that
        # is viscous below 2 cm/s.
        assert np.abs(run[f"{body}_z"][resting] - height).max() < 2e-3, body
        assert np.linalg.norm(run.vector(f"{body}_v")[resting], axis=1).max() < 5e-3, body
    assert max(run[f"tension{k}"][resting].max() for k in (1, 2, 3)) == 0.0
    lifted = run["payload_z"] > 0.9
    assert lifted.any()
    assert min(run[f"tension{k}"][lifted].min() for k in (1, 2, 3)) > 0.0
    assert np.abs(run["payload_x"][-1] - 2.0) < 0.05
