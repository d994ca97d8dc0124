"""Logs of flights that were simulated, written as the flight program writes them."""

import numpy as np
from multilift.flight import lab, record
from multilift.flight.estimate.state import BodyState, Estimate, Fault, Quality, Standing
from multilift.flight.link.setpoint import SetPoint
from multilift.flight.log import Log
from multilift.flight.supervisor import State

GOOD = Standing(Quality.GOOD, Fault.NONE, 0.0, 0.01)
ZERO = (0.0, 0.0, 0.0)
START = 1000.0


class Rows:
    """A run's rows as an estimator and a flight program tell them."""

    def __init__(self, run):
        self.count = run.scenario.count
        names = {f"vehicle_{i + 1}": f"vehicle{i + 1}" for i in range(self.count)}
        self.bodies = {
            told: (run.vector(name), run.vector(f"{name}_v"), run.attitude(name),
                   run.vector(f"{name}_rate"))
            for told, name in {**names, "payload": "payload"}.items()
        }  # fmt: skip
        each = range(1, self.count + 1)
        self.force = np.stack([run.vector(f"force{i}") for i in each], axis=1)
        self.drag = np.stack([run.vector(f"d_hat{i}") for i in each], axis=1)

    def estimate(self, k, now):
        bodies = {}
        for name, columns in self.bodies.items():
            position, velocity, attitude, rate = (tuple(c[k].tolist()) for c in columns)
            bodies[name] = BodyState(GOOD, position, velocity, ZERO, attitude, rate, 0.0, 0.0)
        return Estimate(now, GOOD, bodies, ())

    def set_points(self, k, now):
        """What is sent for the forces that the law asked for."""
        points = []
        for force in self.force[k]:
            size = float(np.linalg.norm(force))
            # The shortest turn from up to the force.
            half = np.array([size + force[2], -force[1], force[0], 0.0])
            half /= np.linalg.norm(half)
            points.append(SetPoint(tuple(half.tolist()), size, now, now))
        return points


def states_of(run, before, after):
    """What is done in each row: hover, fly the run, hover."""
    rows = range(len(run.t))
    return [
        *((State.FORM_UP, 0) for _ in range(before)),
        *((State.FLY, k) for k in rows),
        *((State.SET_DOWN, rows[-1]) for _ in range(after)),
    ]


def write(path, flown_lab, run, course, begin=True):
    """A log of a course: what was done and which row of the run was seen, at each of its records.

    Time goes on by a record's period a tick.
    """
    period, rows = float(run.t[1] - run.t[0]), Rows(run)
    log = Log(path, START)
    if begin:
        record.begin(log, flown_lab, START)
    for k, (state, row) in enumerate(course):
        now = START + k * period
        record.tick(
            log, now, state, rows.estimate(row, now), rows.set_points(row, now), rows.drag[row]
        )
        log.raw("out/vehicle_1", now, b"\xfd" * 20)
    log.close()
    return path


def twin(scenario, folder):
    """A lab of twins of a scenario's file or name."""
    return lab.parse({"scenario": str(scenario)}, "lab", folder)
