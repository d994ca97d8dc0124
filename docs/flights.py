"""Draws docs/_static/flights: a figure and an animation of each flight on the page ``flights``."""

import io
from pathlib import Path

import multilift as ml
from multilift import replay
from multilift.replay import gif
from PIL import Image

FOLDER = Path(__file__).with_name("_static") / "flights"
PAPER = ("exp1_1_quadrotors", "exp1_2_quadrotors", "exp2_quadrotors")
FLIGHTS = (
    *PAPER,
    "platform_turn",
    "uneven_four",
    "figure_eight_six",
    "takeoff_to_setdown",
    "cable_cut",
    "vehicle_lost",
)
MOST_BYTES = 400_000  # of an animation


def save(figure, file):
    """Writes a figure as a PNG of few colours, a third as large."""
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=100)
    image = Image.open(drawn).convert("RGB")
    image.quantize(128, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(
        file, optimize=True
    )


def main():
    """Flies, draws and saves all of them; the paper's tests under PD too, for their figures."""
    FOLDER.mkdir(exist_ok=True)
    for name in FLIGHTS:
        scenario = ml.load(name)
        run = ml.simulate(scenario)
        runs = [ml.simulate(scenario, "pd"), run] if name in PAPER else [run]
        save(scenario.model.overview(runs), FOLDER / f"{name}.png")
        gif.write(replay.scene_of(run), FOLDER / f"{name}.gif", most_bytes=MOST_BYTES)


if __name__ == "__main__":
    main()
