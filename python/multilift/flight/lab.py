"""A lab: one TOML file that says which vehicles and motion capture there are and what is allowed.

Written and checked as scenario files are; a lab that names no hardware is a twin.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from multilift import library, scenario, schema
from multilift.errors import ScenarioError
from multilift.fields import Field
from multilift.flight import lab_checks as checks
from multilift.flight.lab_tables import LIMITS, MOTION_CAPTURE, RATES, SECURITY, TABLES, VEHICLE
from multilift.flight.link import thrust
from multilift.flight.link.address import Address
from multilift.models.spatial.scenario import SpatialScenario

_TEXTS = ("name", "title")
_KEYS = ("schema", *_TEXTS, "scenario", *TABLES)

#: Letters of a scenario's name that an error shows.
_SHOWN = 200


@dataclass(frozen=True)
class LabVehicle:
    """A vehicle of a lab.

    Attributes:
        system, component: its MAVLink ids.
        address: None for a twin.
        firmware: "px4" or "ardupilot".
        mass: kg.
        hover_thrust: normalised thrust at which it hovers alone.
        thrust_curve: PX4's THR_MDL_FAC, ArduPilot's MOT_THST_EXPO.
        battery_voltage: at which hover_thrust holds, V; 0 where it is not compensated.
        body: its name in motion capture.
    """

    system: int
    component: int
    address: Address | None
    firmware: str
    mass: float
    hover_thrust: float
    thrust_curve: float
    battery_voltage: float
    body: str


@dataclass(frozen=True)
class Limits:
    """What ends the flight of all vehicles; SI and radians, see the table ``[limits]``."""

    fence_low: list[float]
    fence_high: list[float]
    tilt: float
    swing: float
    separation: float
    speed: float
    saturation: float
    state_age: float
    mocap_age: float
    link_age: float
    hold: float
    battery: float
    round_trip: float = 0.25


@dataclass(frozen=True)
class Lab:
    """A checked lab.

    Attributes:
        where: the file.
        name, title: texts of the file.
        scenario: what is flown.
        vehicles: in the scenario's order.
        motion_capture, rates, security: these tables, complete.
        limits: as a record.
        key_file: that signs; None without.
    """

    where: str
    name: str
    title: str
    scenario: SpatialScenario
    vehicles: tuple[LabVehicle, ...]
    motion_capture: Mapping[str, Any]
    rates: Mapping[str, Any]
    limits: Limits
    security: Mapping[str, Any]
    key_file: Path | None

    @property
    def is_twin(self) -> bool:
        """Whether nothing in it is real."""
        return self.vehicles[0].address is None


#: What is flown where no other lab is named: nothing real.
DEFAULT = Path(__file__).with_name("default_lab.toml")

#: What of a vehicle and of motion capture is hardware.
_HARDWARE = ("address", "hover_thrust", "thrust_curve", "battery_voltage")


def load(path: str | Path, *, twin: bool = False) -> Lab:
    """Reads and checks a lab file.

    Args:
        path: of the file.
        twin: whether hardware that it names is left out, so that nothing in it is real.

    Raises:
        ScenarioError: for a missing or unreadable file and anything wrong in it.
    """
    file = Path(path)
    raw = library.read(file, str(path))
    raw.setdefault("name", file.stem)
    lab = parse(raw, str(path), file.parent)
    return parse(_without_hardware(raw), str(path), file.parent) if twin else lab


def _without_hardware(raw: Mapping[str, Any]) -> dict[str, Any]:
    """A checked lab's tables with a twin in the place of what is real."""
    soft = {key: value for key, value in raw.items() if key != "security"}
    if "vehicle" in raw:
        soft["vehicle"] = [
            {key: value for key, value in vehicle.items() if key not in _HARDWARE}
            for vehicle in raw["vehicle"]
        ]
    if "motion_capture" in raw:
        payload = raw["motion_capture"].get("payload")
        soft["motion_capture"] = {} if payload is None else {"payload": payload}
    return soft


def parse(raw: Mapping[str, Any], where: str, folder: Path) -> Lab:
    """Checks a lab's tables.

    Args:
        raw: as a TOML file holds them.
        where: the file, for errors.
        folder: where relative paths begin.

    Raises:
        ScenarioError: naming file, key, value, permitted range and what to do.
    """
    for key, value in raw.items():
        if key not in _KEYS:
            raise schema.unknown_key(where, key, value, _KEYS)
    if raw.get("schema", 1) != 1 or isinstance(raw.get("schema", 1), bool):
        raise ScenarioError("is not a version this multilift reads", where=where, key="schema",
                            value=raw["schema"], permitted="1")  # fmt: skip
    texts = {k: Field(k, "", "text").normalise(raw.get(k, ""), where, k) for k in _TEXTS}
    flown = _scenario(raw, where, folder)
    tables = {t.name: t.normalise(raw.get(t.name, {}), where)
              for t in (MOTION_CAPTURE, RATES, LIMITS, SECURITY)}  # fmt: skip
    given = _vehicles(raw.get("vehicle", []), flown, where)
    vehicles = tuple(_vehicle(k, v, flown, where) for k, v in enumerate(given))
    addresses = [v.address for v in vehicles]
    checks.check_ids([v.system for v in vehicles], tables["security"]["system"], where)
    checks.check_bodies([v.body for v in vehicles], tables["motion_capture"]["payload"], where)
    checks.check_hardware(addresses, tables["motion_capture"], where)
    checks.check_open(addresses, tables["security"], where)
    checks.check_rates(tables["rates"], where)
    if addresses[0] is None:
        tables["limits"] |= checks.twin_fence(tables["limits"], flown)
    checks.check_limits(tables["limits"], flown, where)
    key_file = tables["security"]["key_file"]
    return Lab(
        where,
        texts["name"].strip() or "lab",
        texts["title"].strip(),
        flown,
        vehicles,
        tables["motion_capture"],
        tables["rates"],
        Limits(**tables["limits"]),
        tables["security"],
        folder / key_file if key_file else None,
    )


