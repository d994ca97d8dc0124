"""Scenes say what runs say: shapes, cables, colours, events; saved runs come back as they were."""

import multilift as ml
import numpy as np
import pytest
import replay_scenes as scenes
from multilift import models, replay, saved
from multilift.errors import OutputError, ScenarioError
from multilift.pushes import heights
from multilift.replay import cables, colours
from multilift.replay.camera import Camera
from multilift.replay.scene import convex_outline, payload_body
from row_model import Row, raw


@pytest.mark.parametrize(
    ("attachments", "inertia", "kind"),
    [
        (np.zeros((3, 3)), np.zeros(3), "point"),
        ([[-0.75, 0, 0.01], [0.75, 0, 0.01]], [2e-5, 0.07, 0.07], "bar"),
        ([[1, 0, 0.1], [0, 1, 0.1], [-1, -1, 0.1], [0.1, 0.1, 0.1]], [0.1, 0.1, 0.15], "plate"),
        ([[0, 0, 0.2]], [0.1, 0.1, 0.15], "plate"),  # a block: one cable says nothing of its shape
    ],
)
def test_payload_shape_follows_attachments_and_inertia(attachments, inertia, kind):
    body = payload_body(1.0, np.array(inertia, dtype=float), np.array(attachments, dtype=float))
    assert body.kind == kind
    assert body.radius > 0
    if kind == "bar":  # through the centre of mass, attachments on its surface
        np.testing.assert_allclose(np.sort(body.points[:, 0]), [-0.75, 0.75])
        np.testing.assert_allclose(body.points[:, 1:], 0.0, atol=1e-15)
        assert body.radius == pytest.approx(0.01)
    if kind == "plate":
        assert len(body.points) in (3, 4)


def test_outline_is_the_hull_counterclockwise():
    points = np.array([[0, 0], [2, 0], [2, 1], [0, 1], [1, 0.5], [1, 0], [0, 0]], dtype=float)
    hull = convex_outline(points)
    assert {tuple(p) for p in hull} == {(0, 0), (2, 0), (2, 1), (0, 1)}
    x, y = hull.T
    area = 0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert area == pytest.approx(2.0)


@pytest.mark.parametrize("apart", [(1.0, 0.5, 0.2), (0.3, 0.0, 0.9), (0.0, 0.0, 0.7), (0, 0, 0)])
@pytest.mark.parametrize("excess", [1.0001, 1.05, 1.5, 4.0])
def test_slack_cable_has_its_length_and_hangs_between_its_ends(apart, excess):
    foot, top = np.array([1.0, -2.0, 0.5]), np.array([1.0, -2.0, 0.5]) + apart
    length = excess * max(float(np.linalg.norm(apart)), 0.5)
    line = cables.sagging(foot, top, length, 400)
    np.testing.assert_allclose(line[[0, -1]], [foot, top], atol=1e-9)
    arc = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    # Chords are shorter than the arc; ends above each other are drawn a hair's breadth apart.
    assert arc == pytest.approx(length, rel=3e-3)
    assert (line[:, 2] <= max(foot[2], top[2]) + 1e-9).all()
    assert line[:, 2].min() < min(foot[2], top[2]) + 1e-9 or excess < 1.1


def test_taut_cable_is_straight_and_a_cut_one_hangs():
    foot, top = np.zeros(3), np.array([0.3, 0.4, 1.2])
    line = cables.sagging(foot, top, 1.3)
    assert np.linalg.norm(np.cross(line, top), axis=1).max() < 1e-12
    for floor in (None, 0.0, 0.9):
        line = cables.hanging(top, 0.8, floor)
        assert np.linalg.norm(np.diff(line, axis=0), axis=1).sum() == pytest.approx(0.8)
        assert line[:, 2].min() >= (floor if floor is not None else 0.4) - 1e-12


def lightness(colour):
    """CIE L* of sRGB parts, 0 to 255."""
    part = np.asarray(colour) / 255.0
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    return 116.0 * np.cbrt(linear @ [0.2126, 0.7152, 0.0722]) - 16.0


def test_tension_colours_rise_in_lightness_and_stay_in_range():
    shown = colours.tension_colours(np.linspace(2.0, 5.0, 200), 2.0, 5.0)
    rise = lightness(shown)
    assert (np.diff(rise) > -0.3).all()  # parts are whole numbers
    assert (np.diff(rise[::20]) > 1.0).all()
    assert rise[0] > 30  # seen on black
    assert rise[-1] < 80  # and on white
    low, high = colours.tension_colours(np.array([-1.0, 9.0]), 2.0, 5.0)
    assert tuple(low) == tuple(shown[0])
    assert tuple(high) == tuple(shown[-1])
    assert len(set(colours.ramp())) == len(colours.ramp())


