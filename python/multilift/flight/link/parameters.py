"""An autopilot's parameters: read, compared with what a flight needs, set and read again."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field

from pymavlink.dialects.v20 import common as mavlink

from multilift.flight.link.firmware import Firmware, Setting

#: How long an answer may take, s, and how often each is asked in all.
_PATIENCE = 0.5
_TRIES = 6

#: How many are under way at once.
_AT_ONCE = 4

#: Values travel as float32.
_ROUND_OFF = 1e-6

_WHOLE_FORMATS = {
    mavlink.MAV_PARAM_TYPE_UINT8: "<B3x",
    mavlink.MAV_PARAM_TYPE_INT8: "<b3x",
    mavlink.MAV_PARAM_TYPE_UINT16: "<H2x",
    mavlink.MAV_PARAM_TYPE_INT16: "<h2x",
    mavlink.MAV_PARAM_TYPE_UINT32: "<I",
    mavlink.MAV_PARAM_TYPE_INT32: "<i",
}


def to_wire(value: float, kind: int, bytewise: bool) -> float:
    """The float that carries a value of a parameter type."""
    form = _WHOLE_FORMATS.get(kind)
    if form is None or not bytewise:
        return value
    return float(struct.unpack("<f", struct.pack(form, int(value)))[0])


def from_wire(carried: float, kind: int, bytewise: bool) -> float:
    """The value that a float carries."""
    form = _WHOLE_FORMATS.get(kind)
    if form is None or not bytewise:
        return carried
    return float(struct.unpack(form, struct.pack("<f", carried))[0])


@dataclass
class _Item:
    """One parameter on its way to what it must be."""

    setting: Setting
    value: float | None = None
    kind: int = mavlink.MAV_PARAM_TYPE_REAL32
    tries: int = 0
    due: float = 0.0
    given_up: bool = False

    @property
    def fits(self) -> bool:
        wanted = self.setting.value
        return self.value is not None and abs(self.value - wanted) <= _ROUND_OFF * max(
            1.0, abs(wanted)
        )


@dataclass(frozen=True)
class Request:
    """What to send: a value to set, or None to read; `carried` is the float on the wire."""

    name: str
    carried: float | None
    kind: int


@dataclass
class Parameters:
    """The parameters of one vehicle that a flight depends on.

    Attributes:
        firmware: whose.
        may_set: whether wrong ones are set, or only told.
    """

    firmware: Firmware
    may_set: bool
    _items: dict[str, _Item] = field(default_factory=dict)

    def require(self, settings: tuple[Setting, ...], now: float) -> None:
        """Begins to check settings, from reading on."""
        self._items = {s.name: _Item(s, due=now) for s in settings}

    def due(self, now: float) -> Iterator[Request]:
        """What to send now; at most a few are under way at once."""
        open_items = [i for i in self._items.values() if not self._is_done(i)]
        for item in open_items[:_AT_ONCE]:
            if now < item.due:
                continue
            if item.tries >= _TRIES:
                item.given_up = True
                continue
            item.tries += 1
            item.due = now + _PATIENCE
            if item.value is None:
                yield Request(item.setting.name, None, item.kind)
            else:
                carried = to_wire(item.setting.value, item.kind, self.firmware.bytewise)
                yield Request(item.setting.name, carried, item.kind)

    def sees(self, name: str, carried: float, kind: int, now: float) -> None:
        """Takes in PARAM_VALUE."""
        item = self._items.get(name)
        if item is None or (kind not in _WHOLE_FORMATS and kind != mavlink.MAV_PARAM_TYPE_REAL32):
            return
        first = item.value is None
        item.value, item.kind = from_wire(carried, kind, self.firmware.bytewise), kind
        if first:
            item.tries, item.due = 0, now

    def _is_done(self, item: _Item) -> bool:
        return item.fits or item.given_up or (item.value is not None and not self.may_set)

    @property
    def is_done(self) -> bool:
        """Whether every one is right or given up."""
        return bool(self._items) and all(map(self._is_done, self._items.values()))

    @property
    def problems(self) -> list[str]:
        """What is wrong or not known yet, in words; empty when all is as it must be."""
        lines = []
        for item in self._items.values():
            wanted = item.setting
            if not item.fits:
                has = "does not answer" if item.value is None else f"is {item.value:g}"
                lines.append(f"{wanted.name} {has}, must be {wanted.value:g}: {wanted.reason}")
        return lines if self._items else ["parameters were not read"]
