"""The live view shows what a pilot must see, and takes orders from no vehicle."""

import io

import pytest
from flight_snapshots import snapshot, vehicle
from multilift.flight.screen import screen
from multilift.flight.supervisor import State
from rich.console import Console


def drawn(shown, asked="", width=120):
    console = Console(width=width, file=io.StringIO(), color_system=None)
    console.print(screen(shown, asked))
    return console.file.getvalue()


def test_everything_a_pilot_must_see_is_on_it():
    text = drawn(snapshot())
    parts = ("Two craft and a bar", "exp1_1_quadrotors", "twin", " fly ", "vehicle_1",
             "vehicle_2", "ARMED", "87 %", "15.4 V", "1.9 N", "6.3 °", "45.8 °", "good",
             "100 Hz", "2 of 3140", "19.0", "one.mcap", "land all",
             "✗ vehicle 2: level")  # fmt: skip
    for part in parts:
        assert part in text, part


def test_hardware_is_called_that():
    assert "HARDWARE" in drawn(snapshot(twin=False))


def test_only_what_may_be_said_is_offered():
    assert "hold" not in drawn(snapshot(words=("start",), margins=())).splitlines()[-2]


def test_a_question_takes_the_place_of_the_keys():
    text = drawn(snapshot(), "Stop the motors?")
    assert "Stop the motors?" in text
    assert "land all" not in text


@pytest.mark.parametrize("state", list(State))
@pytest.mark.parametrize("width", [60, 80, 200])
def test_every_state_fits_every_width(state, width):
    text = drawn(snapshot(state=state.value, checks=(), problems=("[bold]x[/] " * 40,)), "", width)
    assert max(map(len, text.splitlines())) <= width
    assert state.value in text or width == 60


def test_what_vehicles_say_is_text_and_no_markup():
    said = vehicle(0, said=("[bold red]gone[/]",))
    assert "[bold red]gone[/]" in drawn(snapshot(checks=(), vehicles=(said, vehicle(1))))
