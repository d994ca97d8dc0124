"""Options that commands share, and scenarios changed by them."""

from __future__ import annotations

import tomllib
from typing import Annotated, Any

import typer

import multilift as ml
from multilift import models
from multilift.errors import ScenarioError

ControllerOption = Annotated[
    str | None,
    typer.Option(
        "--controller",
        "-c",
        help=f"Law to fly instead of the scenario's: {', '.join(models.law_names())}, or "
        "FILE.py:NAME for your own.",
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set", "-s", metavar="KEY=VALUE", help="Change a value, as in TOML. May be repeated."
    ),
]
ForceOption = Annotated[
    bool, typer.Option("--force", "-f", help="Replace an earlier result of multilift there.")
]


def load_changed(name: str, changes: list[str] | None) -> ml.Scenario:
    """A scenario with what ``--set`` says.

    Raises:
        ScenarioError: as `multilift.load`, and for a change that is none.
    """
    scenario = ml.load(name)
    if not changes:
        return scenario
    return scenario.with_values(dict(_parse_change(change) for change in changes))


def _parse_change(text: str) -> tuple[str, Any]:
    key, equals, value = text.partition("=")
    if not equals or not key.strip():
        raise ScenarioError(
            f"{text!r} is not KEY=VALUE", where="--set", advice="such as controller.k_lambda=0.8"
        )
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key.strip(), value.strip()  # a bare word is a text
