"""A Gymnasium vector environment around :class:`multilift.Worlds` (``multilift[gym]``).

Needs gymnasium 1.0 or newer; importing this module without it raises MissingExtraError.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilift.errors import MissingExtraError, ScenarioError
from multilift.models.planar.scenario import planar_only
from multilift.scenario import Scenario
from multilift.worlds import Worlds

try:
    import gymnasium
    from gymnasium.vector import AutoresetMode, VectorEnv
    from gymnasium.vector.utils import batch_space
except ImportError:
    raise MissingExtraError("gymnasium", "gym", "multilift.gym") from None

Array = NDArray[np.float64]

#: Bound on every observed number, far outside any flight; what diverged is shown at it.
BOUND = 1e6


@dataclass(frozen=True)
class Weights:
    """What a second of flight costs: each weight times the sum of squares of what it weighs.

    Attributes:
        position: distances of the vehicles from their goals, per m^2 s.
        velocity: the vehicles' velocities, per (m/s)^2 s.
        angle: the three angles, per rad^2 s.
        angle_rate: their rates, per (rad/s)^2 s.
        force: u1..u4 after clipping, per N^2 s.
        failure: what a slack cable, an angle at 90 degrees or divergence costs, once. More than
            the worst flight to the end, or a learner finds that crashing saves it cost.
    """

    position: float = 1.0
    velocity: float = 0.1
    angle: float = 1.0
    angle_rate: float = 0.1
    force: float = 0.001
    failure: float = 1000.0


class TwinLiftVectorEnv(VectorEnv[Array, Array, NDArray[Any]]):
    """Many twin lifts, each to be brought to its goal with the load at rest.

    One step is one control period of the scenario, over which the commanded forces are held.

    Action, shape (4,): u1, u2, u3, u4 of the paper, N: the forces along y and z on vehicles 1 and
    2 beyond what holds it and half of the bar. Clipped to ``single_action_space``; then the
    scenario's actuators do with them what they do.

    Observation, shape (14,): y1, z1, y2, z2 less the goal, m; their velocities, m/s; theta1,
    theta2, theta3, rad; their rates, rad/s. With ``observe="truth"`` as they are; with
    ``observe="measured"`` as the scenario's sensors tell them, with noise, delay and sampling
    period. The reward and the endings go by the truth either way.

    Where actuators or sensors are not ideal each episode of each environment has noise of its own,
    from a seed that the environment's stream gives.

    Reward: minus the period times the weighted squares of :class:`Weights` at the end of the step;
    minus ``failure`` instead in the step in which a world fails.

    An episode terminates where a cable goes slack, an angle reaches 90 degrees or the state
    diverges, and is truncated at ``simulation.duration``. The next step of an environment that
    ended resets it, whatever its action, with reward 0 (autoreset mode NEXT_STEP).
    ``infos["status"]`` is each world's status.

    Attributes:
        worlds: the worlds behind the environments.
        weights: of the reward.
        observe: "truth" or "measured".
    """

    def __init__(
        self,
        scenario: Scenario,
        num_envs: int = 1,
        *,
        draws: Mapping[str, tuple[float, float]] | None = None,
        weights: Weights | None = None,
        force_limit: ArrayLike | None = None,
        observe: Literal["truth", "measured"] = "truth",
        threads: int | None = None,
    ) -> None:
        """Makes the environments; call ``reset`` before the first step.

        Args:
            scenario: plant, start, goal, actuators, sensors, pushes, control rate and duration.
            num_envs: how many.
            draws: scenario keys, as overrides know them, to the least and greatest value; drawn
                uniformly and anew for each episode of each environment. Environment k draws from
                a stream of its own that follows from the seed and k.
            weights: of the reward; None for the defaults.
            force_limit: greatest size of each force, N, one number or u1..u4; None for half of
                what holds the lighter vehicle and half of the bar.
            observe: what observations show, the "truth" or what is "measured".
            threads: None for one a processor.

        Raises:
            ScenarioError: as :class:`multilift.Worlds` does, for bounds of a draw that are the
                wrong way round, and for another ``observe``.
        """
        scenario = planar_only(scenario, "TwinLiftVectorEnv")
        if observe not in ("truth", "measured"):
            raise ScenarioError(
                "is nothing that can be observed",
                where=f"{scenario.where}, TwinLiftVectorEnv", key="observe", value=observe,
                permitted='"truth", "measured"',
            )  # fmt: skip
        self.observe = observe
        self.weights = weights or Weights()
        self._draws = {key: (float(low), float(high)) for key, (low, high) in (draws or {}).items()}
        for key, bounds in self._draws.items():
            if not bounds[0] <= bounds[1]:
                raise ScenarioError(
                    "is drawn between bounds that are no range",
                    where=f"{scenario.where}, draws", key=key, value=bounds,
                    permitted="(least, greatest)",
                )  # fmt: skip
        lowest = {key: np.array([low]) for key, (low, _) in self._draws.items()}
        Worlds(scenario, lowest, count=1)  # for its checks
        # The greatest values, so that what may get an imperfection has one from the start.
        drawn = {key: np.full(num_envs, high) for key, (_, high) in self._draws.items()}
        self.worlds = Worlds(scenario, drawn, count=num_envs, threads=threads)
        if force_limit is None:
            plant = scenario.plant
            shares = (plant.vehicle_mass + 0.5 * plant.bar_mass) * plant.gravity
            force_limit = 0.5 * float(shares.min())
        limit = np.broadcast_to(np.asarray(force_limit, dtype=float), (4,)).copy()
        self.num_envs = num_envs
        # Of the instance: a vectorised environment's metadata may be changed by wrappers.
        self.metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}
        self.single_action_space = gymnasium.spaces.Box(-limit, limit, dtype=np.float64)
        self.single_observation_space = gymnasium.spaces.Box(-BOUND, BOUND, (14,), np.float64)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._streams: list[np.random.Generator] = []

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Starts new episodes.

        Args:
            seed: of the draws; None goes on with the present streams.
            options: ``{"reset_mask": booleans of shape (num_envs,)}`` resets these environments
                only.

        Returns:
            Observations, shape (num_envs, 14), and infos.
        """
        super().reset(seed=seed)
        if seed is not None or not self._streams:
            root = int(self.np_random.integers(2**63))
            self._streams = [np.random.default_rng([root, k]) for k in range(self.num_envs)]
        mask = (options or {}).get("reset_mask")
        self._begin(np.ones(self.num_envs, dtype=bool) if mask is None else np.asarray(mask))
        return self._observe(), self._infos()

    def step(
        self, actions: Array
    ) -> tuple[Array, Array, NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Holds forces for one control period.

        Args:
            actions: u1..u4 of each environment, N, shape (num_envs, 4).

        Returns:
            Observations, shape (num_envs, 14), rewards, terminations and truncations, each of shape
            (num_envs,), and infos.

        Raises:
            ControllerError: for actions of another shape.
        """
        if not self._streams:
            raise gymnasium.error.ResetNeeded("call reset before the first step")
        box = self.single_action_space
        assert isinstance(box, gymnasium.spaces.Box)
        forces = np.clip(np.asarray(actions, dtype=float), box.low, box.high)
        ended = ~self.worlds.running
        self.worlds.step(forces)  # where an environment has ended, nothing moves
        if ended.any():
            self._begin(ended)
        failed = self.worlds.failed
        observations = self._observe()
        cost = self._cost(self._shown(self.worlds.q, self.worlds.q_dot), forces)
        rewards = np.where(failed, -self.weights.failure, -cost)
        rewards[ended] = 0.0
        truncated = ~self.worlds.running & ~failed
        return observations, rewards, failed, truncated, self._infos()

    def _begin(self, mask: NDArray[np.bool_]) -> None:
        drawn: dict[str, NDArray[Any]] = {
            key: np.full(self.num_envs, low) for key, (low, _) in self._draws.items()
        }
        bounds = np.array(list(self._draws.values())).reshape(-1, 2)
        seeds = np.zeros(self.num_envs, dtype=np.int64)
        for k in np.flatnonzero(mask):
            values = self._streams[k].uniform(bounds[:, 0], bounds[:, 1])
            for key, value in zip(drawn, values, strict=True):
                drawn[key][k] = value
            if not self.worlds.ideal:
                seeds[k] = self._streams[k].integers(2**53)
        if not self.worlds.ideal:
            drawn["simulation.seed"] = seeds
        self.worlds.reset(mask, drawn or None)

    def _observe(self) -> Array:
        worlds = self.worlds
        if self.observe == "measured":
            return self._shown(worlds.measured_q, worlds.measured_q_dot)
        return self._shown(worlds.q, worlds.q_dot)

    def _shown(self, q: Array, q_dot: Array) -> Array:
        """Coordinates and rates as observations have them."""
        seen = np.concatenate(
            [q[:, :4] - self.worlds.goal, q_dot[:, :4], q[:, 4:], q_dot[:, 4:]], axis=1
        )
        return np.asarray(np.clip(np.nan_to_num(seen, nan=BOUND), -BOUND, BOUND))

    def _cost(self, state: Array, forces: Array) -> Array:
        w = self.weights
        weights = np.repeat([w.position, w.velocity, w.angle, w.angle_rate], [4, 4, 3, 3])
        squares = state**2 @ weights + w.force * np.square(forces).sum(axis=1)
        return np.asarray(self.worlds.period * squares)

    def _infos(self) -> dict[str, Any]:
        return {"status": self.worlds.status, "_status": np.ones(self.num_envs, dtype=bool)}
