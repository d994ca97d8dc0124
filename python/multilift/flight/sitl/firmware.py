"""Processes of real firmware: how they are started, where they write, and that they end."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from multilift.flight.sitl import ardupilot_json, geodesy, parameters, px4_hil, vision
from multilift.flight.sitl.autopilot import LOOPBACK, Autopilot, SitlError
from multilift.scenario import Scenario

#: Where a ground station hears vehicle 1, by UDP; the next vehicles at the next ports. PX4's own
#: convention for offboard control, and ours for ArduPilot.
GROUND_STATION_PORT = 14540

#: PX4's airframe without a simulator of its own: 10016_none_iris, rotors placed by parameters.
_PX4_AIRFRAME = 10016
#: How long a process may take to end when it is asked to, s.
_GRACE = 3.0
_LAST_LINES = 8


@dataclass(frozen=True)
class Command:
    """How one process is started.

    Attributes:
        arguments: the program first.
        environment: what is added to ours.
        files: to write into its folder first, by name.
    """

    arguments: tuple[str, ...]
    environment: Mapping[str, str]
    files: Mapping[str, str]


class Px4:
    """PX4, built for the simulator interface (px4_sitl_default)."""

    name = "PX4"

    def __init__(self, path: Path, first: int = 0) -> None:
        """Finds the program.

        Args:
            path: of PX4's sources, of their build folder, or of the program px4 itself.
            first: instance of vehicle_1, which shifts all ports and system ids.

        Raises:
            SitlError: where there is none.
        """
        self.first = first
        candidates = (path, path / "bin/px4", path / "build/px4_sitl_default/bin/px4")
        self.program = _program(self.name, path, candidates)
        self._etc = self.program.parents[1] / "etc"
        if not self._etc.is_dir():
            raise SitlError(
                f"PX4: beside {self.program.parent} there is no folder etc\n"
                "  what to do: name the build folder that make px4_sitl_default leaves"
            )

    def command(self, scenario: Scenario, index: int) -> Command:
        """How the process of vehicle ``index`` is started."""
        instance = self.first + index
        values = {
            **parameters.shipped("px4"),
            **parameters.of_vehicle("px4", scenario, index),
            "MAV_SYS_ID": instance + 1,
        }
        return Command(
            (str(self.program), "-i", str(instance), "-d", str(self._etc)),
            {
                "PX4_SIMULATOR": "none",
                "PX4_SIM_MODEL": "none_iris",
                "PX4_SYS_AUTOSTART": str(_PX4_AIRFRAME),
                **{f"PX4_PARAM_{key}": f"{value:.9g}" for key, value in values.items()},
            },
            {},
        )

    def link(self, index: int) -> Autopilot:
        """The physics' end of vehicle ``index``."""
        return px4_hil.Px4Link(index, port=px4_hil.FIRST_PORT + self.first + index)


class ArduPilot:
    """ArduCopter, built for SITL."""

    name = "ArduPilot"

    def __init__(self, path: Path, first: int = 0) -> None:
        """Finds the program.

        Args:
            path: of ArduPilot's sources or of the program arducopter itself.
            first: instance of vehicle_1, which shifts all ports and system ids.

        Raises:
            SitlError: where there is none.
        """
        self.first = first
        candidates = (path, path / "arducopter", path / "build/sitl/bin/arducopter")
        self.program = _program(self.name, path, candidates)

    def command(self, scenario: Scenario, index: int) -> Command:
        """How the process of vehicle ``index`` is started."""
        instance = self.first + index
        values = {
            **parameters.shipped("ardupilot"),
            **parameters.of_vehicle("ardupilot", scenario, index),
        }
        home = geodesy.HOME
        return Command(
            (
                str(self.program),
                "--model", f"JSON:{LOOPBACK}",
                "--instance", str(instance),
                "--sysid", str(instance + 1),
                "--home", f"{home.latitude},{home.longitude},{home.altitude},0",
                "--defaults", "defaults.parm",
                "--serial0", f"udpclient:{LOOPBACK}:{GROUND_STATION_PORT + instance}",
                "--serial1", f"udpclient:{LOOPBACK}:{vision.FIRST_PORT + instance}",
                # The physics sets the pace.
                "--speedup", "1000",
                "--wipe",
            ),
            {},
            {"defaults.parm": "".join(f"{key} {value:.9g}\n" for key, value in values.items())},
        )  # fmt: skip

    def link(self, index: int) -> Autopilot:
        """The physics' end of vehicle ``index``."""
        instance = self.first + index
        port = ardupilot_json.FIRST_PORT + ardupilot_json.PORT_STEP * instance
        return ardupilot_json.ArduPilotLink(index, port=port, vision=vision.VisionPort(instance))


