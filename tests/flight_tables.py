"""The numbers of docs/flights.md: what each column's head means, from a run."""

from __future__ import annotations

import math
import re

import multilift as ml
import numpy as np

_FLIGHT = re.compile(r"`(\w+)`")


def flown(flight, law):
    """The run that a row is about: a law's name, with gains after a comma as in "pd, k_i = 1"."""
    name, *changes = law.split(", ")
    changes = {f"controller.{key}": float(x) for key, x in (c.split(" = ") for c in changes)}
    scenario = ml.load(flight)
    if name != scenario.law:
        scenario = scenario.with_law(name)
    return ml.simulate(scenario.with_values(changes))


def metric(name, digits, factor=1.0):
    """A metric with so many digits, a dash where there is none."""

    def show(run, push):
        x = factor * run.metrics[name]
        return "–" if math.isnan(x) else f"{x:.{digits}f}"

    return show


def swing(run):
    """Of the cable that swings farthest, deg."""
    return np.degrees(run.swing().max(axis=1))


def vehicles_off(run):
    """Of the vehicle farthest from its target, m."""
    count = run.scenario.count
    apart = [run.vector(f"vehicle{k}") - run.vector(f"goal{k}") for k in range(1, count + 1)]
    return np.linalg.norm(apart, axis=2).max(axis=0)


def last(seconds, values):
    """The mean of the last so many seconds."""
    return lambda run: values(run)[run.t > run.end_time - seconds].mean()


def tilt(run):
    """Of the payload, deg."""
    q = run.attitude("payload")
    return np.degrees(np.arccos(np.clip(1.0 - 2.0 * (q[:, 1] ** 2 + q[:, 2] ** 2), -1.0, 1.0)))


def payload_off(run):
    """Distance of the payload from its target, m."""
    return np.linalg.norm(run.vector("payload") - run.vector("target"), axis=1)


def after(values, bound):
    """From a push until values stay below a bound up to the next push, s."""

    def show(run, push):
        begin, part = span(run, push)
        over = np.flatnonzero(part & (values(run) > bound))
        return f"{run.t[over[-1]] - begin:.1f}"

    return show


def greatest(values, digits, factor=1.0):
    """Greatest of values from a push to the next."""
    return lambda run, push: f"{factor * values(run)[span(run, push)[1]].max():.{digits}f}"


def span(run, push):
    """When a push, counted from 1, begins, and the rows until the next one."""
    starts = [p["start"] for p in run.scenario["push"]] + [np.inf]
    return starts[push - 1], (run.t >= starts[push - 1]) & (run.t < starts[push])


def ending(run, push):
    """Whether a flight reached its end."""
    return "its end" if run.finished else f"{run.status} at {run.end_time:.1f} s"


#: What stands under each head.
COLUMNS = {
    "swing (°)": metric("peak_swing", 1),
    "still after (s)": metric("swing_settling_time", 1),
    "vehicles there after (s)": metric("position_settling_time", 1),
    "payload there after (s)": metric("payload_settling_time", 1),
    "vehicles off at the end (cm)": lambda run, _: f"{100 * last(5.0, vehicles_off)(run):.2f}",
    "payload off at the end (cm)": lambda run, _: f"{100 * last(5.0, payload_off)(run):.2f}",
    "swing after it (°)": greatest(swing, 1),
    "still again after (s)": after(swing, 1.0),
    "vehicles back after (s)": after(vehicles_off, 0.02),
    "vehicles pulled off (cm)": greatest(vehicles_off, 1, 100.0),
    "payload off at most (cm)": metric("payload_error_max", 1, 100.0),
    "tilt (°)": metric("payload_tilt_max", 1),
    "heading off (°)": metric("payload_yaw_error_max", 1),
    "tensions (N)": lambda run, _: (
        f"{run.metrics['min_tension']:.1f} to {run.metrics['max_tension']:.1f}"
    ),
    "vehicles apart (m)": metric("vehicle_distance_min", 2),
    "slack for (s)": metric("slack_time", 1),
    "pulled taut": metric("impacts", 0),
    "hardest pull (N s)": metric("hardest_impulse", 2),
    "reached": ending,
    "tilt at the end (°)": lambda run, _: f"{last(3.0, tilt)(run):.0f}",
    "payload off at the end (m)": lambda run, _: f"{last(3.0, payload_off)(run):.2f}",
    "greatest tension (N)": metric("max_tension", 1),
}


def tables(text):
    """Every table that begins with flights: its heads, and its rows as lists of cells."""
    found, heads = [], None
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|"):
            heads = None
        elif heads is None:
            heads = cells
            if heads[0] == "flight":
                found.append((heads, []))
        elif heads[0] == "flight" and not set(line) <= set("|-: "):
            found[-1][1].append(cells)
    return found


def row(heads, cells):
    """What a row must read: its flight, its law, its push, then the columns' numbers."""
    told = dict(zip(heads, cells, strict=True))
    flight = _FLIGHT.search(told["flight"]).group(1)
    run = flown(flight, told.get("law", "energy_coupled").strip("`"))
    push = int(told.get("push", 1))
    return [COLUMNS[head](run, push) if head in COLUMNS else told[head] for head in heads]
