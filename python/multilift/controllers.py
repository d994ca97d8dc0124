"""Control laws: the compiled ones by name, and anyone's own in Python.

A law of your own is a function or a class::

    def law(m: Measurement) -> Sequence[float]: ...       # u1, u2, u3, u4 in N

    class Law:
        title = "what figures call it"                      # optional
        def __init__(self, scenario: Scenario) -> None: ... # once per run
        def step(self, m: Measurement) -> Sequence[float]: ...

It is stepped at the scenario's control rate against the same plant, sensors, actuators and metrics
as the compiled laws, without a rebuild.
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
from numpy.typing import NDArray

from multilift import schema
from multilift.errors import ControllerError

if TYPE_CHECKING:
    from multilift.scenario import Scenario


@dataclass(frozen=True)
class Measurement:
    """What a law is told at a control instant: world y-z plane, z up, SI, radians.

    Attributes:
        t: time, s.
        xi: positions (y, z) of vehicles 1 and 2, shape (2, 2), m.
        xi_dot: their velocities, shape (2, 2), m/s.
        theta: angles theta1, theta2, theta3, shape (3,), rad.
        theta_dot: their rates, shape (3,), rad/s.
        goal: where the vehicles shall come to rest, shape (2, 2), m.
        saturated: whether each vehicle's last command hit a limit of thrust or tilt.
    """

    t: float
    xi: NDArray[np.float64]
    xi_dot: NDArray[np.float64]
    theta: NDArray[np.float64]
    theta_dot: NDArray[np.float64]
    goal: NDArray[np.float64]
    saturated: tuple[bool, bool]


Law = Callable[[Measurement], Sequence[float]]


@dataclass(frozen=True)
class CompiledLaw:
    """A law of the compiled core."""

    name: str

    @property
    def title(self) -> str:
        """One line for figures and tables."""
        return schema.LAW_TITLES[self.name]


@dataclass(frozen=True)
class PythonLaw:
    """A law written in Python: how to make one for a run, and what to call it."""

    name: str
    title: str
    make: Callable[[Scenario], Law]

    def callback(self, scenario: Scenario) -> Callable[..., list[float]]:
        """A fresh law behind the signature that the core calls.

        Raises:
            ControllerError: if the law cannot be constructed; and, from the callback, if it
                raises or answers anything but four finite numbers, with the time.
        """
        try:
            law = self.make(scenario)
        except Exception as error:
            raise ControllerError(f"law {self.name!r} cannot be constructed: {error!r}") from error
        goal = scenario.goal_vector().reshape(2, 2)
        goal.setflags(write=False)  # one array for all steps: a law may not move it

        def step(
            t: float, q: Sequence[float], q_dot: Sequence[float], saturated: Sequence[bool]
        ) -> list[float]:
            positions, rates = np.array(q), np.array(q_dot)
            measured = Measurement(
                t,
                positions[:4].reshape(2, 2),
                rates[:4].reshape(2, 2),
                positions[4:],
                rates[4:],
                goal,
                (bool(saturated[0]), bool(saturated[1])),
            )
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
            if len(u) != 4 or not all(map(math.isfinite, u)):
                raise ControllerError(
                    f"law {self.name!r} answered {answer!r} at t = {t:g} s; it must answer four "
                    "finite forces u1, u2, u3, u4 in N"
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
    if controller is None:
        return CompiledLaw(scenario.law), scenario
    if isinstance(controller, (CompiledLaw, PythonLaw)):
        controller = controller.name if isinstance(controller, CompiledLaw) else controller
    if isinstance(controller, PythonLaw):
        return controller, scenario
    if isinstance(controller, str):
        if controller in schema.LAW_TITLES:
            changed = scenario.law != controller
            return CompiledLaw(controller), scenario.with_law(controller) if changed else scenario
        if ".py:" in controller:
            return python_law(_load_from_file(controller)), scenario
        raise ControllerError(
            f"no control law is called {controller!r}\n"
            f"  permitted: {', '.join(schema.LAW_TITLES)}, or FILE.py:NAME for your own"
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
