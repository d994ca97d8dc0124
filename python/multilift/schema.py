"""What a scenario file may contain: every key with its shape, unit, range, default and meaning.

Plant, gains, actuators and sensors describe themselves in the compiled core; the rest is here.
The scenario reference in the documentation is generated from the same tables.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from multilift import _core
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
        kind: "number", "list" (of numbers, any length), "text" or "flag".
        shape: of a number's array, () for a scalar. A value of fewer dimensions is repeated.
        unit: of a number, "" where it has none.
        range: "any", "positive" or "non_negative".
        default: normalised value, or None where the scenario must give one.
        doc: meaning, one phrase.
        choices: permitted texts, if limited.
    """

    name: str
    doc: str
    kind: str = "number"
    shape: tuple[int, ...] = ()
    unit: str = ""
    range: str = "any"
    default: Any = None
    required: bool = False
    choices: tuple[str, ...] = ()

    @property
    def permitted(self) -> str:
        """The permitted values in words."""
        if self.kind == "flag":
            return "true or false"
        if self.kind == "list":
            return f"a list of numbers {self.unit}".rstrip()
        if self.kind == "text":
            return "one of " + ", ".join(self.choices) if self.choices else "a text"
        bound = {"positive": "> 0", "non_negative": ">= 0", "any": "any finite number"}[self.range]
        text = f"{bound} {self.unit}".rstrip()
        if self.unit in UNIT_SCALES:
            text += f' (or a text such as "1.5 {next(iter(UNIT_SCALES[self.unit]))}")'
        if self.shape:
            text += ", shape " + " x ".join(map(str, self.shape)) + " or fewer dimensions"
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
                raise fail("is not known", _did_you_mean(value, self.choices))
            return value

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
            raise fail(f"is not a number but {_type_name(entry)}")

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
                array = np.broadcast_to(array, self.shape).copy()
        except ScenarioError:
            raise
        except ValueError:
            wanted = " x ".join(map(str, self.shape)) or "a single number"
            raise fail("has the wrong shape", f"give {wanted}") from None
        self._check_range(array, fail)
        return array.tolist()

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


@dataclass(frozen=True)
class Table:
    """A table of a scenario, such as ``[plant]``: its fields in order and its meaning."""

    name: str
    doc: str
    fields: tuple[Field, ...]

    def normalise(self, values: Any, where: str, prefix: str = "") -> dict[str, Any]:
        """Every field's value, given or default; see Field.normalise."""
        prefix = prefix or self.name
        values = _as_table(values, where, prefix)
        by_name = {f.name: f for f in self.fields}
        for key, value in values.items():
            if key not in by_name:
                raise unknown_key(where, f"{prefix}.{key}", value, by_name)
        result = {}
        for field in self.fields:
            if field.name in values:
                result[field.name] = field.normalise(
                    values[field.name], where, f"{prefix}.{field.name}"
                )
            elif field.required:
                raise ScenarioError(
                    "is missing",
                    where=where,
                    key=f"{prefix}.{field.name}",
                    permitted=field.permitted,
                    advice=f"add it to [{prefix}]: {field.doc}",
                )
            else:
                result[field.name] = field.default
        return result


def unknown_key(where: str, key: str, value: Any, known: Iterable[str]) -> ScenarioError:
    """The error for a key that no table has."""
    known = list(known)
    return ScenarioError(
        "is not a known key",
        where=where,
        key=key,
        value=value,
        permitted=", ".join(known),
        advice=_did_you_mean(key.rsplit(".", 1)[-1], known) or "remove it",
    )


def _as_table(values: Any, where: str, prefix: str) -> Mapping[str, Any]:
    if not isinstance(values, Mapping):
        raise ScenarioError(
            f"is {_type_name(values)}, not a table",
            where=where,
            key=prefix,
            value=values,
            advice=f"write it as [{prefix}] with keys below",
        )
    return values


def _did_you_mean(word: str, known: Iterable[str]) -> str:
    close = difflib.get_close_matches(word, list(known), n=1)
    return f"did you mean {close[0]!r}?" if close else ""


def _type_name(value: Any) -> str:
    names = {dict: "a table", list: "a list", str: "a text", bool: "a truth value"}
    return names.get(type(value), f"of type {type(value).__name__}")


def _core_fields(table: list[tuple[Any, ...]]) -> tuple[Field, ...]:
    fields = []
    for name, unit, bound, shape, defaults, doc in table:
        array = np.array(defaults).reshape(shape)
        required = bool(np.isnan(array).any())
        fields.append(
            Field(
                name,
                doc,
                shape=tuple(shape),
                unit=unit,
                range=bound,
                default=None if required else array.tolist(),
                required=required,
            )
        )
    return tuple(fields)


