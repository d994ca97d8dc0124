"""A tuning: a TOML file or options of the command, read and checked."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from multilift import library, schema
from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.scenario import Scenario
from multilift.scenario import load as load_scenario
from multilift.study import checks, vary
from multilift.study import spec as study_spec
from multilift.study.draws import draw
from multilift.study.rows import overrides
from multilift.study.spec import Study
from multilift.study.vary import Array, Reader, Vary
from multilift.tune.goals import COMBINATIONS, STATISTICS, Goal, Objective
from multilift.tune.space import Space

BUDGET = 4096
POPULATION = 48

_KEYS = ("schema", "title", "description", "scenario", "controller", "set", "variable", "objective",
         "constraint", "combine", "statistic", "quantile", "over", "budget", "population",
         "seed")  # fmt: skip
#: What laws know of worlds that differ: what the scenario says, or each world's truth.
BELIEFS = ("scenario", "truth")
_VARIABLE = ("key", "name", "label", "unit", "apply", "scale", "low", "high")
_SCALES = {"log": "log_uniform", "linear": "uniform"}
#: What a study's file says that tuning over its draws does not need.
_OF_STUDIES = ("name", "title", "description", "scenario", "controllers", "metrics", "success",
               "map")  # fmt: skip


@dataclass(frozen=True)
class Tuning:
    """A checked tuning.

    Attributes:
        where: the file, or a description.
        scenario: as it is before tuning, under the law that is tuned.
        space: what varies.
        goal: what makes a set of numbers better than another.
        over: the draws over which the statistic goes; None for the scenario alone.
        budget: sets of numbers to fly.
        population: sets of a generation of the first descent.
        seed: of the search.
    """

    where: str
    scenario: Scenario
    space: Space
    goal: Goal
    over: Study | None
    budget: int
    population: int
    seed: int

    @property
    def worlds(self) -> int:
        """Worlds that each set flies."""
        return 1 if self.over is None else self.over.worlds

    def start(self) -> Array:
        """The scenario's own numbers as a point of the unit cube."""
        return self.space.unit(self.own_numbers())

    def own_numbers(self) -> dict[str, float]:
        """What the scenario's own numbers are, where they are one; the middle where not."""
        return {v.name: _own(self.scenario, v) for v in self.space.varied}

    def tuned(self, numbers: Mapping[str, float]) -> Scenario:
        """The scenario with a set of numbers."""
        rows = {name: np.array([x]) for name, x in numbers.items()}
        changes = self.space.overrides(self.scenario, rows)
        return self.scenario.with_values(
            {key: float(x[0]) if x.ndim == 1 else x[0].tolist() for key, x in changes.items()}
        )

    def digest(self) -> str:
        """Fingerprint of everything that decides the result."""
        content = {
            "scenario": _without_texts(self.scenario),
            "space": [repr(replace(v, label="", unit="")) for v in self.space.varied],
            "goal": asdict(self.goal),
            "over": None if self.over is None else self.over.digest(),
            "budget": self.budget,
            "population": self.population,
            "seed": self.seed,
        }
        text = json.dumps(content, sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()


def worlds_of(study: Study | None, law: str) -> tuple[dict[str, Array], int]:
    """The keys that a study's draws set, one entry a world, and how many worlds these are."""
    if study is None:
        return {}, 1
    return overrides(study, law, draw(study, 0, study.worlds)), study.worlds


def titles() -> list[tuple[str, str]]:
    """Name and title of each shipped tuning."""
    return [(f.stem, str(library.read(f, f.name)["title"])) for f in library.tunings()]


def load(path: str | Path, *, base: Scenario | None = None, **changes: Any) -> Tuning:
    """Reads and checks a tuning.

    Args:
        path: a TOML file, or the name of a tuning that multilift ships.
        base: a scenario at hand, instead of the one that the file names.
        changes: keys of the file that are to be other than it says, such as ``scenario="sim2"``.

    Raises:
        ScenarioError: for a missing file and anything wrong in it: file, key, value, what is
            permitted and what to do.
    """
    file = library.find_tuning(path)
    return parse({**library.read(file, str(path)), **changes}, str(path), file.parent, base=base)


def parse(
    raw: Mapping[str, Any], where: str, folder: Path, *, base: Scenario | None = None
) -> Tuning:
    """Checks a tuning's tables.

    Args:
        raw: as a TOML file holds them.
        where: the file, for errors.
        folder: where relative paths begin.
        base: a scenario at hand, instead of ``scenario``.

    Raises:
        ScenarioError: see `load`.
    """
    for key, value in raw.items():
        if key not in _KEYS:
            raise schema.unknown_key(where, key, value, _KEYS)
    if raw.get("schema", 1) != 1:
        raise ScenarioError("is not a version this multilift reads", where=where, key="schema",
                            value=raw["schema"], permitted="1")  # fmt: skip
    scenario = _scenario(raw, where, folder, base)
    varied = _variables(raw, scenario, where)
    over = _over(raw, scenario, where, folder)
    if over is not None:
        checks.check_collisions((*varied, *over.vary), where, "variables and draws")
    checks.check_names(varied, where, "variable")
    checks.check_collisions(varied, where, "variable")
    for k, v in enumerate(varied):
        checks.check_ends(scenario, v, f"variable[{k}]", where)
    return Tuning(
        where=where,
        scenario=scenario,
        space=Space(varied),
        goal=_goal(raw, scenario, where, over),
        over=over,
        budget=_whole(raw, "budget", where, BUDGET, 4, 10**8),
        population=_whole(raw, "population", where, POPULATION, 4, 10**4),
        seed=_whole(raw, "seed", where, 1, 0, 2**32 - 1),
    )


def _scenario(
    raw: Mapping[str, Any], where: str, folder: Path, scenario: Scenario | None
) -> Scenario:
    if scenario is None and "scenario" not in raw:
        raise ScenarioError("is missing", where=where, key="scenario",
                            permitted="a scenario file, or a shipped name",
                            advice="give it in the file, or to the command")  # fmt: skip
    if scenario is None:
        named = Field("scenario", "", "text").normalise(raw["scenario"], where, "scenario")
        beside = folder / str(named)
        scenario = load_scenario(beside if beside.is_file() else str(named))
    law = raw.get("controller", scenario.law)
    if law != scenario.law:
        with checks.naming(where, "controller"):
            scenario = scenario.with_law(law)
    with checks.naming(where, "set"):
        return scenario.with_values(study_spec.changes_of(raw.get("set", {}), where))


def _variables(raw: Mapping[str, Any], scenario: Scenario, where: str) -> tuple[Vary, ...]:
    entries = _tables(raw, "variable", where)
    if not entries:
        raise ScenarioError("is missing", where=where, key="variable",
                            advice="write one [[variable]] for each number to tune, or give "
                            "--vary KEY=LOW:HIGH")  # fmt: skip
    gains = scenario.model.controller_keys(scenario.law)
    known = {name for law in scenario.model.laws for name in scenario.model.controller_keys(law)}
    result = []
    for k, entry in enumerate(entries):
        prefix = f"variable[{k}]"
        reader = Reader(entry, prefix, where)
        reader.refuse_unknown(_VARIABLE)
        if _of_other_law(entry, gains, known):
            continue
        scale = reader.text("scale", default="linear", choices=tuple(_SCALES))
        given = {key: value for key, value in entry.items() if key != "scale"}
        given["distribution"] = _SCALES[scale]
        if scale == "log" and reader.number("low") <= 0:
            raise reader.fail("low", "has no logarithm", "> 0", 'or use scale = "linear"')
        result.append(vary.parse(given, prefix, scenario, where))
    if not result:
        raise ScenarioError("holds gains of other laws only", where=where, key="variable",
                            value=scenario.law, advice="add gains of this law")  # fmt: skip
    return tuple(result)


def _of_other_law(entry: Mapping[str, Any], gains: set[str], known: set[str]) -> bool:
    """Whether a variable is a gain that another law of the model has and this one has not."""
    given = entry.get("key")
    keys = given if isinstance(given, list) else [given]
    for key in keys:
        text = key.get("key") if isinstance(key, Mapping) else key
        if not isinstance(text, str) or not text.startswith("controller."):
            return False
        gain = text.removeprefix("controller.").split(".")[0].split("[")[0]
        if gain in gains or gain not in known:
            return False
    return True


def _goal(raw: Mapping[str, Any], scenario: Scenario, where: str, over: Study | None) -> Goal:
    quantities = study_spec.quantities_of(scenario)
    objectives = []
    for k, entry in enumerate(_tables(raw, "objective", where)):
        reader = Reader(entry, f"objective[{k}]", where)
        reader.refuse_unknown(("metric", "weight", "within", "sense"))
        metric = reader.text("metric", choices=tuple(quantities))
        weight = reader.number("weight") if "weight" in entry else 1.0
        if weight <= 0:
            raise reader.fail("weight", "is not positive", "> 0", 'or use sense = "maximise"')
        unit = quantities[metric].unit
        within = reader.number("within", unit) if "within" in entry else 0.0
        if within < 0:
            raise reader.fail("within", "is negative", f">= 0 {unit}".rstrip())
        sense = reader.text("sense", default="minimise", choices=("minimise", "maximise"))
        objectives.append(Objective(metric, weight, within, sense == "maximise", unit))
    if not objectives:
        raise ScenarioError("is missing", where=where, key="objective",
                            advice="write one [[objective]] with a metric, or give "
                            "--minimise METRIC")  # fmt: skip
    combine = _choice(raw, "combine", where, "lexicographic", COMBINATIONS)
    if combine == "front" and not 2 <= len(objectives) <= 3:
        raise ScenarioError("needs two or three objectives", where=where, key="combine",
                            value=combine, advice=f"there are {len(objectives)}")  # fmt: skip
    statistic = _choice(raw, "statistic", where, "nominal" if over is None else "quantile",
                        STATISTICS)  # fmt: skip
    if (statistic == "nominal") != (over is None):
        raise ScenarioError(
            "goes over draws, of which there are none" if over is None
            else "takes no notice of the draws of [over]",
            where=where, key="statistic", value=statistic,
            permitted="nominal" if over is None else ", ".join(STATISTICS[1:]),
            advice="give the draws by [over] or --over" if over is None else "leave out [over]",
        )  # fmt: skip
    quantile = float(Field("quantile", "").normalise(raw.get("quantile", 0.95), where, "quantile"))
    if not 0 < quantile < 1:
        raise ScenarioError("is no quantile", where=where, key="quantile", value=quantile,
                            permitted="between 0 and 1")  # fmt: skip
    constraints = tuple(study_spec.criteria(raw, scenario, where, "constraint"))
    return Goal(tuple(objectives), constraints, combine, statistic, quantile)


def _over(raw: Mapping[str, Any], scenario: Scenario, where: str, folder: Path) -> Study | None:
    """The study over whose draws the statistic goes, on the scenario that is tuned."""
    if "over" not in raw:
        return None
    given = raw["over"]
    if not isinstance(given, Mapping):
        raise ScenarioError("is not a table", where=where, key="over", value=given,
                            advice="write [over] with study = ... below")  # fmt: skip
    content = dict(given)
    if "study" in content:
        named = str(Field("study", "", "text").normalise(content.pop("study"), where, "over.study"))
        beside = folder / named
        file = library.find_study(beside if beside.is_file() else named)
        read = library.read(file, named)
        content = {**{k: v for k, v in read.items() if k not in _OF_STUDIES}, **content}
    changes = study_spec.changes_of(content.pop("set", {}), where)
    if _choice(content, "believe", f"{where}, [over]", "scenario", BELIEFS) == "scenario":
        changes = {**_believed(scenario), **changes}
    content.pop("believe", None)
    with checks.naming(where, "over.set"):
        base = scenario.with_values(changes)
    return study_spec.of_scenario(content, base, changes, f"{where}, [over]")


def _believed(scenario: Scenario) -> dict[str, Any]:
    """What keeps a law from learning the truth of each world: the plant as the scenario has it."""
    return {f"controller.assumed.{name}": value
            for name, value in scenario.values["controller"]["assumed"].items()
            if isinstance(value, (float, list))}  # fmt: skip


def _own(scenario: Scenario, varied: Vary) -> float:
    """The number at which the scenario stands, where all its keys agree on one; else the middle."""
    middle = (
        float(np.sqrt(varied.low * varied.high))
        if varied.distribution == "log_uniform"
        else 0.5 * (varied.low + varied.high)
    )
    if varied.apply != "set":
        neutral = 1.0 if varied.apply == "multiply" else 0.0
        return float(np.clip(neutral, varied.low, varied.high))
    target = varied.targets[0]
    own = scenario[target.key]
    if own is None or target.factor == 0.0:
        return middle
    return float((np.mean(own) - target.offset) / target.factor)


def _without_texts(scenario: Scenario) -> dict[str, Any]:
    texts = ("name", "title", "source", "description")
    return {k: v for k, v in scenario.raw().items() if k not in texts}


def _tables(raw: Mapping[str, Any], key: str, where: str) -> list[Any]:
    given = raw.get(key, [])
    if not isinstance(given, list):
        raise ScenarioError("is not a list of tables", where=where, key=key,
                            advice=f"write [[{key}]]")  # fmt: skip
    return given


def _choice(
    raw: Mapping[str, Any], key: str, where: str, default: str, choices: tuple[str, ...]
) -> str:
    field = Field(key, "", "text", choices=choices)
    return str(field.normalise(raw.get(key, default), where, key))


def _whole(
    raw: Mapping[str, Any], key: str, where: str, default: int, least: int, most: int
) -> int:
    field = Field(key, "", "whole", least=least, most=most)
    return int(field.normalise(raw.get(key, default), where, key))
