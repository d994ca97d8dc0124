"""Curves of the last half minute, with the limits that end a flight."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import viser
from viser import uplot

from multilift.flight.web.history import SPAN, Array, History
from multilift.replay.colours import vehicle_colour

_LOAD, _LIMIT, _TEXT, _GRID = "#e8e8e8", "#ff5c5c", "#c8ccd2", "#3a3f47"
_HEIGHT = 170


@dataclass(frozen=True)
class Curves:
    """One plot's content.

    Attributes:
        values: of each curve, NaN where unknown, shape (rows,).
        limit: drawn as a line; None for none.
        least: that its axis reaches at least.
    """

    values: Sequence[Array]
    limit: float | None
    least: float


def curves(kept: History) -> dict[str, Curves]:
    """All plots, by their titles, which say the units."""
    swing, mocap = kept.limit("swing"), kept.limit("mocap_age")
    return {
        "swing of the cables, °": Curves(
            [np.degrees(x) for x in kept.of_vehicles(lambda v: v.swing)],
            None if swing is None else math.degrees(swing), 5.0,
        ),
        "off their places, cm": Curves(
            [100.0 * x for x in (*kept.of_vehicles(lambda v: v.error),
                                 kept.of(lambda s: s.payload.error))], None, 5.0,
        ),
        "tension of the cables, N": Curves(kept.of_vehicles(lambda v: v.tension), None, 1.0),
        "age of motion capture, ms": Curves(
            [1e3 * kept.of(lambda s: s.capture.age)],
            None if mocap is None else 1e3 * mocap, 20.0,
        ),
        "age of the links, s": Curves(
            kept.of_vehicles(lambda v: v.link_age), kept.limit("link_age"), 0.5,
        ),
    }  # fmt: skip


def top(found: Curves) -> float:
    """Where a plot's axis ends: at a round number above all curves and the limit, where near.

    A limit that is more than four times what there is would only flatten the curves.
    """
    known = np.concatenate([x[np.isfinite(x)] for x in found.values] or [np.zeros(0)])
    most = max(float(known.max()) if known.size else 0.0, found.least)
    if found.limit is not None and found.limit <= 4.0 * most:
        most = max(most, 1.1 * found.limit)
    size = 10.0 ** math.floor(math.log10(most))
    return next(size * m for m in (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.5, 10.0) if size * m >= most)


class Plots:
    """Plots in a panel."""

    def __init__(self, gui: viser.GuiApi, count: int) -> None:
        """Lays them out.

        Args:
            gui: in whose present container.
            count: of vehicles.
        """
        self._tops: dict[str, float] = {}
        self._plots: dict[str, viser.GuiUplotHandle] = {}
        vehicles = [(f"{k + 1}", vehicle_colour(k)) for k in range(count)]
        for title, found in curves(History()).items():
            named = vehicles
            if title.startswith("off"):
                named = [*vehicles, ("load", _LOAD)]
            elif title.startswith("age of motion"):
                named = [("oldest body", _LOAD)]
            series: list[uplot.Series] = [{"label": "s"}]
            series += [{"label": name, "stroke": colour, "width": 2} for name, colour in named]
            if found.limit is not None or title.startswith(("swing", "age")):
                series.append({"label": "limit", "stroke": _LIMIT, "width": 1, "dash": (6, 4)})
            axis: uplot.Axis = {"stroke": _TEXT, "grid": {"stroke": _GRID, "width": 1},
                                "ticks": {"stroke": _GRID, "width": 1}}  # fmt: skip
            self._plots[title] = gui.add_uplot(
                tuple(np.zeros(0) for _ in series), tuple(series), title=title, height=_HEIGHT,
                axes=(axis, axis), scales=_scales(found.least), padding=(12, 24, 0, 0),
                legend={"show": True, "live": False},
            )  # fmt: skip

    def draw(self, kept: History) -> None:
        """Draws what has been kept."""
        ago = kept.ago
        for title, found in curves(kept).items():
            plot = self._plots[title]
            limit = [] if found.limit is None else [np.full(len(ago), found.limit)]
            plot.data = (ago, *found.values, *limit)
            # viser makes a plot anew with each change of its scales: only when it must be.
            if self._tops.get(title) != (end := top(found)):
                self._tops[title] = end
                plot.scales = _scales(end)


def _scales(end: float) -> dict[str, uplot.Scale]:
    return {
        "x": {"time": False, "range": (-SPAN, 0.0)},
        "y": {"range": (0.0, end)},
    }
