"""What an autopilot recorded, PX4's ULog, compared with our log.

An autopilot's clock begins when it boots. The recording is laid beside our log where its attitudes
fit our estimates best; what then differs is the estimates', and the delay of the set-points that
arrived is the link's. World north-east-down and body forward-right-down are turned into ours at
once.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilift.errors import MissingExtraError, OutputError
from multilift.flight.link import frames
from multilift.flight.replay.flown import Flown
from multilift.models.spatial.run import rotation_matrices

Array = NDArray[np.float64]

#: What both are brought to for finding where they fit, s, and to how much of it is searched finely.
_STEP = 0.02
_FINE = 1e-3

#: Attitudes that correlate less are not of the same flight.
_LEAST_FIT = 0.6

#: Shorter overlaps say nothing, s.
_LEAST_TIME = 2.0

#: Farther from a recorded value nothing is compared with it, s.
_GAP = 0.2


@dataclass(frozen=True)
class Track:
    """Values over time.

    Attributes:
        t: ascending, shape (rows,), s.
        value: shape (rows, k).
    """

    t: Array
    value: Array

    def at(self, t: Array) -> Array:
        """Linearly between the values; NaN where none is near, shape (len(t), k)."""
        found = np.column_stack([np.interp(t, self.t, column) for column in self.value.T])
        after = np.clip(np.searchsorted(self.t, t), 0, len(self.t) - 1)
        before = np.maximum(after - 1, 0)
        apart = np.minimum(np.abs(self.t[after] - t), np.abs(t - self.t[before]))
        outside = (t < self.t[0]) | (t > self.t[-1])
        found[(apart > _GAP) | outside] = np.nan
        return found


@dataclass(frozen=True)
class Recorded:
    """What an autopilot recorded, in our axes and its own time.

    Attributes:
        attitude: unit quaternions, scalar first.
        wanted: attitudes that it was told to take, and normalised thrusts; None if none are there.
        position: of its own estimate, m; None if none is there.
    """

    attitude: Track
    wanted: Track | None
    position: Track | None


@dataclass(frozen=True)
class Compared:
    """A recording beside our log.

    Attributes:
        offset: our time less the autopilot's, s.
        numbers: what is said of both, by name; NaN where the recording lacks it.
        curves: columns of both over our time, by name.
    """

    offset: float
    numbers: Mapping[str, float]
    curves: Mapping[str, Array]

    def to_csv(self, file: Path) -> None:
        """Writes the curves, a column each."""
        table = np.column_stack(list(self.curves.values()))
        np.savetxt(file, table, "%.9g", ",", header=",".join(self.curves), comments="")


def read(path: Path) -> Recorded:
    """The recording that a ULog file holds, as far as it is whole.

    Raises:
        OutputError: if it cannot be read, or has no attitudes.
        MissingExtraError: without pyulog (``multilift[fly]``).
    """
    try:
        from pyulog import ULog  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError("pyulog", "fly", "reading a ULog file") from None
    names = ["vehicle_attitude", "vehicle_attitude_setpoint", "vehicle_local_position"]
    try:
        # pyulog prints what it finds wrong.
        with path.open("rb") as file, contextlib.redirect_stdout(io.StringIO()):
            whole = ULog(file, message_name_filter_list=names, disable_str_exceptions=True)
        data = {d.name: d.data for d in whole.data_list if d.multi_id == 0}
        attitude = _track(data, names[0], [f"q[{k}]" for k in range(4)])
        wanted = _track(data, names[1], [*(f"q_d[{k}]" for k in range(4)), "thrust_body[2]"])
        position = _track(data, names[2], ["x", "y", "z"])
    except Exception as error:  # pyulog raises whatever damage leads it to
        raise OutputError(
            f"{path} cannot be read as ULog: {error}\n"
            "  what to do: give the .ulg file that the autopilot wrote"
        ) from None
    if attitude is None:
        raise OutputError(
            f"{path} has no attitudes\n  permitted: a ULog with the topic vehicle_attitude"
        )
    return Recorded(
        Track(attitude.t, _attitudes(attitude.value)),
        None if wanted is None else Track(wanted.t, _set_points(wanted.value)),
        None if position is None else Track(position.t, position.value[:, [1, 0, 2]] * [1, 1, -1]),
    )


def compare(flown: Flown, k: int, recorded: Recorded, where: str) -> Compared:
    """Lays a recording beside our log.

    Args:
        flown: our log.
        k: the vehicle, from 0.
        recorded: its autopilot's recording.
        where: the recording's file, for errors.

    Raises:
        OutputError: if the two are not of the same flight, or one is too short to tell.
    """
    ours = Track(flown.t, flown.bodies[:, 1 + k, 3:7])
    offset, fit = _offset(_lean(ours), _lean(recorded.attitude), where)
    if fit < _LEAST_FIT:
        raise OutputError(
            f"{where} does not fit vehicle {k + 1} of {flown.path}: its attitudes correlate by "
            f"{fit:.2f}\n  permitted: {_LEAST_FIT} or more\n"
            "  what to do: give the recording of this vehicle and flight"
        )
    t = flown.t
    theirs = _shifted(recorded.attitude, offset)
    curves = {"t": t}
    numbers = {"offset": offset, "correlation": fit}
    numbers["attitude_rms"] = _rms(_angle(ours.value, theirs.at(t)))
    _add(curves, "lean", _lean(ours).value, _lean(theirs).at(t), "xy")
    wanted = _wanted(flown, k)
    numbers |= {"set_point_rms": np.nan, "set_point_delay": np.nan, "set_points_arrived": np.nan}
    if recorded.wanted is not None and wanted is not None:
        told = _shifted(recorded.wanted, offset)
        delay, _fit = _offset(_lean(told), _lean(wanted), where, around=0.0)
        numbers["set_point_delay"] = delay
        sent = _shifted(wanted, delay)
        there = sent.at(told.t)
        numbers["set_point_rms"] = _rms(_angle(told.value[:, :4], there))
        inside = int(np.count_nonzero((told.t >= sent.t[0]) & (told.t <= sent.t[-1])))
        numbers["set_points_arrived"] = inside / len(wanted.t)
        _add(curves, "wanted", _lean(wanted).at(t), _lean(told).at(t), "xy")
    numbers |= {"position_rms": np.nan, "position_offset": np.nan}
    if recorded.position is not None:
        there = _shifted(recorded.position, offset).at(t)
        apart = there - flown.bodies[:, 1 + k, :3]
        known = np.isfinite(apart).all(axis=1)
        if known.any():
            mean = apart[known].mean(axis=0)
            numbers["position_offset"] = float(np.linalg.norm(mean))
            numbers["position_rms"] = _rms(np.linalg.norm(apart[known] - mean, axis=1))
        _add(curves, "position", flown.bodies[:, 1 + k, :3], there, "xyz")
    return Compared(offset, numbers, curves)


#: What the numbers of a comparison mean: unit and words.
MEANINGS: Mapping[str, tuple[str, str]] = {
    "offset": ("s", "our time less the autopilot's, found by laying attitude on attitude"),
    "correlation": ("", "of the attitudes there"),
    "attitude_rms": ("deg", "between its attitude and motion capture's"),
    "set_point_rms": ("deg", "between the attitudes sent and those that arrived"),
    "set_point_delay": ("s", "from sending a set-point to its record"),
    "set_points_arrived": ("", "recorded per sent; autopilots record fewer than they take"),
    "position_rms": ("m", "between its position and ours, less their mean difference"),
    "position_offset": ("m", "that mean: another origin, or another point of the body"),
}


def _track(data: Mapping[str, Any], name: str, columns: list[str]) -> Track | None:
    """Some columns of a topic where they are numbers, in order of time; None if none are."""
    topic = data.get(name)
    if topic is None or not all(column in topic for column in columns):
        return None
    t = np.asarray(topic["timestamp"], dtype=float) * 1e-6
    value = np.column_stack([np.asarray(topic[column], dtype=float) for column in columns])
    later = np.diff(np.maximum.accumulate(t), prepend=-np.inf) > 0.0
    good = np.isfinite(value).all(axis=1) & later
    return Track(t[good], value[good]) if good.sum() > 1 else None


def _attitudes(q: Array) -> Array:
    """From FRD in NED to FLU in ENU."""
    return np.array([frames.attitude(row) for row in (q / _lengths(q)).tolist()])


def _set_points(value: Array) -> Array:
    """Attitudes in our axes, and thrusts upward."""
    return np.column_stack([_attitudes(value[:, :4]), -value[:, 4]])


def _lengths(q: Array) -> Array:
    return np.asarray(np.maximum(np.linalg.norm(q, axis=1), 1e-9)[:, None])


def _wanted(flown: Flown, k: int) -> Track | None:
    sent = np.isfinite(flown.wanted[:, k]).all(axis=1)
    return Track(flown.t[sent], flown.wanted[sent, k]) if sent.sum() > 1 else None


def _shifted(track: Track, by: float) -> Track:
    return Track(track.t + by, track.value)


def _lean(track: Track) -> Track:
    """Where the thrust axis points sideways, which no origin and no heading changes much."""
    return Track(track.t, rotation_matrices(track.value[:, :4])[:, :2, 2])


def _angle(a: Array, b: Array) -> Array:
    """Between attitudes, deg; NaN where one is."""
    a, b = a[:, :4] / _lengths(a[:, :4]), b[:, :4] / _lengths(b[:, :4])
    chord = np.minimum(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return np.asarray(np.degrees(4.0 * np.arcsin(chord / 2.0)))


def _rms(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")


def _add(curves: dict[str, Array], name: str, ours: Array, theirs: Array, axes: str) -> None:
    for k, axis in enumerate(axes):
        curves[f"{name}_{axis}"] = ours[:, k]
        curves[f"{name}_{axis}_recorded"] = theirs[:, k]


def _offset(
    ours: Track, theirs: Track, where: str, around: float | None = None
) -> tuple[float, float]:
    """By how much to move theirs so that it fits ours, s, and how well it then does, at most 1.

    Args:
        ours: stays.
        theirs: moves.
        where: the recording's file, for errors.
        around: near this value, if given; anywhere otherwise.
    """
    if around is None:
        around = _coarse(ours, theirs, where)
    best, fit = around, -1.0
    for width, step in ((25 * _STEP, _STEP / 2), (_STEP, _FINE)):
        shifts = best + np.arange(-width, width + step / 2, step)
        fits = [_fit(ours, _shifted(theirs, shift)) for shift in shifts]
        k = int(np.argmax(fits))
        best, fit = float(shifts[k]), float(fits[k])
    return best, fit


def _coarse(ours: Track, theirs: Track, where: str) -> float:
    """The same to a step, from the correlation at all shifts at once."""
    a, b = _even(ours), _even(theirs)
    least = round(_LEAST_TIME / _STEP)
    if min(len(a), len(b)) < least:
        raise OutputError(f"{where} or our log is too short to compare: less than {_LEAST_TIME} s")
    size = len(a) + len(b)
    spectrum = np.fft.rfft(a, size, axis=0) * np.conj(np.fft.rfft(b, size, axis=0))
    products = np.fft.irfft(spectrum.sum(axis=1), size)
    shift = int(np.argmax(products))
    shift -= size if shift >= len(a) else 0
    return float(ours.t[0] - theirs.t[0] + shift * _STEP)


def _even(track: Track) -> Array:
    """At equal steps, without its mean."""
    t = np.arange(track.t[0], track.t[-1], _STEP)
    value = np.nan_to_num(track.at(t))
    return np.asarray(value - value.mean(axis=0))


def _fit(ours: Track, theirs: Track) -> float:
    """Correlation where both are."""
    a, b = ours.value, theirs.at(ours.t)
    known = np.isfinite(b).all(axis=1)
    if np.count_nonzero(known) < 10:
        return -1.0
    a, b = a[known] - a[known].mean(axis=0), b[known] - b[known].mean(axis=0)
    size = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / size if size > 0.0 else -1.0
