"""Logs of flights that were simulated, written as the flight program writes them."""

import numpy as np
from multilift.flight import lab
from multilift.flight.log import Log
from multilift.flight.supervisor import State

START = 1000.0


class Rows:
    """A run's rows as a flight program tells them."""

    def __init__(self, run):
        each = range(1, run.scenario.count + 1)
        names = {f"vehicle_{i}": f"vehicle{i}" for i in each} | {"payload": "payload"}
        self.bodies = {
            told: np.hstack([run.vector(name), run.vector(f"{name}_v"), run.attitude(name),
                             run.vector(f"{name}_rate")])
            for told, name in names.items()
        }  # fmt: skip
        self.force = np.stack([run.vector(f"force{i}") for i in each], axis=1)
        self.drag = np.stack([run.vector(f"d_hat{i}") for i in each], axis=1)
        self.yaw = run["target_yaw"]

    def tick(self, log, now, state, k, steered=True):
        """One period of the loop."""
        bodies = {name: columns[k].tolist() for name, columns in self.bodies.items()}
        log.write("estimate", now, {"age": 0.01, "quality": "good", "fault": "none",
                                    "bodies": bodies})  # fmt: skip
        log.write("supervisor", now, {"state": state.value, "problems": [], "may_send": True})
        if steered:
            log.write("wanted", now, {
                "force": self.force[k].tolist(), "yaw": float(self.yaw[k]),
                "drag_estimate": self.drag[k].tolist(),
            })  # fmt: skip
        log.raw("out/vehicle_1", now, b"\xfd" * 20)


def begin(log, flown_lab):
    """What was to be flown."""
    log.write("lab", START, {"name": flown_lab.name, "title": flown_lab.title, "twin": True,
                             "scenario": flown_lab.scenario.to_toml()})  # fmt: skip


def states_of(run, before, after):
    """What is done in each row: hover, fly the run, hover."""
    rows = range(len(run.t))
    return [
        *((State.FORM_UP, 0) for _ in range(before)),
        *((State.FLY, k) for k in rows),
        *((State.SET_DOWN, rows[-1]) for _ in range(after)),
    ]


def write(path, flown_lab, run, course):
    """A log of a course: what was done and which row of the run was seen, at each of its records.

    Time goes on by a record's period a tick.
    """
    period, rows = float(run.t[1] - run.t[0]), Rows(run)
    log = Log(path, START)
    begin(log, flown_lab)
    for k, (state, row) in enumerate(course):
        rows.tick(log, START + k * period, state, row)
    log.close()
    return path


def twin(scenario, folder):
    """A lab of twins of a scenario's file or name."""
    return lab.parse({"scenario": str(scenario)}, "lab", folder)
