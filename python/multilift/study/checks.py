"""What a study's parts must satisfy together, found out before the first world is simulated."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from multilift import keys
from multilift.errors import ScenarioError

if TYPE_CHECKING:
    from multilift.scenario import Scenario
    from multilift.study.spec import Study
    from multilift.study.vary import Vary

#: Columns that every table of rows has; a varied number may not be called the same.
RESERVED = ("world", "controller", "outcome", "reason", "culprit", "end_time", "simulation.seed")

#: No double-precision draw of a normal distribution lies farther out, in standard deviations.
_FARTHEST = 8.3


@contextmanager
def naming(where: str, key: str) -> Iterator[None]:
    """Errors of a scenario become errors of the study's key that caused them."""
    try:
        yield
    except ScenarioError as error:
        raise ScenarioError(f"does not fit the scenario:\n{_indented(error)}",
                            where=where, key=key) from None  # fmt: skip


def check(study: Study) -> None:
    """Names, keys that collide, and every varied number at both ends of its range.

    Raises:
        ScenarioError: naming file, key, value, permitted values and what to do.
    """
    check_names(study.vary, study.where)
    check_collisions(study.vary, study.where)
    for k, varied in enumerate(study.vary):
        check_ends(study.scenario, varied, f"vary[{k}]", study.where)


def check_names(vary: Sequence[Vary], where: str, table: str = "vary") -> None:
    """Names of varied numbers, which are names of columns, differ."""
    seen: dict[str, int] = {}
    for k, varied in enumerate(vary):
        taken = f"{table}[{seen[varied.name]}]" if varied.name in seen else ""
        taken = "every row" if varied.name in RESERVED[:-1] else taken
        if taken:
            raise ScenarioError(
                f"is the name of a column of {taken} already", where=where,
                key=f"{table}[{k}].name", value=varied.name, advice="give it another name",
            )  # fmt: skip
        seen[varied.name] = k


def check_collisions(vary: Sequence[Vary], where: str, table: str = "vary") -> None:
    """No two numbers may move the same place of the scenario."""
    seen: dict[tuple[keys.Step, ...], int] = {}
    for k, varied in enumerate(vary):
        for target in varied.targets:
            steps = keys.parse(target.key)
            for other, by in seen.items():
                shorter = min(len(other), len(steps))
                if other[:shorter] == steps[:shorter]:
                    raise ScenarioError(
                        f"is moved by {table}[{by}] too", where=where, key=f"{table}[{k}].key",
                        value=target.key, advice="let each key move with one number",
                    )  # fmt: skip
            seen[steps] = k


def check_ends(scenario: Scenario, varied: Vary, key: str, where: str) -> None:
    """The scenario permits a varied number's least and greatest value.

    Args:
        scenario: whose keys it moves.
        varied: the number.
        key: its place in the file, such as ``vary[0]``.
        where: the file, for errors.
    """
    for target in varied.targets:
        try:
            own = scenario[target.key]
        except KeyError:  # a place of an array that the scenario leaves out
            own = None
        if varied.apply != "set" and own is None:
            raise ScenarioError(
                "has no value of its own", where=where, key=f"{key}.key", value=target.key,
                advice=f"give it in the scenario, or use apply = \"set\" instead of {varied.apply}",
            )  # fmt: skip
    low, high = varied.bounds()
    ends = {"low": low, "high": high}
    if varied.distribution == "normal":
        ends = {end: x if np.isfinite(x) else varied.mean + sign * _FARTHEST * varied.std
                for (end, x), sign in zip(ends.items(), (-1, 1), strict=True)}  # fmt: skip
    for end, x in ends.items():
        changes = varied.overrides(scenario, np.array([x]))
        try:
            scenario.with_values(
                {target: float(v[0]) if v.ndim == 1 else v[0].tolist()
                 for target, v in changes.items()}
            )  # fmt: skip
        except ScenarioError as error:
            entry = "values" if varied.distribution == "list" else end
            bound = "" if np.isfinite((low, high)).all() else (
                f" (a draw can lie {_FARTHEST} standard deviations out where no {end} bounds it)"
            )  # fmt: skip
            raise ScenarioError(
                f"reaches {x:.6g}, which the scenario does not permit{bound}:\n{_indented(error)}",
                where=where,
                key=f"{key}.{entry}",
                advice=f"narrow {key}, or change what else stands against it with [set]",
            ) from None


def _indented(error: Exception) -> str:
    return "\n".join("    " + line for line in str(error).splitlines())
