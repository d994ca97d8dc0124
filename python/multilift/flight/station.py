"""The ground station without its clock and its screen: one tick after another, for all vehicles."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from multilift.flight.estimate.cables import worst
from multilift.flight.estimate.estimator import Estimator
from multilift.flight.estimate.state import BodyState, Estimate, Quality, Standing
from multilift.flight.lab import Lab
from multilift.flight.link.commands import Command
from multilift.flight.link.setpoint import SetPoint
from multilift.flight.link.vehicle import VehicleLink
from multilift.flight.log import Log
from multilift.flight.mocap.frames import Frame
from multilift.flight.plan import Plan, Wanted
from multilift.flight.pull import Pulls
from multilift.flight.supervisor import (
    Order,
    Orders,
    Seen,
    State,
    Supervisor,
    VehicleSeen,
    Word,
)
from multilift.flight.supervisor.machine import BY_SET_POINT
from multilift.flight.timing import LoopTimes

#: Between two orders of one kind to one vehicle, s.
_ORDER_PERIOD = 1.0

#: Set-points and poses are streamed for so long before their mode is asked for, s.
_STREAM_FIRST = 1.5

#: Poses older than this are not passed on, s.
_POSE_AGE = 0.05

#: Words of the pilot that wait for a tick.
_MOST_WORDS = 8

_COMMANDS: dict[str, Callable[[VehicleLink, float], Command]] = {
    "fly": VehicleLink.fly_mode,
    "arm": VehicleLink.arm,
    "land": VehicleLink.land_mode,
    "disarm": VehicleLink.disarm,
    "cut": lambda link, now: link.disarm(now, cut=True),
}

_MOVING = (Order.TRACK, Order.STAY, Order.DESCEND)

#: Who is to disarm goes on coming down until it has: it may only believe to have landed.
_STEERED = (*BY_SET_POINT, Order.DISARM)
_ALONE = (State.TAKE_OFF, State.FORM_UP)
_ENDING = (State.HOLD, State.LAND, State.LAND_APART)

#: Hover thrust is learnt at this height above where the vehicle was armed, m.
_FREE = 0.2


@dataclass
class Station:
    """Everything between motion capture and vehicles.

    Attributes:
        lab: what there is.
        links: to the vehicles, in the lab's order.
        estimator: of the lab's bodies; bodies by the scenario's names.
        log: takes what is seen and ordered; None for none.
        clock: by which the time within a tick is measured, s; None where ticks take no time.
        times: what the loop measures of itself.
        estimate: of the last tick.
        seen: of the last tick.
        orders: of the last tick.
        wanted: by the plan at the last tick; None where nothing was steered.
        pulls: of the cables.
        commanded: thrust that each vehicle was last sent, N.
    """

    lab: Lab
    links: Sequence[VehicleLink]
    estimator: Estimator
    log: Log | None = None
    clock: Callable[[], float] | None = None
    estimate: Estimate | None = None
    seen: Seen | None = None
    orders: Orders | None = None
    wanted: Wanted | None = None
    _ordered: dict[tuple[int, str], tuple[float, Command]] = field(default_factory=dict)
    _words: deque[Word] = field(default_factory=lambda: deque(maxlen=_MOST_WORDS))
    _preflight_since: float = math.inf
    _pose_due: float = -math.inf
    _before: float = -math.inf

    def __post_init__(self) -> None:
        rate = float(self.lab.rates["setpoints"])
        count = len(self.links)
        self.supervisor = Supervisor(self.lab.limits, count)
        self.plan = Plan(self.lab.scenario, rate)
        self.times = LoopTimes(rate)
        self.pulls = Pulls([v.mass for v in self.lab.vehicles], self.lab.scenario)
        self.commanded = [0.0] * count
        self._saturated: list[float | None] = [None] * count
        self._armed_height = [math.inf] * count

    @property
    def problems(self) -> tuple[str, ...]:
        """What speaks against arming, or is wrong in flight, as of the last tick."""
        return ("nothing was looked at yet",) if self.orders is None else self.orders.problems

    def say(self, word: Word) -> None:
        """What the pilot says, for the next tick; a kill comes before all else."""
        if word is Word.KILL:
            self._words.clear()
        self._words.append(word)

    def sees(self, frame: Frame) -> None:
        """Takes in a frame of motion capture."""
        self.estimator.accept(frame)
        if self.log is not None:
            self.log.write("mocap", frame.received_time, {
                "number": frame.number,
                "captured": frame.capture_time,
                "bodies": {
                    name: [*pose.position, *pose.attitude] for name, pose in frame.bodies.items()
                },
            })  # fmt: skip

    def tick(self, now: float, word: Word | None = None) -> Orders:
        """One period of the loop.

        Args:
            now: of the clock by which motion capture is stamped, s.
            word: of the pilot; left out: the oldest that was said.
        """
        if word is None and self._words:
            word = self._words.popleft()
        for link in self.links:
            link.receive(now)
        estimate = self.estimator.at(now)
        seen = self._seen(estimate, now, word)
        before = self.supervisor.state
        orders = self.supervisor.step(seen, now)
        if orders.state is State.PREFLIGHT and before is not State.PREFLIGHT:
            self._prepare(now)
        self._learn(orders, estimate, now)
        self._carry_out(orders, estimate, now)
        self._pass_poses(estimate, now)
        for link in self.links:
            link.work(now)
        self.estimate, self.seen, self.orders = estimate, seen, orders
        if self.log is not None:
            self._write(self.log, estimate, seen, orders, now)
        return orders

    def _seen(self, estimate: Estimate, now: float, word: Word | None) -> Seen:
        standing = self._standing(estimate)
        fault = standing.fault.value if standing.quality <= Quality.SUSPECT else ""
        if not fault and self.plan.carries and not self.plan.reaches(estimate):
            fault = "bodies farther apart than their cable is long"
        vehicles = tuple(self._vehicle(k, estimate, now) for k in range(len(self.links)))
        wanted = self.wanted
        return Seen(
            vehicles,
            standing.age,
            fault,
            self._state_age(estimate),
            wanted.swing if wanted is not None else 0.0,
            wanted is not None and wanted.done,
            word,
        )

    def _standing(self, estimate: Estimate) -> Standing:
        """Of all that the present state of the flight cannot go on without."""
        if self.plan.needs_load(self.supervisor.state):
            return estimate.standing
        return worst(*(self._body(estimate, k).standing for k in range(len(self.links))))

    def _state_age(self, estimate: Estimate) -> float:
        """Of what set-points are computed from, s: holding and landing does without the load."""
        vehicles = (self._body(estimate, k).standing.age for k in range(len(self.links)))
        ending = self.supervisor.state in _ENDING
        return max(vehicles) if ending else self._standing(estimate).age

    @staticmethod
    def _body(estimate: Estimate, k: int) -> BodyState:
        return estimate.bodies[f"vehicle_{k + 1}"]

    def _vehicle(self, k: int, estimate: Estimate, now: float) -> VehicleSeen:
        link, body = self.links[k], self._body(estimate, k)
        since = self._saturated[k]
        status = link.status
        problems = list(link.parameters.problems)
        if not link.clock.is_converged:
            problems.append("clocks are not converged")
        return VehicleSeen(
            link.age(now), status.armed, link.takes_set_points, status.failsafe, status.landed,
            body.position, math.hypot(*body.velocity), tilt(body.attitude),
            0.0 if since is None else now - since,
            1.0 if math.isnan(status.charge) else status.charge,
            status.boots, tuple(problems), link.round_trip,
        )  # fmt: skip

    def _prepare(self, now: float) -> None:
        self._preflight_since = now
        for link in self.links:
            link.check_parameters(now)
            link.set_origin(now)

    def _learn(self, orders: Orders, estimate: Estimate, now: float) -> None:
        """What motion shows of thrust: the cables' pull, and alone the hover thrust."""
        elapsed = min(now - self._before, 0.1)
        self._before = now
        forces = None if self.wanted is None else self.wanted.force
        self.pulls.sees(estimate, forces, elapsed)
        for k, link in enumerate(self.links):
            body = self._body(estimate, k)
            height = body.position[2]
            if not link.status.armed:
                self._armed_height[k] = height
            if orders.state not in _ALONE or height < self._armed_height[k] + _FREE:
                continue
            if not self.pulls.slack[k] or body.standing.quality is not Quality.GOOD:
                continue
            u, _cut = link.thrust.to_command(self.commanded[k])
            link.thrust.sees_hover(u, self.pulls.needed(k, body), elapsed)

    def _carry_out(self, orders: Orders, estimate: Estimate, now: float) -> None:
        """Set-points and orders of all vehicles."""
        self.wanted = None
        if orders.may_send and any(order in _STEERED for order in orders.vehicles):
            self._steer(orders, estimate, now)
        for k, (link, order) in enumerate(zip(self.links, orders.vehicles, strict=True)):
            streamed = now - self._preflight_since >= _STREAM_FIRST
            if order is Order.WARM_UP and streamed and not link.takes_set_points:
                self._order(k, "fly", now)
            elif order is Order.ARM and not link.status.armed:
                self._order(k, "arm", now)
            elif order is Order.LAND and link.status.mode != link.peer.firmware.land_mode:
                self._order(k, "land", now)
            elif order is Order.DISARM and link.status.armed:
                self._order(k, "disarm", now)
            elif order is Order.CUT and link.status.armed:
                self._order(k, "cut", now)

    def _steer(self, orders: Orders, estimate: Estimate, now: float) -> None:
        moving = next((o for o in orders.vehicles if o in _MOVING), None)
        if Order.DISARM in orders.vehicles:
            moving = Order.DESCEND
        captured = now - self._state_age(estimate)
        if moving is not None:
            self.wanted = self.plan.step(orders.state, moving, estimate, now)
            forces = self.wanted.force
            attitudes, _thrusts = self.plan.law.set_points(forces, self.wanted.yaw)
        sent = False
        for k, (link, order) in enumerate(zip(self.links, orders.vehicles, strict=True)):
            if order not in _STEERED:
                continue
            if moving is None:
                w, _x, _y, z = self._body(estimate, k).attitude
                size = math.hypot(w, z) or 1.0
                point = SetPoint((w / size, 0.0, 0.0, z / size), 0.0, now, captured)
            else:
                a, b, c, d = attitudes[k].tolist()
                point = SetPoint((a, b, c, d), math.hypot(*forces[k].tolist()), now, captured)
            if link.send(point, now):
                sent = True
                self.commanded[k] = point.thrust
            first = self._saturated[k]
            self._saturated[k] = None if not link.saturated else now if first is None else first
        if sent:
            at = now if self.clock is None else self.clock()
            self.times.latency.add(at - captured)

    def _order(self, k: int, what: str, now: float) -> None:
        """Gives a vehicle an order, again once its answer is known and a while has passed."""
        given = self._ordered.get((k, what))
        if given is not None:
            then, command = given
            if not command.outcome or now - then < _ORDER_PERIOD:
                return
        self._ordered[k, what] = now, _COMMANDS[what](self.links[k], now)

    def _pass_poses(self, estimate: Estimate, now: float) -> None:
        if now < self._pose_due:
            return
        self._pose_due = now + 1.0 / self.lab.rates["pose"]
        odometry = self.lab.rates["pose_message"] == "odometry"
        for k, link in enumerate(self.links):
            body = self._body(estimate, k)
            if body.standing.age <= _POSE_AGE:
                # The estimate is of now, though its capture is a little older.
                link.send_pose(body.position, body.attitude, now, now, odometry=odometry)

    def _write(self, log: Log, estimate: Estimate, seen: Seen, orders: Orders, now: float) -> None:
        bodies, standing, wanted = estimate.bodies, estimate.standing, self.wanted
        log.write("estimate", now, {
            "age": standing.age,
            "quality": standing.quality.name.lower(),
            "fault": standing.fault.value,
            "bodies": {
                name: [*b.position, *b.velocity, *b.attitude, *b.rate] for name, b in bodies.items()
            },
            "swing": [c.swing for c in estimate.cables],
            "tension": self.pulls.tension,
        })  # fmt: skip
        log.write("supervisor", now, {
            "state": orders.state.value,
            "lasted": self.supervisor.lasted,
            "orders": [order.name for order in orders.vehicles],
            "may_send": orders.may_send,
            "problems": list(orders.problems),
            "word": None if seen.word is None else seen.word.value,
            "swing": seen.swing,
            "armed": [v.armed for v in seen.vehicles],
            "link_age": [v.link_age for v in seen.vehicles],
            "charge": [v.charge for v in seen.vehicles],
        })  # fmt: skip
        if wanted is not None:
            load = wanted.payload
            log.write("wanted", now, {
                "force": wanted.force.tolist(),
                "vehicle": wanted.vehicle.tolist(),
                "payload": None if load is None else load.tolist(),
                "yaw": wanted.yaw,
            })  # fmt: skip


def tilt(attitude: tuple[float, float, float, float]) -> float:
    """Of the body's z from the vertical, rad."""
    _w, x, y, _z = attitude
    return math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y))))
