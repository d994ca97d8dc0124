"""MAVSDK, written by others, takes our twin autopilot for a vehicle, and its refusals for such."""

import json
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from multilift.flight import lab
from multilift.flight.link.address import Address
from multilift.flight.link.firmware import PX4
from multilift.flight.link.udp import Udp
from multilift.flight.twin.autopilot import TwinAutopilot
from multilift.flight.twin.rig import PERIOD, Rig
from multilift.models.spatial import SpatialWorld

pytest.importorskip("mavsdk", reason="mavsdk is not installed (multilift[test])")
PILOT = Path(__file__).with_name("mavsdk_pilot.py")


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture(scope="module")
def flight():
    """What the pilot said, the autopilot that it flew, and how high that was."""
    made = lab.parse({"scenario": "bar_from_floor"}, "lab", Path(tempfile.gettempdir()))
    own, port = made.security["system"], free_port()
    ends = [Udp(Address(False, "127.0.0.1", port if k == 0 else free_port()))
            for k in range(len(made.vehicles))]  # fmt: skip
    pilots = [TwinAutopilot(v.system, own, PX4, end, v.hover_thrust)
              for v, end in zip(made.vehicles, ends, strict=True)]  # fmt: skip
    rig = Rig(SpatialWorld(made.scenario), pilots)
    ground = highest = float(rig.world.vehicle[0, 2])
    command = [sys.executable, PILOT, str(port), str(own)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        said = [json.loads(process.stdout.readline())]
        due = time.monotonic()
        while process.poll() is None:
            rig.step()
            highest = max(highest, float(rig.world.vehicle[0, 2]))
            # MAVSDK keeps real time: the rig is never ahead of it.
            due = max(due + PERIOD, time.monotonic() - PERIOD)
            time.sleep(max(due - time.monotonic(), 0.0))
        said += [json.loads(line) for line in process.stdout]
    for end in ends:
        end.close()
    outcomes = {}
    for line in said:
        outcomes.setdefault(line["attempt"], []).append(line["outcome"])
    return outcomes, said, pilots, highest - ground


def test_it_is_discovered_as_what_it_is(flight):
    _outcomes, said, pilots, _rise = flight
    told = next(line for line in said if line["attempt"] == "discover")
    assert (told["system"], told["autopilot"]) == (pilots[0].system, "PX4")


def test_what_it_refuses_is_seen_as_refused(flight):
    outcomes = flight[0]
    for name in ("arm blind", "arm without mode"):
        assert outcomes[name] == ["COMMAND_DENIED"], name
    assert outcomes["offboard without set-points"] == ["NO_SETPOINT_SET"]  # MAVSDK itself
    assert outcomes["disarm in the air"][0].startswith("COMMAND_DENIED")


def test_it_is_armed_flies_and_lands(flight):
    outcomes, _said, pilots, rise = flight
    for name in ("see", "arm", "armed", "climb", "land", "landed"):
        assert outcomes.get(name) == ["SUCCESS"], (name, outcomes)
    assert outcomes["offboard"][-1] == "SUCCESS"
    assert set(outcomes["offboard"][:-1]) <= {"COMMAND_DENIED"}
    assert rise > 0.2
    assert not pilots[0].armed
    assert pilots[0].mode == PX4.land_mode
    assert not any(p.armed or p._station_at > 0 for p in pilots[1:])