Firmware = Px4 | ArduPilot


def _program(name: str, path: Path, candidates: Sequence[Path]) -> Path:
    for candidate in candidates:
        if candidate.is_file() and os.access(candidate, os.X_OK):
            return candidate.resolve()
    raise SitlError(
        f"{name}: no program at {path}\n  permitted: "
        + ", ".join(str(candidate) for candidate in candidates)
    )


class Processes:
    """The processes of all vehicles, which end with the block, however that ends.

    ::

        with Processes(Px4(path), scenario, folder) as processes:
            ...
            processes.check()

    Each runs in a folder of its own below the given one, ``vehicle_1``, ..., and writes to
    ``output.txt`` there.
    """

    def __init__(self, firmware: Firmware, scenario: Scenario, folder: Path) -> None:
        """Notes what to start; nothing runs yet."""
        self._commands = [firmware.command(scenario, i) for i in range(scenario["plant.vehicles"])]
        self._folders = [folder / f"vehicle_{i + 1}" for i in range(len(self._commands))]
        self._running: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> Processes:
        """Starts them.

        Raises:
            SitlError: for a process that cannot be started.
        """
        try:
            for command, folder in zip(self._commands, self._folders, strict=True):
                self._running.append(_start(command, folder))
        except BaseException:
            self.end()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Ends them."""
        self.end()

    def check(self) -> None:
        """Sees that all run.

        Raises:
            SitlError: naming the first that does not, and the last that it wrote.
        """
        for i, process in enumerate(self._running):
            if process.poll() is not None:
                output = self._folders[i] / "output.txt"
                lines = output.read_text(encoding="utf-8", errors="replace").splitlines()
                raise SitlError(
                    f"vehicle_{i + 1}: the firmware ended with code {process.returncode}\n"
                    + "".join(f"    {line}\n" for line in lines[-_LAST_LINES:])
                    + f"  what to do: look into {output}"
                )

    def end(self) -> None:
        """Ends them and what they have started: asked first, then by force."""
        for process in self._running:
            _signal(process, signal.SIGTERM)
        for process in self._running:
            with suppress(subprocess.TimeoutExpired):
                process.wait(_GRACE)
            _signal(process, signal.SIGKILL)
            process.wait()
        self._running.clear()


def _start(command: Command, folder: Path) -> subprocess.Popen[bytes]:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in command.files.items():
        (folder / name).write_text(text, encoding="utf-8")
    try:
        with (folder / "output.txt").open("wb") as output:
            return subprocess.Popen(
                command.arguments,
                cwd=folder,
                env={**os.environ, **command.environment},
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=_die_with_parent if _LIBC else None,  # noqa: PLW1509 - no threads
            )
    except OSError as error:
        raise SitlError(
            f"{command.arguments[0]} cannot be started: {error.strerror}\n"
            "  what to do: see that it was built for this machine"
        ) from None


_LIBC = ctypes.CDLL(None) if sys.platform == "linux" else None
_PR_SET_PDEATHSIG = 1


def _die_with_parent() -> None:
    """Between fork and exec: the kernel ends the process should we be killed."""
    if _LIBC is not None:
        _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def _signal(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    """To the process and its children; they share a session of their own."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, number)
