"""The figure of spatial runs shows what happened, of one run and of several."""

import multilift as ml
import numpy as np
import pytest
import replay_scenes as scenes

pytest.importorskip("matplotlib")


def labels(figure):
    return [ax.get_ylabel().replace("\n", " ") for ax in figure.axes]


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_one_run_has_a_line_for_every_vehicle_and_names_what_broke():
    run = scenes.cut()
    figure = run.plot()
    assert labels(figure)[:3] == ["payload x (m)", "payload y (m)", "payload z (m)"]
    assert "swing (deg)" in labels(figure)
    assert "payload's tilt (deg)" in labels(figure)
    assert {"target", "vehicle 1", "vehicle 4", "push"} <= set(legend(figure))
    swing = figure.axes[labels(figure).index("swing (deg)")]
    drawn = [line for line in swing.lines if len(line.get_xdata()) > 2]
    assert len(drawn) == 4
    assert np.isnan(drawn[1].get_ydata()[run.t >= 1.0]).all()  # its cable is cut
    texts = [text.get_text() for ax in figure.axes for text in ax.texts]
    assert texts == ["cable 2 cut", "vehicle 3 lost"]


def test_several_runs_are_told_apart_by_their_laws():
    scenario = ml.load("platform_turn").with_values(scenes.SHORT)
    figure = scenario.model.overview([ml.simulate(scenario, "pd"), ml.simulate(scenario)])
    assert {"PD", "energy-coupled", "all vehicles"} <= set(legend(figure))


def test_a_point_has_no_heading():
    point = {
        "plant.payload_inertia": 0.0, "plant.attachment": [0.0, 0.0, 0.0],
        "formation.tilt": "30 deg",
    }  # fmt: skip
    figure = scenes.run("platform_turn", **point, **{"simulation.duration": 0.5}).plot()
    assert not any("heading" in label for label in labels(figure))
