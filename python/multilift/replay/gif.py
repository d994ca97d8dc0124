"""A run as a short animation: a picture in space over the swing of its cables."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from multilift.errors import MissingExtraError, OutputError
from multilift.replay.colours import rgb
from multilift.replay.painting import PLAIN, Painter
from multilift.replay.scene import Scene

if TYPE_CHECKING:
    from PIL.Image import Image

_RATES = (15, 12, 10, 8)  # frames a second, the first that keeps the file small


def write(scene: Scene, file: Path, *, seconds: float = 8.0, most_bytes: int = 1_500_000) -> None:
    """Writes the animation.

    Args:
        scene: what to show.
        file: to write.
        seconds: that the animation lasts at most; a longer run is shown faster, and says so.
        most_bytes: size to keep below, by fewer frames.

    Raises:
        MissingExtraError: without Pillow (``multilift[plot]``).
        OutputError: if the file cannot be written.
    """
    try:
        import PIL  # noqa: F401, PLC0415
    except ImportError:
        raise MissingExtraError("pillow", "plot", "an animation") from None
    data = b""
    for rate in _RATES:
        data = _encoded(list(frames(scene, rate, seconds)), rate)
        if len(data) <= most_bytes:
            break
    try:
        file.write_bytes(data)
    except OSError as error:
        raise OutputError(f"{file} cannot be written: {error.strerror}") from error


def frames(scene: Scene, rate: int, seconds: float) -> Iterator[Image]:
    """The pictures of the animation."""
    lasts = float(scene.t[-1] - scene.t[0])
    count = max(2, round(min(lasts, seconds) * rate))
    painter = Painter(scene, max(lasts / seconds, 1.0))
    for time in np.linspace(scene.t[0], scene.t[-1], count):
        yield painter.draw(int(np.searchsorted(scene.t, time + 1e-9, side="right")) - 1)


def _encoded(pictures: Sequence[Image], rate: int) -> bytes:
    """All pictures in the same few colours, so that still parts cost nothing."""
    from PIL import Image as Images  # noqa: PLC0415

    palette = Images.new("P", (1, 1))
    palette.putpalette(_palette())
    few = [p.quantize(palette=palette, dither=Images.Dither.NONE) for p in pictures]
    file = io.BytesIO()
    times = [round(1000 / rate / 10) * 10] * len(few)
    times[-1] = 1500
    few[0].save(file, "GIF", save_all=True, append_images=few[1:], duration=times, loop=0)
    return file.getvalue()


def _palette() -> list[int]:
    """The plain colours and their mixtures with white, and greys: at most 256, red, green, blue."""
    white = np.array([255.0, 255.0, 255.0])
    plain = np.array([rgb(colour) for colour in PLAIN], dtype=float)
    mixed = [white + part * (plain - white) for part in (1.0, 0.78, 0.56, 0.34, 0.15)]
    greys = np.linspace(0.0, 255.0, 24)[:, None] * np.ones(3)
    every = np.rint(np.concatenate([greys, *mixed]))
    # What is nearly white would take white's place: colours are matched coarsely.
    every = every[((every == 255).all(axis=1)) | (every.min(axis=1) < 240)][:256]
    return [int(x) for x in every.ravel()]