def _scenario(raw: Mapping[str, Any], where: str, folder: Path) -> SpatialScenario:
    choice = Field("scenario", "", "text")
    if "scenario" not in raw:
        raise ScenarioError(
            "is missing", where=where, key="scenario", permitted=choice.permitted,
            advice="name a shipped scenario such as exp1_1_quadrotors, or a file beside this one",
        )  # fmt: skip
    name = choice.normalise(raw["scenario"], where, "scenario")
    beside = folder / name
    try:
        flown = scenario.load(beside if _is_file(beside) else name)
    except (OSError, ValueError) as error:
        if isinstance(error, ScenarioError):
            # What is wrong in a scenario's own file is said of that file.
            shipped = [shown.stem for shown in library.files()]
            if _is_file(beside) or name in shipped:
                raise
            raise ScenarioError(
                "is neither shipped nor a file beside this one", where=where, key="scenario",
                value=name[:_SHOWN], permitted="a TOML file, or one of " + ", ".join(shipped),
            ) from None  # fmt: skip
        raise ScenarioError(f"cannot be read: {error}", where=where, key="scenario",
                            value=name) from None  # fmt: skip
    if not isinstance(flown, SpatialScenario):
        raise ScenarioError(
            "is not of vehicles in space", where=where, key="scenario", value=name,
            permitted='scenarios with plant.model = "spatial"',
            advice="exp1_1_quadrotors is one",
        )  # fmt: skip
    if flown.values["vehicle"]["kind"] != "quadrotor":
        raise ScenarioError(
            "has ideal vehicles, which no autopilot flies", where=where, key="scenario",
            value=name, permitted='scenarios with vehicle.kind = "quadrotor"',
            advice="give it a [vehicle] type, such as paper_craft",
        )  # fmt: skip
    return flown


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except ValueError:  # a null character in the name
        return False


def _vehicles(given: Any, flown: SpatialScenario, where: str) -> list[dict[str, Any]]:
    if not isinstance(given, list):
        raise ScenarioError(
            "is not a list of tables", where=where, key="vehicle", advice="write [[vehicle]]"
        )
    if not given:
        given = [{"system": k + 1} for k in range(flown.count)]
    if len(given) != flown.count:
        raise ScenarioError(
            f"there are {len(given)}", where=where, key="vehicle",
            permitted=f"{flown.count}, as many as {flown.name} has",
            advice="give one [[vehicle]] for each, or another scenario",
        )  # fmt: skip
    return [VEHICLE.normalise(v, where, f"vehicle[{k}]") for k, v in enumerate(given)]


def _vehicle(k: int, values: Mapping[str, Any], flown: SpatialScenario, where: str) -> LabVehicle:
    key = f"vehicle[{k}]"
    text = values["address"]
    address = Address.parse(text, where, f"{key}.address") if text else None
    plant, rotors = flown.plant, flown.vehicle
    mass = float(np.ravel(plant.vehicle_mass)[k])
    hover, curve = values["hover_thrust"], values["thrust_curve"]
    if curve is None:
        curve = float(np.ravel(flown.autopilot.thrust_curve)[k])
    checks.check_between(curve, 0.0, 1.0, where, f"{key}.thrust_curve")
    if hover is None:
        if address is not None:
            raise ScenarioError(
                "is missing", where=where, key=f"{key}.hover_thrust",
                permitted=VEHICLE.field("hover_thrust").permitted,
                advice="hover the vehicle by hand and read it off, or take MPC_THR_HOVER or "
                "MOT_THST_HOVER",
            )  # fmt: skip
        most = 4.0 * np.ravel(rotors.thrust_coefficient * rotors.rotor_speed_max**2)
        hover = thrust.command(mass * float(plant.gravity) / float(most[k]), curve)
    checks.check_between(hover, 0.05, 0.8, where, f"{key}.hover_thrust")
    return LabVehicle(
        values["system"], values["component"], address, values["firmware"], mass, float(hover),
        curve, values["battery_voltage"], values["body"] or f"vehicle_{k + 1}",
    )  # fmt: skip
