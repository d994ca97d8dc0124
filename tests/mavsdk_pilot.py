"""Run by test_flight_mavsdk: MAVSDK flies one vehicle and says in JSON what came of each attempt.

``python mavsdk_pilot.py PORT SYSTEM``: listens on a port of this machine as the ground station with
that id.
"""

import json
import sys
import threading
import time

from mavsdk import Configuration, Mavsdk
from mavsdk.exceptions import MavsdkError
from mavsdk.plugins.action import Action
from mavsdk.plugins.mocap import Mocap
from mavsdk.plugins.mocap.mocap import AngleBody, Covariance, PositionBody, VisionPositionEstimate
from mavsdk.plugins.offboard import Offboard
from mavsdk.plugins.offboard.offboard import Attitude
from mavsdk.plugins.telemetry import Telemetry

#: MAV_COMP_ID_MISSIONPLANNER, by which autopilots know a ground station.
COMPONENT = 190
#: How long anything is waited for, s; only a failure takes so long.
PATIENCE = 30.0


def tell(**what):
    print(json.dumps(what), flush=True)


def attempt(name, what):
    """What came of an attempt."""
    try:
        what()
    except MavsdkError as error:
        tell(attempt=name, outcome=error.result.name)
        return False
    tell(attempt=name, outcome="SUCCESS")
    return True


def until(so, name):
    """Waits until something is so."""
    end = time.monotonic() + PATIENCE
    while not so():
        if time.monotonic() > end:
            tell(attempt=name, outcome="never")
            sys.exit(1)
        time.sleep(0.02)
    tell(attempt=name, outcome="SUCCESS")


def capture(mocap, stop):
    """Poses as motion capture would tell them, of a vehicle over its place."""
    unknown = Covariance([float("nan")])
    while not stop.wait(0.025):
        pose = VisionPositionEstimate(
            int(time.monotonic() * 1e6), PositionBody(0.0, 0.0, 0.0), AngleBody(0.0, 0.0, 0.0),
            unknown, 0,
        )  # fmt: skip
        mocap.set_vision_position_estimate(pose)


def main():
    port, own = sys.argv[1:]
    sdk = Mavsdk(Configuration.create_manual(int(own), COMPONENT, True))
    sdk.add_any_connection(f"udpin://127.0.0.1:{port}")
    tell(attempt="listen", outcome="SUCCESS")
    system = sdk.first_autopilot(PATIENCE)
    if system is None:
        tell(attempt="discover", outcome="never")
        sys.exit(1)
    tell(attempt="discover", outcome="SUCCESS", system=system.get_system_id(),
         autopilot=system.autopilot_type().name)  # fmt: skip
    action, offboard, telemetry = Action(system), Offboard(system), Telemetry(system)
    attempt("arm blind", action.arm)
    attempt("offboard without set-points", offboard.start)
    stop = threading.Event()
    camera = threading.Thread(target=capture, args=(Mocap(system), stop))
    camera.start()
    until(lambda: telemetry.position_velocity_ned().position.down_m != 0.0, "see")
    attempt("arm without mode", action.arm)
    offboard.set_attitude(Attitude(0.0, 0.0, 0.0, 0.0))
    # What comes first is refused: the mode is taken once set-points have come for a while.
    until(lambda: attempt("offboard", offboard.start), "offboard at last")
    attempt("arm", action.arm)
    until(telemetry.armed, "armed")
    start = -telemetry.position_velocity_ned().position.down_m

    def climbs():
        told = telemetry.position_velocity_ned()
        height, climb = -told.position.down_m - start, -told.velocity.down_m_s
        thrust = 0.5 + 0.4 * (0.3 - height) - 0.3 * climb
        offboard.set_attitude(Attitude(0.0, 0.0, 0.0, min(max(thrust, 0.0), 0.9)))
        return height > 0.2

    until(climbs, "climb")
    attempt("disarm in the air", action.disarm)
    attempt("land", action.land)
    until(lambda: not telemetry.armed(), "landed")
    stop.set()
    camera.join()
    sdk.destroy()


main()
