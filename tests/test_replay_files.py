"""Recordings and animations: written, small, with everything in them."""

import dataclasses

import numpy as np
import pytest
import replay_scenes as scenes
from multilift import replay
from multilift.errors import MissingExtraError, OutputError
from multilift.replay import gif, recording
from multilift.replay.painting import Painter


@pytest.mark.parametrize("make", [scenes.cut, lambda: scenes.run("sim1")], ids=["space", "plane"])
def test_animation_is_small_and_moves(make, tmp_path):
    images = pytest.importorskip("PIL.Image")
    file = tmp_path / "run.gif"
    gif.write(replay.scene_of(make()), file)
    assert file.stat().st_size < 1_500_000
    with images.open(file) as image:
        assert image.n_frames == 45  # 3 s at 15 a second
        assert image.info["loop"] == 0
        first = np.asarray(image.convert("RGB")).astype(int)
        image.seek(image.n_frames - 1)
        last = np.asarray(image.convert("RGB")).astype(int)
    assert (np.abs(first - last).max(axis=2) > 60).sum() > 500
    blue = [31, 131, 201]
    assert (np.abs(last - blue).max(axis=2) < 4).sum() > 5


def test_animation_has_fewer_frames_where_it_would_be_too_large(tmp_path):
    images = pytest.importorskip("PIL.Image")
    file = tmp_path / "run.gif"
    gif.write(scenes.scene("platform_turn"), file, seconds=2.0, most_bytes=1)
    with images.open(file) as image:
        assert image.n_frames == 16  # 2 s at 8 a second, the least


def test_a_target_below_the_floor_does_not_move_the_camera_away():
    shown = scenes.scene("takeoff_to_setdown", **{"simulation.duration": 0.5})
    deep = dataclasses.replace(shown, payload_target=shown.payload_target - [0.0, 0.0, 3.0])
    assert deep.box[0, 2] < -2.0
    assert Painter(deep, 1.0).camera.eye == pytest.approx(Painter(shown, 1.0).camera.eye)


def test_an_animation_is_white_between_its_lines(tmp_path):
    images = pytest.importorskip("PIL.Image")
    gif.write(scenes.scene("exp1_1_quadrotors"), tmp_path / "run.gif")
    with images.open(tmp_path / "run.gif") as animation:
        assert animation.convert("RGB").getpixel((2, 60)) == (255, 255, 255)


def test_animation_says_where_it_cannot_be_written(tmp_path):
    pytest.importorskip("PIL.Image")
    with pytest.raises(OutputError, match="cannot be written"):
        gif.write(scenes.scene("platform_turn"), tmp_path / "no" / "run.gif", seconds=0.2)


def test_recording_holds_the_scene(tmp_path):
    pytest.importorskip("rerun")
    file = tmp_path / "run.rrd"
    recording.write(replay.scene_of(scenes.cut()), file)
    data = file.read_bytes()
    assert data[:3] == b"RRF"
    assert len(data) > 50_000
    for path in ("world/cable4", "world/thrust1", "world/paths/vehicle2", "curves/swing/3"):
        assert path.encode() in data


def test_recording_says_where_it_cannot_be_written(tmp_path):
    pytest.importorskip("rerun")
    with pytest.raises(OutputError, match="cannot be written"):
        recording.write(scenes.scene("platform_turn"), tmp_path / "no" / "run.rrd")


def test_without_rerun_one_message_names_the_extra(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "rerun", None)
    with pytest.raises(MissingExtraError, match=r"multilift\[view\]"):
        recording.need_rerun()
