"""What differs between PX4 and ArduPilot: modes, how parameters travel, what must be set."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Setting:
    """A parameter that a flight depends on.

    Attributes:
        name: at most 16 letters.
        value: that it must have.
        whole: whether it is an integer there.
        reason: why, for people.
    """

    name: str
    value: float
    whole: bool
    reason: str


@dataclass(frozen=True)
class Firmware:
    """One firmware.

    Attributes:
        name: as in a lab file.
        system_parameter: which holds its MAVLink system id.
        bytewise: whether integers travel as the bytes of the float, not as its value.
        fly_mode: custom mode in which it takes our set-points.
        fly_modes: all such modes.
        land_mode: custom mode in which it lands by itself.
        mode_parameters: of MAV_CMD_DO_SET_MODE for a custom mode.
        settings: what must be set before arming.
    """

    name: str
    system_parameter: str
    bytewise: bool
    fly_mode: int
    fly_modes: tuple[int, ...]
    land_mode: int
    settings: tuple[Setting, ...]

    def mode_parameters(self, mode: int) -> tuple[float, ...]:
        """The parameters of MAV_CMD_DO_SET_MODE; the first says that the mode is custom."""
        if self.name == "px4":
            return (1.0, float(mode >> 16 & 0xFF), float(mode >> 24))
        return (1.0, float(mode))

    def mode_name(self, mode: int) -> str:
        """A mode in words."""
        if mode in self.fly_modes:
            return "fly"
        return "land" if mode == self.land_mode else f"mode {mode:#x}"


def _px4(main: int, sub: int = 0) -> int:
    return main << 16 | sub << 24


_PX4_OFFBOARD = _px4(6)
_PX4_LAND = _px4(4, 6)
_GUIDED, _GUIDED_NOGPS, _LAND = 4, 20, 9

PX4 = Firmware(
    "px4",
    "MAV_SYS_ID",
    True,
    _PX4_OFFBOARD,
    (_PX4_OFFBOARD,),
    _PX4_LAND,
    (
        Setting("COM_OF_LOSS_T", 0.5, False, "set-points are lost after this time, s"),
        Setting("COM_OBL_RC_ACT", 4, True, "then it lands; Hold needs a global position"),
        Setting("COM_RC_IN_MODE", 4, True, "no remote control in the loop: the kill is ours"),
        Setting("COM_RCL_EXCEPT", 4, True, "OFFBOARD goes on without a remote control"),
        Setting("NAV_DLL_ACT", 3, True, "it lands when the ground station is gone"),
        Setting("COM_LOW_BAT_ACT", 0, True, "it warns: one vehicle never leaves by itself"),
        Setting("EKF2_EV_CTRL", 11, True, "position and heading from vision"),
        Setting("EKF2_HGT_REF", 3, True, "height from vision"),
        Setting("EKF2_GPS_CTRL", 0, True, "no GPS indoors"),
    ),
)

ARDUPILOT = Firmware(
    "ardupilot",
    "SYSID_THISMAV",
    False,
    _GUIDED,
    (_GUIDED, _GUIDED_NOGPS),
    _LAND,
    (
        Setting("GUID_OPTIONS", 8, True, "thrust means thrust; without it, climb rate"),
        Setting("GUID_TIMEOUT", 0.5, False, "set-points are lost after this time, s"),
        Setting("FS_GCS_ENABLE", 5, True, "it lands when the ground station is gone"),
        Setting("FS_GCS_TIMEOUT", 2, False, "after this time, s"),
        Setting("FS_EKF_ACTION", 1, True, "it lands when its estimate fails"),
        Setting("BATT_FS_LOW_ACT", 0, True, "it warns: one vehicle never leaves by itself"),
        Setting("VISO_TYPE", 1, True, "vision by MAVLink"),
        Setting("EK3_SRC1_POSXY", 6, True, "position from vision"),
        Setting("EK3_SRC1_POSZ", 6, True, "height from vision"),
        Setting("EK3_SRC1_YAW", 6, True, "heading from vision"),
    ),
)

BY_NAME = {f.name: f for f in (PX4, ARDUPILOT)}
