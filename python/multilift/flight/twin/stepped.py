"""A flight without clocks: plant, cameras, autopilots and ground station in step, in one process.

Everything passes the same bytes as between processes: MAVLink over sockets, Qualisys' packets
through the maker's decoder. A datagram on loopback is in the receiver's buffer when ``sendto``
returns, so that a flight is the same every time and takes as long as it must, not as it would.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Any

from multilift.errors import MissingExtraError
from multilift.flight.estimate.scene import PAYLOAD, estimator_for, tuning_for
from multilift.flight.lab import Lab
from multilift.flight.link.address import Address
from multilift.flight.link.firmware import BY_NAME
from multilift.flight.link.open import link_to
from multilift.flight.link.udp import Udp
from multilift.flight.log import Log
from multilift.flight.mocap import qualisys, rt_protocol
from multilift.flight.mocap.settings import Settings
from multilift.flight.station import Station
from multilift.flight.supervisor import State, Word
from multilift.flight.twin.autopilot import TwinAutopilot
from multilift.flight.twin.cameras import Cameras, CaptureFault
from multilift.flight.twin.rig import Rig
from multilift.flight.twin.start import plant_of
from multilift.flight.twin.wire import Impaired, Radio
from multilift.models.spatial import SpatialWorld

#: Where the clock of everyone begins, s, and the time of day then.
START = 1000.0
_UNIX = 1.7e9

#: Between two looks of the autopilots, s: a whole part of a station's and the cameras' periods.
PERIOD = 0.005

#: The packet's head, which the maker's decoder does not want.
_HEAD = 8


@dataclass
class SteppedFlight:
    """A lab's twin, stepped.

    Attributes:
        lab: what there is.
        seed: of radios and cameras.
        capture_faults: what goes wrong with motion capture, by seconds of flight.
        plant: changes of the plant against what the station believes, by scenario keys.
        log: takes everything in and out, and what is true; None for none.
        station_lives: whether the ground station does anything.
        vehicle_lives: of each vehicle, whether its autopilot does anything.
    """

    lab: Lab
    seed: int = 1
    capture_faults: Sequence[CaptureFault] = ()
    plant: dict[str, Any] = field(default_factory=dict)
    log: Log | None = None
    station_lives: bool = True
    vehicle_lives: list[bool] = field(default_factory=list)

    def __post_init__(self) -> None:
        try:
            from qtm_rt.packet import QRTPacket  # noqa: PLC0415
        except ImportError:
            raise MissingExtraError("qtm-rt", "fly", "motion capture") from None
        self._decode = QRTPacket
        lab, flown = self.lab, self.lab.scenario
        dice = Random(self.seed)
        link = flown.values["link"]
        radio = self.usual_radio = Radio(float(link["delay"]), float(link["jitter"]))
        pilots, links, self.radios, self._sockets = [], [], [], []
        for k, vehicle in enumerate(lab.vehicles):
            here = Udp(Address(True, "127.0.0.1", 0))
            there = Udp(Address(False, "127.0.0.1", here.port))
            self._sockets += [here, there]
            air = Impaired(there, radio, lambda: self.now, Random(dice.getrandbits(64)))
            self.radios.append(air)
            links.append(link_to(lab, k, here, None, _UNIX, self._tap(k)))
            pilots.append(TwinAutopilot(
                vehicle.system, int(lab.security["system"]), BY_NAME[vehicle.firmware], air,
                vehicle.hover_thrust, unix=_UNIX,
            ))  # fmt: skip
        world = SpatialWorld(plant_of(flown).with_values(self.plant))
        self.vehicle_lives = [True] * flown.count
        self.rig = Rig(world, pilots, START, PERIOD)
        self.cameras = Cameras(flown, dice.getrandbits(64), tuple(self.capture_faults))
        names = [v.body for v in lab.vehicles]
        self._settings = Settings("qualisys", {
            **{f"vehicle_{k + 1}": name for k, name in enumerate(names)},
            PAYLOAD: str(lab.motion_capture["payload"]),
        })  # fmt: skip
        self._places = {name: k for k, name in enumerate(self._settings.bodies)}
        self.station = Station(lab, links, estimator_for(flown, tuning_for(flown)), self.log)
        self._next_tick = self._next_look = START
        self.separation = math.inf

    @property
    def now(self) -> float:
        """The clock of all, s."""
        return self.rig.now

    @property
    def time(self) -> float:
        """Since the start, s."""
        return self.rig.now - START

    @property
    def world(self) -> SpatialWorld:
        """The plant."""
        return self.rig.world

    def step(self, word: Word | None = None) -> None:
        """One period of the rig, with what the station and the cameras do in it."""
        now = self.now + 1e-9
        if now >= self._next_look:
            self._next_look += self.cameras.period
            self.cameras.look(self.world, self.time)
        for capture in self.cameras.due(self.time):
            packet = self._decode(rt_protocol.data_packet(capture, ("6dres",))[_HEAD:])
            frame = qualisys.frame_of(packet, self._places, self._settings, self.now)
            self.station.sees(frame)
        if now >= self._next_tick:
            self._next_tick += 1.0 / float(self.lab.rates["setpoints"])
            if self.station_lives:
                self.station.tick(self.now, word)
            if self.log is not None:
                self._write_truth(self.log)
        self.rig.step(self.vehicle_lives)
        self.separation = min(self.separation, self._separation())

    def run(
        self, seconds: float, until: Callable[[], bool] = lambda: False, word: Word | None = None
    ) -> bool:
        """Lets time pass until something is so.

        Args:
            seconds: at most.
            until: what.
            word: said by the pilot at the start.

        Returns:
            Whether it became so.
        """
        end = self.time + seconds
        if word is not None:
            self.station.say(word)
        while self.time < end and self.world.status == "running":
            if until():
                return True
            self.step()
        return until()

    def prepare(self, patience: float = 20.0) -> bool:
        """From the start to where the pilot may say go; whether it came to that."""
        return self.run(
            patience,
            lambda: self.station.supervisor.state is State.PREFLIGHT and not self.station.problems,
            Word.START,
        )

    def kill_vehicle(self, k: int) -> None:
        """Ends an autopilot: it says and does nothing more, and its motors stand still."""
        self.vehicle_lives[k] = False
        self.rig.autopilots[k].armed = False

    def close(self) -> None:
        """Gives the sockets back."""
        for end in self._sockets:
            end.close()

    def _separation(self) -> float:
        places = self.world.vehicle.tolist()
        return min((math.dist(a, b) for k, a in enumerate(places) for b in places[:k]),
                   default=math.inf)  # fmt: skip

    def _tap(self, k: int) -> Callable[[str, float, bytes], None] | None:
        log = self.log
        if log is None:
            return None
        return lambda way, now, data: log.raw(f"{way}/vehicle_{k + 1}", now, data)

    def _write_truth(self, log: Log) -> None:
        world = self.world
        log.write("truth", self.now, {
            "vehicle": world.vehicle.tolist(),
            "vehicle_attitude": world.vehicle_attitude.tolist(),
            "payload": world.payload.tolist(),
            "payload_attitude": world.payload_attitude.tolist(),
            "tension": world.tension.tolist(),
            "taut": world.taut.tolist(),
            "standing": world.standing.tolist(),
        })  # fmt: skip
