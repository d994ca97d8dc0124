"""A snapshot with something in every part, for those who show them."""

from multilift.flight.snapshot import (
    CaptureShown,
    Happening,
    Margin,
    PayloadShown,
    Snapshot,
    Timing,
    VehicleShown,
)


def vehicle(k, **changes):
    values = {
        "name": f"vehicle_{k + 1}", "system": k + 1, "firmware": "px4", "link_age": 0.21,
        "armed": True, "mode": "fly", "failsafe": False, "landed": False, "voltage": 15.4,
        "charge": 0.87, "order": "set-points of the plan", "position": (1.5 * k - 1.5, 0.0, 2.0),
        "velocity": (0.1, 0.0, 0.0), "attitude": (1.0, 0.0, 0.0, 0.0), "error": 0.031,
        "tilt": 0.02, "thrust": 16.4, "command": 0.52, "swing": 0.11, "tension": 1.9,
        "said": ("Takeoff detected",), "dropped": {"alien": 2},
    }  # fmt: skip
    return VehicleShown(**(values | changes))


def snapshot(**changes):
    values = {
        "time": 31.4, "title": "Two craft and a bar", "scenario": "exp1_1_quadrotors",
        "twin": True, "state": "fly", "lasted": 4.2, "words": ("hold", "land", "kill"),
        "problems": (), "checks": (("vehicle 1: heartbeat", True), ("vehicle 2: level", False)),
        "vehicles": (vehicle(0), vehicle(1, charge=None, tension=None, swing=None)),
        "payload": PayloadShown((-0.75, 0.0, 0.8), (1.0, 0.0, 0.0, 0.0), (-0.7, 0.0, 0.8), 0.05),
        "capture": CaptureShown(0.012, "good", "", 3140, {"late": 1}),
        "margins": (Margin("swing", 0.11, 0.8, "rad", 0.14), Margin("hold", None, 3.0, "s", None)),
        "timing": Timing(100.0, 3140, 2, 1e-4, 3e-3, 6e-4, 2e-3, 8e-3, 1.9e-2),
        "happenings": (Happening(29.2, "lift: done", False), Happening(30.0, "swings", True)),
        "log": "flights/one.mcap", "unlogged": 0,
    }  # fmt: skip
    return Snapshot(**(values | changes))