def test_scene_of_a_flight_with_failures():
    run = scenes.cut()
    scene = replay.scene_of(run)
    assert scene.payload.kind == "plate"
    assert [e.text for e in scene.events] == [
        "push of 2 N on payload", "cable 2 cut", "vehicle 3 lost",
    ]  # fmt: skip
    assert scene.cables[1].cut == 1.0
    assert scene.vehicles[2].lost == 2.0
    after = scene.t >= 1.0
    assert scene.slack(1)[after].all()
    assert not scene.slack(1)[~after].any()
    assert np.isnan(scene.cables[1].swing[after]).all()
    for k, (cable, vehicle) in enumerate(zip(scene.cables, scene.vehicles, strict=True)):
        np.testing.assert_array_equal(vehicle.position, run.vector(f"vehicle{k + 1}"))
        apart = np.linalg.norm(vehicle.position - cable.foot, axis=1)
        assert (apart[scene.t < cable.cut] < cable.length * 1.01).all()
        np.testing.assert_allclose(np.linalg.norm(vehicle.rotors, axis=1), 0.225)
    push = scene.pushes[0]
    assert push.force[:, 0].max() == pytest.approx(2.0)
    assert (push.force[(scene.t < 0.5) | (scene.t > 0.9)] == 0).all()
    low, high = scene.usual_tension
    assert 0 <= low < high
    assert scene.floor is None


def test_ideal_vehicles_are_balls_and_floors_are_floors():
    scene = scenes.scene(
        "takeoff_to_setdown", **{"vehicle.kind": "ideal", "simulation.duration": 0.5}
    )
    assert all(v.attitude is None and len(v.rotors) == 0 for v in scene.vehicles)
    assert scene.floor == scene.resting_height() == 0.0


def test_planar_run_lies_in_a_plane():
    scene = scenes.scene("sim1")
    assert scene.payload.kind == "bar"
    for cable, vehicle in zip(scene.cables, scene.vehicles, strict=True):
        apart = np.linalg.norm(vehicle.position - cable.foot, axis=1)
        np.testing.assert_allclose(apart, cable.length, rtol=1e-9)
        assert (vehicle.position[:, 0] == 0).all()
    ends = np.stack([c.foot for c in scene.cables], axis=1)
    np.testing.assert_allclose(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), 1.8, rtol=1e-6)


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ({"shape": "pulse"}, [0, 1, 1, 0]),
        ({"shape": "half_sine"}, [0, 0, 1, 0]),
        ({"shape": "sine", "frequency": 0.25}, [0, 0, 1, 0]),
        ({"shape": "samples", "sample_times": [0, 2], "sample_values": [1, 3]}, [0, 1, 2, 0]),
    ],
)
def test_push_profiles(shape, expected):
    push = {"start": 1.0, "duration": 2.0, **shape}
    np.testing.assert_allclose(heights(push, np.array([0.0, 1.0, 2.0, 3.0])), expected, atol=1e-15)


def test_camera_sees_all_of_its_box():
    box = np.array([[-1.0, 2.0, 0.0], [4.0, 3.0, 2.5]])
    corners = np.array(np.meshgrid(*box.T)).reshape(3, -1).T
    for yaw, pitch in ((0.0, 0.0), (-1.05, 0.32), (2.0, 1.2)):
        seen = Camera(box, yaw, pitch, 400, 300).project(corners)
        assert (seen[:, :2] >= 0).all()
        assert (seen[:, :2] <= [400, 300]).all()
        assert (seen[:, 2] > 0.1).all()


@pytest.mark.parametrize("name", ["platform_turn", "sim1"])
def test_saved_runs_come_back_as_they_were(name, tmp_path):
    pytest.importorskip("pyarrow")
    run = scenes.run(name)
    back = saved.read(run.save(tmp_path / "run"))
    assert type(back) is type(run)
    assert back.columns == run.columns
    for column in run.columns:
        np.testing.assert_array_equal(back[column], run[column])
    assert back.summary() == run.summary()
    assert back.controller_title == run.controller_title
    assert back.scenario.values == run.scenario.values
    assert replay.scene_of(back).payload.kind == replay.scene_of(run).payload.kind


def test_a_damaged_run_is_named(tmp_path):
    pytest.importorskip("pyarrow")
    folder = scenes.run("platform_turn").save(tmp_path / "run")
    (folder / "trajectory.parquet").write_bytes(b"nothing")
    with pytest.raises(OutputError, match="run holds no run of multilift"):
        saved.read(folder)


def test_models_without_a_shape_say_so(monkeypatch):
    monkeypatch.setattr(models, "_FOUND", dict(models._FOUND))
    models.register(Row())
    run = ml.simulate(ml.Scenario(raw()))
    with pytest.raises(ScenarioError, match="no shape"):
        replay.scene_of(run)
