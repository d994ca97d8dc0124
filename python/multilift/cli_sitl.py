"""The command ``multilift sitl``."""

from __future__ import annotations

import math
import signal
import tempfile
from contextlib import ExitStack, closing
from pathlib import Path
from types import FrameType
from typing import Annotated, NoReturn

import typer
from rich.console import Console
from rich.markup import escape

from multilift.errors import ScenarioError
from multilift.options import SetOption, load_changed

_out = Console()


def sitl(
    scenario: Annotated[
        str, typer.Argument(help="A spatial scenario on the ground: a file or a shipped name.")
    ] = "bar_from_floor",
    px4: Annotated[
        Path | None, typer.Option(help="PX4: its sources, build folder or program.")
    ] = None,
    ardupilot: Annotated[
        Path | None, typer.Option(help="ArduPilot: its sources or the program arducopter.")
    ] = None,
    duration: Annotated[
        float | None, typer.Option(min=0.0, help="End after so many seconds of flight.")
    ] = None,
    speed: Annotated[
        float, typer.Option(min=0.0, help="Times real time; 0: as fast as all can.")
    ] = 1.0,
    vision: Annotated[
        bool, typer.Option(help="Send motion capture's poses; leave that to `multilift fly`: no.")
    ] = True,
    logs: Annotated[
        Path | None, typer.Option(help="Keep the firmwares' folders and output here.")
    ] = None,
    first: Annotated[
        int, typer.Option(min=0, max=200, help="Instance of vehicle_1; shifts ports and ids.")
    ] = 0,
    patience: Annotated[
        float, typer.Option(min=0.1, help="How long a firmware may be silent, s.")
    ] = 30.0,
    changes: SetOption = None,
) -> None:
    """Fly a scenario's vehicles by real firmware, one process each, in lockstep with the model."""
    from multilift.flight.sitl import firmware as firmwares  # noqa: PLC0415 - the shorter start
    from multilift.flight.sitl.lockstep import Lockstep  # noqa: PLC0415
    from multilift.flight.sitl.physics import Physics  # noqa: PLC0415
    from multilift.flight.sitl.sensors import Capture, Sensors  # noqa: PLC0415

    if (px4 is None) == (ardupilot is None):
        raise ScenarioError(
            "needs one firmware", where="multilift sitl",
            advice="give --px4 PATH or --ardupilot PATH",
        )  # fmt: skip
    flown = load_changed(scenario, changes)
    physics = Physics(flown)
    firmware: firmwares.Firmware
    if px4 is not None:
        firmware = firmwares.Px4(px4, first)
    else:
        assert ardupilot is not None
        firmware = firmwares.ArduPilot(ardupilot, first)
    capture = Capture() if vision else None
    seed = int(flown["simulation.seed"])
    # Ended by a signal, too, we end what we started.
    signal.signal(signal.SIGTERM, _stop)
    with ExitStack() as stack:
        folder = logs or Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="sitl-")))
        links = [stack.enter_context(closing(firmware.link(i))) for i in range(physics.count)]
        processes = stack.enter_context(firmwares.Processes(firmware, flown, folder))
        lockstep = Lockstep(
            physics,
            [Sensors(seed, i, capture=capture) for i in range(physics.count)],
            links,
            patience=patience,
            speed=speed or None,
            watch=processes.check,
        )
        _out.print(f"[bold]{escape(flown.title)}[/], {physics.count} x {firmware.name}")
        for i, link in enumerate(links):
            port = firmwares.GROUND_STATION_PORT + first + i
            _out.print(f"{link.name}: system id {first + i + 1}, MAVLink to UDP port {port}")
        lockstep.connect()
        try:
            _out.print("All have been heard; end with Ctrl-C.")
            lockstep.run(math.inf if duration is None else duration)
        finally:
            done = lockstep.progress
            _out.print(
                f"{done.simulated:.1f} s flown in {done.wall:.1f} s, {done.speed:.2f} times real "
                f"time, {done.steps} steps"
            )


def _stop(number: int, frame: FrameType | None) -> NoReturn:
    raise KeyboardInterrupt
