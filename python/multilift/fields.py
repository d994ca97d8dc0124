"""One key of a scenario: its shape, unit, range, default and meaning, and the values it takes."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from multilift.errors import ScenarioError

#: Units that a value may be given in as a string such as "20 deg", per unit of the schema.
UNIT_SCALES: dict[str, dict[str, float]] = {
    "kg": {"g": 1e-3},
    "m": {"cm": 1e-2, "mm": 1e-3},
    "m/s": {"cm/s": 1e-2, "mm/s": 1e-3},
    "s": {"ms": 1e-3},
    "rad": {"deg": math.pi / 180},
    "rad/s": {"deg/s": math.pi / 180},
    "Hz": {"kHz": 1e3},
    "N": {"mN": 1e-3},
}

_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)\s*")


@dataclass(frozen=True)
class Field:
    """One key of a scenario.

    Attributes:
        name: key within its table.
        kind: "number", "whole", "list" (of numbers, any length), "text" or "flag".
        shape: of a number's array, () for a scalar. A value of fewer dimensions is repeated. A
            text, such as "n", stands for a size that `resolved` puts in.
        unit: of a number, "" where it has none.
        range: "any", "positive" or "non_negative".
        default: normalised value, or None where the scenario must give one.
        doc: meaning, one phrase.
        choices: permitted texts, if limited; "vehicle_{n}" stands for vehicle_1, vehicle_2, ... of
            a size n.
        least: bound of a whole number.
        most: the same from above.
        size: name of the size that a whole number says.
        symbolic: in a resolved field, the shape before, as people read it.
    """

    name: str
    doc: str
    kind: str = "number"
    shape: tuple[int | str, ...] = ()
    unit: str = ""
    range: str = "any"
    default: Any = None
    required: bool = False
    choices: tuple[str, ...] = ()
    least: int = 0
    most: int = 2**53 - 1
    size: str = ""
    symbolic: str = ""

    @property
    def dims(self) -> tuple[int, ...]:
        """The shape in numbers."""
        dims = tuple(n for n in self.shape if isinstance(n, int))
        assert len(dims) == len(self.shape), f"{self.name}: {self.shape} is not resolved"
        return dims

    def resolved(self, sizes: Mapping[str, int]) -> Field:
        """The field with numbers for the names of sizes, its default in full shape."""
        if any(isinstance(n, str) for n in self.shape):
            shape = tuple(sizes[n] if isinstance(n, str) else n for n in self.shape)
            full = None if self.default is None else np.broadcast_to(self.default, shape).tolist()
            return replace(self, shape=shape, default=full, symbolic=by(self.shape))
        if any("{" in choice for choice in self.choices):
            choices = [_numbered(choice, sizes) for choice in self.choices]
            return replace(self, choices=tuple(c for some in choices for c in some))
        return self

    @property
    def permitted(self) -> str:
        """The permitted values in words."""
        if self.kind == "flag":
            return "true or false"
        if self.kind == "whole":
            return f"a whole number, {self.least} to {self.most}"
        if self.kind == "list":
            return f"a list of numbers {self.unit}".rstrip()
        if self.kind == "text":
            return "one of " + ", ".join(self.choices) if self.choices else "a text"
        bound = {"positive": "> 0", "non_negative": ">= 0", "any": "any finite number"}[self.range]
        text = f"{bound} {self.unit}".rstrip()
        if self.unit in UNIT_SCALES:
            text += f' (or a text such as "1.5 {next(iter(UNIT_SCALES[self.unit]))}")'
        if self.shape:
            text += f", shape {self._wanted()} or fewer dimensions"
        return text

    def normalise(self, value: Any, where: str, key: str) -> Any:
        """The value in SI as float, nested lists of the field's shape, str or bool.

        Raises:
            ScenarioError: naming file, key, value, permitted range and what to do.
        """

        def fail(problem: str, advice: str = "") -> ScenarioError:
            return ScenarioError(
                problem, where=where, key=key, value=value, permitted=self.permitted, advice=advice
            )

        if self.kind == "flag":
            if not isinstance(value, bool):
                raise fail("is not a truth value")
            return value
        if self.kind == "text":
            if not isinstance(value, str):
                raise fail("is not a text", "put it in quotes")
            if self.choices and value not in self.choices:
                raise fail("is not known", did_you_mean(value, self.choices))
            return value

        if self.kind == "whole":
            if isinstance(value, bool) or not isinstance(value, (int, float)) or value % 1 != 0:
                raise fail("is not a whole number")
            if not self.least <= value <= self.most:
                raise fail("is out of range")
            return int(value)

        def number(entry: Any) -> float:
            if isinstance(entry, bool):
                raise fail("is a truth value, not a number")
            if isinstance(entry, (int, float)):
                try:
                    return float(entry)
                except OverflowError:
                    raise fail("is too large a number") from None
            if isinstance(entry, str):
                return self._from_text(entry, fail)
            raise fail(f"is not a number but {type_name(entry)}")

        def convert(entry: Any) -> Any:
            if isinstance(entry, Mapping):
                raise fail("is a table, not a number")
            if isinstance(entry, np.ndarray):
                entry = entry.tolist()
            if isinstance(entry, Sequence) and not isinstance(entry, str):
                return [convert(e) for e in entry]
            return number(entry)

        try:
            array = np.array(convert(value), dtype=float)
            if self.kind == "list":
                array = array.reshape(-1)
            else:
                array = np.broadcast_to(array, self.dims).copy()
        except ScenarioError:
            raise
        except ValueError:
            wanted = self._wanted() or "a single number"
            raise fail("has the wrong shape", f"give {wanted}") from None
        self._check_range(array, fail)
        return array.tolist()

    def _wanted(self) -> str:
        """The shape as people read it: "n x 3, here 4 x 3"."""
        return f"{self.symbolic}, here {by(self.shape)}," if self.symbolic else by(self.shape)

    def _from_text(self, text: str, fail: Any) -> float:
        match = _QUANTITY.fullmatch(text)
        if match is None:
            raise fail("is a text, not a number", "write the number without quotes")
        amount, unit = float(match[1]), match[2]
        if unit == self.unit:
            return amount
        scale = UNIT_SCALES.get(self.unit, {}).get(unit)
        if scale is None:
            known = [self.unit, *UNIT_SCALES.get(self.unit, {})] if self.unit else []
            raise fail(
                f"has the wrong unit {unit!r}",
                "use " + " or ".join(known) if known else "this key has no unit: drop it",
            )
        return amount * scale

    def _check_range(self, array: np.ndarray, fail: Any) -> None:
        may_be_infinite = self.default is not None and np.isinf(np.asarray(self.default)).any()
        if np.isnan(array).any() or (np.isinf(array).any() and not may_be_infinite):
            raise fail("is not finite")
        if self.range == "positive" and (array <= 0).any():
            raise fail("is not positive")
        if self.range == "non_negative" and (array < 0).any():
            raise fail("is negative")


def by(shape: Iterable[int | str]) -> str:
    """A shape as people read it: "2 x 3"."""
    return " x ".join(map(str, shape))


def _numbered(choice: str, sizes: Mapping[str, int]) -> list[str]:
    head, brace, size = choice.rstrip("}").partition("{")
    return [f"{head}{k + 1}" for k in range(sizes[size])] if brace else [choice]


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The known word that is nearest, as advice; "" if none is near."""
    close = difflib.get_close_matches(word, list(known), n=1)
    return f"did you mean {close[0]!r}?" if close else ""


def type_name(value: Any) -> str:
    """What a TOML value is, in words."""
    names = {dict: "a table", list: "a list", str: "a text", bool: "a truth value"}
    return names.get(type(value), f"of type {type(value).__name__}")
