"""Whole runs of quadrotors with all that is around them: symmetry, and the audit's order."""

import math

import multilift as ml
import numpy as np
import pytest
from spatial_scenarios import plate

N = 3
ANGLE = 2 * np.pi * np.arange(N) / N

#: Unlike vehicles on unlike cables, pushed about; one cable is cut on the way.
BASE = {
    "plant.attachment": np.stack(
        [0.5 * np.cos(ANGLE), 0.5 * np.sin(ANGLE), np.full(N, 0.05)], axis=1
    ),
    "plant.vehicle_mass": np.array([1.3, 1.486, 1.6]),
    "plant.cable_length": np.array([1.1, 1.2, 1.3]),
    "plant.payload_drag": 0.1,
    "vehicle.type": "paper_craft",
    "vehicle.frame_angle": np.array([0.25 * math.pi, 0.0, 0.1]),
    "start.payload_position": np.array([0.1, 0.3, 1.0]),
    "start.payload_yaw": 0.2,
    "goal.payload_position": np.array([1.0, -0.2, 1.5]),
    "goal.payload_yaw": -0.3,
    "wind.mean": np.array([1.0, 0.5, 0.2]),
    "link.delay": 0.02,
    "motion_capture.delay": 0.01,
    "simulation.duration": 2.0,
}
PUSHES = [
    ("payload", [2.0, -1.0, 0.5], [0.1, 0.05, 0.1]),
    ("vehicle_1", [1.0, 2.0, -1.0], [0.0, 0.0, 0.0]),
    ("vehicle_3", [-2.0, 1.0, 1.0], [0.0, 0.0, 0.0]),
]
LAWS = {
    "energy_coupled": {"k_p": 4.5, "k_d": 6.2, "gamma": 0.5, "k_lambda": 0.15},
    "geometric": {},
}


def vehicle(name, order):
    """The new name of a body once vehicle order[k] is called k."""
    if name == "payload":
        return name
    return f"vehicle_{list(order).index(int(name[-1]) - 1) + 1}"


def run(law, gains=None, *, vector=np.asarray, axial=np.asarray, yaw=lambda a: a, body=np.asarray,
        body_axial=np.asarray, frame=np.asarray, order=range(N)):  # fmt: skip
    """The base flight seen another way: maps of vectors and headings, of W and of the payload."""
    order = list(order)
    changes = dict(BASE)
    for key in ("start.payload_position", "goal.payload_position", "wind.mean"):
        changes[key] = vector(changes[key])
    for key in ("start.payload_yaw", "goal.payload_yaw"):
        changes[key] = yaw(changes[key])
    changes["plant.attachment"] = np.array([body(r) for r in changes["plant.attachment"]])[order]
    changes["vehicle.frame_angle"] = frame(changes["vehicle.frame_angle"])[order]
    for key in ("plant.vehicle_mass", "plant.cable_length"):
        changes[key] = changes[key][order]
    changes = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in changes.items()}
    changes["push"] = [
        {"body": vehicle(name, order), "start": 0.2, "duration": 0.3,
         "force": vector(force).tolist(), "torque": body_axial(torque).tolist()}
        for name, force, torque in PUSHES
    ]  # fmt: skip
    changes["event"] = [{"kind": "cable_cut", "time": 1.2, "vehicle": vehicle("vehicle_2", order)}]
    changes["controller"] = {"law": law, "rate": 100.0, **LAWS[law], **(gains or {})}
    return ml.simulate(plate(N, changes))


def vectors(of, name):
    return np.stack([of[f"{name}_{axis}"] for axis in "xyz"], axis=1)


def same_seen_otherwise(one, other, vector, order=range(N)):
    """Each body's place and thrust and each tension of one run is the other's, mapped."""

    def close(a, b):
        # Roundings of 1e-16 of some 10 N, which rate loops of some 10/s and a load that tumbles on
        # two cables grow in a second and a half.
        np.testing.assert_allclose(a, b, atol=1e-7)

    def mapped(rows):
        return np.array([vector(row) for row in rows])

    assert one.metrics["slack_time"] > 0.5  # the cut was one
    close(mapped(vectors(one, "payload")), vectors(other, "payload"))
    for k, i in enumerate(order):
        close(mapped(vectors(one, f"vehicle{i + 1}")), vectors(other, f"vehicle{k + 1}"))
        close(mapped(vectors(one, f"thrust{i + 1}")), vectors(other, f"thrust{k + 1}"))
        close(one[f"tension{i + 1}"], other[f"tension{k + 1}"])


@pytest.mark.parametrize("law", LAWS)
def test_numbering_of_quadrotors_does_not_matter(law):
    order = [2, 0, 1]
    same_seen_otherwise(run(law), run(law, order=order), np.asarray, order)


@pytest.mark.parametrize(
    ("law", "angle", "gains"),
    [
        *((law, 0.5 * math.pi, {}) for law in LAWS),
        # What laws do axis by axis sees the axes: estimates of drag, bounds of integrals.
        ("geometric", 0.7, {"k_integral": 0.0}),
        ("geometric", 2.1, {"k_integral": 0.0}),
    ],
)
def test_heading_of_the_world_does_not_matter_to_quadrotors(law, angle, gains):
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def vector(v):
        return turn @ np.asarray(v)

    turned = run(law, gains, vector=vector, yaw=lambda a: a + angle)
    same_seen_otherwise(run(law, gains), turned, vector)


@pytest.mark.parametrize("law", LAWS)
def test_a_mirrored_world_flies_the_mirrored_way(law):
    def vector(v):
        return np.asarray(v) * [1.0, -1.0, 1.0]

    mirrored = run(
        law, vector=vector, yaw=lambda a: -a, body=vector,
        body_axial=lambda v: np.asarray(v) * [-1.0, 1.0, -1.0],
        # Mirrored rotors turn the other way round: the first one of their sense is the fourth.
        frame=lambda a: 0.5 * math.pi - a,
    )  # fmt: skip
    same_seen_otherwise(run(law), mirrored, vector)


@pytest.mark.parametrize("cables", ["rigid", "elastic"])
@pytest.mark.parametrize("law", LAWS)
def test_the_audit_of_quadrotors_closes_with_the_fourth_power_of_the_step(cables, law):
    left = {}
    for step in (0.004, 0.002):
        scenario = plate(
            N,
            {
                "vehicle.type": "paper_craft", "plant.cables": cables,
                "plant.cable_stiffness": 500.0, "start.payload_yaw": 0.2,
                "goal.payload_position": [0.3, 0.1, 1.1], "wind.mean": [1.0, 0.5, 0.2],
                "link.delay": 0.02, "motion_capture.delay": 0.02, "autopilot.rate": 125.0,
                "controller": {"law": law, "rate": 25.0, **LAWS[law]},
                "simulation.step": step, "simulation.duration": 2.0,
                "simulation.record_period": 0.02,
                "push": [{"body": "payload", "start": 0.2, "duration": 0.2, "shape": "half_sine",
                          "force": [0.5, 0.2, 0.0], "torque": [0.02, 0.01, 0.02]}],
            },
        )  # fmt: skip
        result = ml.simulate(scenario)
        assert result.status == "finished"
        assert result.metrics["slack_time"] == 0.0
        left[step] = abs(result.audit["largest_integration_error"])
    assert left[0.002] < 1e-3
    # Of order 4, of which the next one shows at steps of a tenth of the rotors' lag.
    assert np.log2(left[0.004] / left[0.002]) == pytest.approx(4.0, abs=0.6)
