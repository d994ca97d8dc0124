"""Twin autopilots refuse, lose and do what real firmware does, over real sockets."""

import pytest
from flight_rig import Station
from multilift.flight.link.firmware import ARDUPILOT, PX4
from multilift.flight.link.setpoint import SetPoint
from multilift.flight.link.vehicle import VehicleLink
from pymavlink.dialects.v20 import common as mavlink


@pytest.fixture
def station(request):
    made = Station(**getattr(request, "param", {}))
    yield made
    made.close()


ARDU = [{"firmware": "ardupilot"}]


def test_a_flight_from_ground_to_ground(station):
    station.take_off()
    assert all(link.clock.is_converged for link in station.links)
    assert all(link.takes_set_points for link in station.links)
    assert not any(sum(link.guard.dropped.values()) for link in station.links)
    assert all(link.status.landed is False for link in station.links)
    where = [link.status.position for link in station.links]
    # A float32 of metres, and 33 ms at the speed of hovering.
    for said, true in zip(where, station.world.vehicle, strict=True):
        assert said == pytest.approx(tuple(true), abs=0.02)
    assert set(station.ask(VehicleLink.land_mode)) == {"accepted"}
    assert station.run(15.0, lambda: not any(link.status.armed for link in station.links))
    assert station.world.standing.all()
    assert station.world.status == "running"


def test_parameters_are_found_wrong_and_set(station):
    pilot, link = station.pilots[0], station.links[0]
    assert pilot.parameters["COM_OBL_RC_ACT"] == 0
    station.prepare()
    assert not link.parameters.problems
    assert pilot.parameters["COM_OBL_RC_ACT"] == 4
    assert pilot.parameters["COM_OF_LOSS_T"] == 0.5


def test_offboard_is_refused_before_set_points_come(station):
    station.streams = False
    station.prepare()
    assert set(station.ask(VehicleLink.fly_mode)) == {"rejected for now"}
    assert "Offboard denied: no set-points" in station.words()
    station.streams = True
    station.run(1.0)
    assert set(station.ask(VehicleLink.fly_mode)) == {"accepted"}


def test_arming_is_refused_without_mode_or_vision(station):
    station.prepare()
    assert set(station.ask(VehicleLink.arm)) == {"rejected for now"}
    assert "Arming denied: mode" in station.words()
    station.ask(VehicleLink.fly_mode)
    station.captures = False
    station.run(1.5)
    assert set(station.ask(VehicleLink.arm)) == {"rejected for now"}
    assert "Arming denied: position estimate" in station.words()
    assert not any(p.armed for p in station.pilots)


@pytest.mark.parametrize("station", ARDU, indirect=True)
def test_ardupilot_wants_an_origin_and_thrust_to_mean_thrust(station):
    for link in station.links:
        link.check_parameters(station.now)
    station.run(5.0)
    assert set(station.ask(VehicleLink.fly_mode)) == {"rejected for now"}
    for link in station.links:
        link.set_origin(station.now)
    station.run(1.0)
    assert set(station.ask(VehicleLink.fly_mode)) == {"accepted"}
    pilot = station.pilots[0]
    pilot.parameters["GUID_OPTIONS"] = 0.0
    before = pilot.ignored
    station.run(0.5)
    assert pilot.ignored > before


@pytest.mark.parametrize("station", ARDU, indirect=True)
def test_ardupilot_flies_and_levels_where_it_is_when_set_points_stop(station):
    station.take_off()
    station.streams = False
    station.run(6.0)
    assert all(link.takes_set_points for link in station.links)
    assert min(station.heights()) > 0.3


@pytest.mark.parametrize("action", [4, 5])
def test_px4_lands_when_set_points_stop(station, action):
    station.take_off()
    for pilot in station.pilots:
        pilot.parameters["COM_OBL_RC_ACT"] = float(action)
    station.streams = False
    stopped = station.now
    assert station.run(2.0, lambda: station.pilots[0].mode == PX4.land_mode)
    # COM_OF_LOSS_T, and one period of the station.
    assert station.now - stopped == pytest.approx(0.5, abs=0.02)
    assert station.run(15.0, lambda: not any(p.armed for p in station.pilots))
    assert station.world.standing.all()
    assert "Offboard control lost" in station.words()
    station.run(1.0)
    assert "Disarmed by landing" in station.words()


