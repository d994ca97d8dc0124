"""Control laws: the compiled ones by name, and anyone's own in Python.

A law of your own is a function or a class::

    def law(m: Measurement) -> Sequence[float]: ...       # u1, u2, u3, u4 in N

    class Law:
        title = "what figures call it"                      # optional
        def __init__(self, scenario: Scenario) -> None: ... # once per run
        def step(self, m: Measurement) -> Sequence[float]: ...

It is stepped at the scenario's control rate against the same plant, sensors, actuators and metrics
as the compiled laws, without a rebuild. What a law is told and answers is its plant's: this is the
planar one, `multilift.Measurement`.
"""

from __future__ import annotations

import importlib.util
import inspect
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from multilift.errors import ControllerError

if TYPE_CHECKING:
    from multilift.scenario import Scenario


#: A law of one's own, made for a run: from what is measured, as its model says, to numbers.
Law = Callable[[Any], Sequence[float]]


#: Laws in Python that multilift brings, slow ones to compare with: module and class.
LIBRARY = {"nmpc": ("multilift.nmpc", "Nmpc")}


@dataclass(frozen=True)
class CompiledLaw:
    """A law of the compiled core: its name, and one line for figures and tables."""

    name: str
    title: str


@dataclass(frozen=True)
class PythonLaw:
    """A law written in Python: how to make one for a run, and what to call it."""

    name: str
    title: str
    make: Callable[[Scenario], Law]

    def begin(
        self, scenario: Scenario, count: int, wanted: str
    ) -> Callable[[float, Any], list[float]]:
        """A fresh law as a function of the time and what is measured.

        Args:
            scenario: what it flies.
            count: how many numbers it must answer.
            wanted: these in words, for errors: "four finite forces u1, u2, u3, u4 in N".

        Raises:
            ControllerError: if the law cannot be constructed; and, from the function, if it
                raises or answers anything else, with the time.
        """
        try:
            law = self.make(scenario)
        except Exception as error:
            raise ControllerError(f"law {self.name!r} cannot be constructed: {error!r}") from error

        def step(t: float, measured: Any) -> list[float]:
            try:
                answer = law(measured)
            except (Exception, SystemExit) as error:
                raise ControllerError(f"law {self.name!r} raised at t = {t:g} s: {error!r}") from (
                    error
                )
            try:
                u = [float(x) for x in np.ravel(np.asarray(answer, dtype=float))]
            except (TypeError, ValueError):
                u = []
            if len(u) != count or not all(map(math.isfinite, u)):
                raise ControllerError(
                    f"law {self.name!r} answered {answer!r} at t = {t:g} s; it must answer {wanted}"
                )
            return u

        return step


def resolve(controller: Any, scenario: Scenario) -> tuple[CompiledLaw | PythonLaw, Scenario]:
    """The law that is meant, and the scenario under it.

    Args:
        controller: None for the scenario's own; a compiled law's name; "FILE.py:NAME"; or a
            function or class as this module describes.
        scenario: supplies the gains of a compiled law.

    Raises:
        ControllerError: if there is no such law.
        ScenarioError: if the scenario lacks a gain that the law needs.
    """
    laws = scenario.model.laws
    if controller is None:
        return CompiledLaw(scenario.law, laws[scenario.law].title), scenario
    if isinstance(controller, (CompiledLaw, PythonLaw)):
        controller = controller.name if isinstance(controller, CompiledLaw) else controller
    if isinstance(controller, PythonLaw):
        return controller, scenario
    if isinstance(controller, str):
        if controller in laws:
            changed = scenario.law != controller
            law = CompiledLaw(controller, laws[controller].title)
            return law, scenario.with_law(controller) if changed else scenario
        if controller in LIBRARY:
            module, name = LIBRARY[controller]
            return python_law(getattr(importlib.import_module(module), name)), scenario
        if ".py:" in controller:
            return python_law(_load_from_file(controller)), scenario
        raise ControllerError(
            f"no control law is called {controller!r}\n"
            f"  permitted: {', '.join((*laws, *LIBRARY))}, or FILE.py:NAME for your own"
        )
    return python_law(controller), scenario


def python_law(target: Any) -> PythonLaw:
    """Wraps a function, a class or an object with ``step``.

    Raises:
        ControllerError: if it is none of these.
    """
    name = getattr(target, "__name__", type(target).__name__)
    title = str(getattr(target, "title", name))
    made_per_run = inspect.isclass(target)
    step: Any = getattr(target, "step", None)
    if made_per_run and callable(step):
        return PythonLaw(name, title, lambda scenario: target(scenario).step)
    if made_per_run:
        raise ControllerError(f"class {name} has no method step(self, m)")
    law: Any = step if callable(step) else target
    if callable(law):
        return PythonLaw(name, title, lambda _: law)
    raise ControllerError(
        f"{target!r} is no control law: give a function of a Measurement, or a class with "
        "__init__(self, scenario) and step(self, m)"
    )


def _load_from_file(reference: str) -> Any:
    file_name, _, attribute = reference.rpartition(":")
    file = Path(file_name)
    if not file.is_file():
        raise ControllerError(f"control law {reference!r}: the file {file} does not exist")
    spec = importlib.util.spec_from_file_location(f"multilift_law_{file.stem}", file)
    if spec is None or spec.loader is None:
        raise ControllerError(f"control law {reference!r}: {file} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses and the like look for it
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise ControllerError(f"control law {reference!r}: {file} fails: {error!r}") from error
    if not hasattr(module, attribute):
        raise ControllerError(f"control law {reference!r}: {file} defines no {attribute!r}")
    return getattr(module, attribute)