PLANT = Table(
    "plant",
    "the vehicles, cables and bar (paper, section 2)",
    (
        Field("model", "which plant", "text", default="planar", choices=("planar",)),
        *_core_fields(_core.planar_plant_fields()),
    ),
)
START = Table(
    "start",
    "where the system starts; it must satisfy the bar's closure",
    (
        Field("vehicle_position", "(y, z) of vehicles 1 and 2", shape=(2, 2), unit="m",
              required=True),
        Field("angle", "theta1, theta2, theta3; left out: the load hangs at rest below the "
              "vehicles", shape=(3,), unit="rad"),
        Field("vehicle_velocity", "(y, z) velocities of the vehicles; left out: at rest",
              shape=(2, 2), unit="m/s"),
        Field("angle_rate", "rates of the three angles; left out: at rest", shape=(3,),
              unit="rad/s"),
    ),
)  # fmt: skip
GOAL = Table(
    "goal",
    "where the vehicles shall come to rest, equation (17)",
    (
        Field("vehicle_position", "(y, z) of vehicles 1 and 2", shape=(2, 2), unit="m",
              required=True),
        Field("allow_mismatch", "accept goals that break (17): y2 - y1 = bar length, "
              "z1 - l1 = z2 - l2; the load then hangs with nonzero angles", "flag", default=False),
    ),
)  # fmt: skip
SIMULATION = Table(
    "simulation",
    "how the run is computed",
    (
        Field("duration", "simulated time", unit="s", range="positive", required=True),
        Field("step", "fixed step of the Runge-Kutta integrator of order 4", unit="s",
              range="positive", default=0.001),
        Field("record_period", "between two rows of the trajectory; a multiple of the step",
              unit="s", range="positive", default=0.01),
        Field("seed", "of the measurement noise; a whole number", range="non_negative",
              default=0.0),
    ),
)  # fmt: skip
ACTUATORS = Table(
    "actuators",
    "from the command u to thrust and attitude; left out: u acts at once, without limits",
    _core_fields(_core.planar_actuator_fields()),
)
SENSORS = Table(
    "sensors",
    "what the law is told; left out: the truth at each control instant",
    _core_fields(_core.planar_sensor_fields()),
)
PUSH = Table(
    "push",
    "an outside force as a function of time; one [[push]] each",
    (
        Field("body", "what it acts on", "text", required=True,
              choices=("bar", "vehicle_1", "vehicle_2")),
        Field("start", "when it begins", unit="s", range="non_negative", required=True),
        Field("duration", "how long it lasts", unit="s", range="positive", required=True),
        Field("force", "(y, z) at the body's centre of mass", shape=(2,), unit="N",
              default=[0.0, 0.0]),
        Field("torque", "about x, from y towards z; bar only", unit="N m", default=0.0),
        Field("shape", "profile over time, of height 1", "text", default="pulse",
              choices=("pulse", "half_sine", "sine", "samples")),
        Field("frequency", "of shape 'sine'", unit="Hz", range="positive"),
        Field("sample_times", "for shape 'samples': times after start, ascending",
              kind="list", unit="s"),
        Field("sample_values", "for shape 'samples': heights at these times, linear between",
              kind="list"),
    ),
)  # fmt: skip

#: The tables that every scenario has once, by name.
TABLES = {t.name: t for t in (PLANT, START, GOAL, SIMULATION, ACTUATORS, SENSORS)}

LAW_TITLES: dict[str, str] = {name: title for name, (title, _) in _core.planar_laws().items()}
_LAW_FIELDS = {name: _core_fields(fields) for name, (_, fields) in _core.planar_laws().items()}

CONTROLLER_COMMON = (
    Field("law", "which control law", "text", required=True, choices=tuple(LAW_TITLES)),
    Field("rate", "how often the law is stepped; its command is held in between", unit="Hz",
          range="positive", default=1000.0),
)  # fmt: skip


def controller_table(law: str) -> Table:
    """The ``[controller]`` table for a compiled law."""
    return Table("controller", LAW_TITLES[law], (*CONTROLLER_COMMON, *_LAW_FIELDS[law]))


def gain_fields(law: str) -> tuple[Field, ...]:
    """The gains of a compiled law, in the core's order."""
    return _LAW_FIELDS[law]


def flatten(table: Mapping[str, Any], fields: Iterable[Field]) -> list[float]:
    """The numbers of a normalised table, in the order in which the core unpacks them."""
    return [float(x) for f in fields for x in np.ravel(table[f.name])]