def test_the_last_set_point_said_again_keeps_it_up(station):
    # What the flight program must never do: the autopilot cannot notice.
    station.take_off()
    station.streams = False
    for _ in range(1000):
        station.step()
        for link in station.links:
            link._mav.set_attitude_target_send(
                0, link.peer.system, 1, 7, [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0, 0.5
            )
    assert {p.mode for p in station.pilots} == {PX4.fly_mode}


def test_without_the_ground_station_it_lands(station):
    station.take_off()
    station.works = False  # set-points go on: what feeds them may outlive the rest
    assert station.run(10.0, lambda: {p.mode for p in station.pilots} == {PX4.land_mode})


def test_without_vision_it_still_comes_down(station):
    station.take_off()
    station.captures = station.streams = False
    assert station.run(20.0, lambda: not any(p.armed for p in station.pilots))
    assert station.world.standing.all()


def test_nobody_disarms_it_in_the_air_without_force(station):
    station.take_off()
    assert set(station.ask(VehicleLink.disarm)) == {"rejected for now"}
    cut = station.ask(lambda link, now: link.disarm(now, cut=True))
    assert set(cut) == {"accepted"}
    assert not any(p.armed for p in station.pilots)


def test_what_is_for_another_is_not_for_it(station):
    station.prepare()
    first = station.links[0]
    pilot = station.pilots[0]
    mode, store = pilot.mode, dict(pilot.parameters)
    for system, component in ((2, 1), (0, 0), (1, 0), (0, 1), (1, 2)):
        first._mav.command_long_send(system, component, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, 4, 6,
                                     0, 0, 0, 0)  # fmt: skip
        first._mav.param_set_send(system, component, b"COM_OF_LOSS_T", 9.0, 9)
        first._mav.set_attitude_target_send(0, system, component, 7, [1, 0, 0, 0], 0, 0, 0, 0.9)
    ignored = pilot.ignored
    station.streams = False
    station.run(0.1)
    assert pilot.ignored == ignored + 5
    assert (pilot.mode, pilot.parameters) == (mode, store)
    assert pilot._wanted[1] == 0.0


@pytest.mark.parametrize("mask", [0, 1, 64, 128, 199])
def test_a_set_point_of_parts_is_no_proof_of_life(station, mask):
    station.take_off()
    station.streams = False
    for _ in range(300):
        station.step()
        for link in station.links:
            link._mav.set_attitude_target_send(
                0, link.peer.system, 1, mask, [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0, 0.5
            )
    assert {p.mode for p in station.pilots} == {PX4.land_mode}


@pytest.mark.parametrize("station", [{"key": bytes(range(32))}], indirect=True)
def test_signed_all_the_way(station):
    station.take_off()
    assert all(m.guard.dropped["unsigned"] == 0 for m in station.links)
    # An unsigned stranger on the right port with the right ids.
    stranger = Station()
    stranger.links[0].transport = station.links[0].transport
    mode = station.pilots[0].mode
    stranger.links[0].land_mode(station.now)
    stranger.links[0].work(station.now)
    station.run(0.1)
    assert station.pilots[0].mode == mode
    assert station.pilots[0]._guard.dropped["unsigned"] > 0
    stranger.close()


def test_a_stale_state_stops_the_stream_and_the_autopilot_lands(station):
    station.take_off()
    frozen = station.now
    station.streams = False
    for _ in range(500):
        station.step()
        for k, link in enumerate(station.links):
            link.send(SetPoint((1.0, 0.0, 0.0, 0.0), station.force(k), station.now, frozen),
                      station.now)  # fmt: skip
    assert {p.mode for p in station.pilots} == {PX4.land_mode}
    assert station.links[0].freshness.refused["stale"] > 0


def test_every_firmwares_settings_have_a_factory_value():
    for firmware in (PX4, ARDUPILOT):
        station = Station(firmware.name)
        wanted = {s.name for s in firmware.settings} | {firmware.system_parameter}
        assert set(station.pilots[0].parameters) == wanted
        station.close()
