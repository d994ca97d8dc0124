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


def body(run, name, k):
    """A body of a run's row as an estimator tells it."""
    pick = [run.vector(name)[k], run.vector(f"{name}_v")[k], ZERO, run.attitude(name)[k],
            run.vector(f"{name}_rate")[k]]  # fmt: skip
    position, velocity, acceleration, attitude, rate = (tuple(map(float, x)) for x in pick)
    return BodyState(GOOD, position, velocity, acceleration, attitude, rate, 0.0, 0.0)


def estimate(run, k, now):
    bodies = {f"vehicle_{i + 1}": body(run, f"vehicle{i + 1}", k)
              for i in range(run.scenario.count)}  # fmt: skip
    return Estimate(now, GOOD, {**bodies, "payload": body(run, "payload", k)}, ())


def set_points(run, k, now):
    """What is sent for the forces that the law asked for."""
    points = []
    for i in range(run.scenario.count):
        force = run.vector(f"force{i + 1}")[k]
        size = float(np.linalg.norm(force))
        # The shortest turn from up to the force.
        half = np.array([size + force[2], -force[1], force[0], 0.0])
        points.append(SetPoint(tuple((half / np.linalg.norm(half)).tolist()), size, now, now))
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
    period = float(run.t[1] - run.t[0])
    log = Log(path, START)
    if begin:
        record.begin(log, flown_lab, START)
    count = run.scenario.count
    for k, (state, row) in enumerate(course):
        now = START + k * period
        drag = [[float(x) for x in run.vector(f"d_hat{i + 1}")[row]] for i in range(count)]
        record.tick(log, now, state, estimate(run, row, now), set_points(run, row, now), drag)
        log.raw("out/vehicle_1", now, b"\xfd" * 20)
    log.close()
    return path


def twin(scenario, folder):
    """A lab of twins of a scenario's file or name."""
    return lab.parse({"scenario": str(scenario)}, "lab", folder)
