"""A ground station in miniature and a rig of twins, joined by real sockets, in simulated time.

A datagram on loopback is in the receiver's buffer when ``sendto`` returns, so that every test runs
the same each time and as fast as it can.
"""

import math
import tempfile
from pathlib import Path

from multilift.flight import lab
from multilift.flight.link.address import Address
from multilift.flight.link.firmware import ARDUPILOT, BY_NAME
from multilift.flight.link.setpoint import Freshness, SetPoint
from multilift.flight.link.thrust import ThrustMap
from multilift.flight.link.udp import Udp
from multilift.flight.link.vehicle import Peer, VehicleLink
from multilift.flight.twin.autopilot import TwinAutopilot
from multilift.flight.twin.rig import PERIOD, Rig
from multilift.models.spatial import SpatialWorld

START = 1000.0
UNIX = 1.7e9


class Station:
    """Links to all vehicles of a lab's twin; each of its habits can be left out."""

    def __init__(self, firmware="px4", scenario="takeoff_to_setdown", key=None):
        self.lab = lab.parse({"scenario": scenario}, "lab", Path(tempfile.gettempdir()))
        self.links, pilots, self.sockets = [], [], []
        kind = BY_NAME[firmware]
        own = self.lab.security["system"]
        for v in self.lab.vehicles:
            here = Udp(Address(True, "127.0.0.1", 0))
            there = Udp(Address(False, "127.0.0.1", here.port))
            self.sockets += [here, there]
            weight = v.mass * 9.8
            self.links.append(VehicleLink(
                Peer(v.system, 1, own, kind, key), here,
                ThrustMap(weight, v.hover_thrust, v.thrust_curve), Freshness(0.1), True, UNIX,
            ))  # fmt: skip
            pilots.append(TwinAutopilot(v.system, own, kind, there, v.hover_thrust, key, UNIX))
        self.rig = Rig(SpatialWorld(self.lab.scenario), pilots, START)
        self.works = self.streams = self.captures = True
        self.height = 0.6
        self.thrust = 0.0
        self._beat = 0

    @property
    def now(self):
        return self.rig.now

    @property
    def world(self):
        return self.rig.world

    @property
    def pilots(self):
        return self.rig.autopilots

    def step(self):
        """One period of the rig, and of the station every third time: about 80 Hz."""
        self._beat += 1
        if self._beat % 3 == 0:
            self.tick()
        self.rig.step()

    def tick(self):
        now = self.now
        for k, link in enumerate(self.links):
            link.receive(now)
            if self.works:
                link.work(now)
            if self.captures and self._beat % 6 == 0:
                body = self.rig.body(k)
                link.send_pose(body.position, body.attitude, now, now)
            if self.streams:
                link.send(SetPoint((1.0, 0.0, 0.0, 0.0), self.force(k), now, now), now)

    def force(self, k):
        """Up to a height, straight; nothing before it is armed."""
        if not self.links[k].status.armed:
            return 0.0
        body = self.rig.body(k)
        error, climb = self.height - body.position[2], body.velocity[2]
        return self.lab.vehicles[k].mass * max(9.8 + 6.0 * error - 5.0 * climb, 0.0)

    def run(self, seconds, until=lambda: False):
        """Lets time pass until something is so; whether it became so."""
        for _ in range(round(seconds / PERIOD)):
            if until():
                return True
            self.step()
        return until()

    def ask(self, what):
        """Gives every link a command; the outcomes, once all are known."""
        commands = [what(link, self.now) for link in self.links]
        assert self.run(5.0, lambda: all(c.outcome for c in commands))
        return [c.outcome for c in commands]

    def prepare(self):
        """Parameters and origin, then time for clocks and estimates to settle."""
        for link in self.links:
            link.check_parameters(self.now)
        assert self.run(10.0, lambda: all(link.parameters.is_done for link in self.links))
        if self.links[0].peer.firmware is ARDUPILOT:
            for link in self.links:
                link.set_origin(self.now)
        self.run(1.5)

    def take_off(self):
        """From the ground to steady flight."""
        self.prepare()
        assert set(self.ask(VehicleLink.fly_mode)) == {"accepted"}
        assert set(self.ask(VehicleLink.arm)) == {"accepted"}
        self.run(4.0)
        assert max(abs(z - self.height) for z in self.heights()) < 0.2, self.heights()

    def heights(self):
        return self.world.vehicle[:, 2].tolist()

    def separation(self):
        places = self.world.vehicle.tolist()
        return min(math.dist(a, b) for k, a in enumerate(places) for b in places[:k])

    def words(self):
        return [t.text for link in self.links for t in link.texts.said]

    def close(self):
        for end in self.sockets:
            end.close()
