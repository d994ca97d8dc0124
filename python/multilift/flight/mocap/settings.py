"""What is asked of a motion capture system, and how its axes stand in ours."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

from multilift.flight.mocap import rotations
from multilift.flight.mocap.frames import IDENTITY, Pose, Quaternion, Vector


@dataclass(frozen=True, slots=True)
class Mount:
    """Where our body frame stands in the body as the capture system knows it.

    Attributes:
        origin: our origin in the captured body's axes, m.
        attitude: turns our body's coordinates into the captured body's.
    """

    origin: Vector = (0.0, 0.0, 0.0)
    attitude: Quaternion = IDENTITY


@dataclass(frozen=True, slots=True)
class Axes:
    """The one place where captured poses become ours.

    Attributes:
        origin: of the capture system in our world, m.
        attitude: turns the capture system's coordinates into our world's.
        mounts: of bodies, by our names; left out where the frames are the same.
    """

    origin: Vector = (0.0, 0.0, 0.0)
    attitude: Quaternion = IDENTITY
    mounts: Mapping[str, Mount] = field(default_factory=dict)

    def ours(self, name: str, pose: Pose) -> Pose:
        """A captured pose, in metres, as ours."""
        mount = self.mounts.get(name, Mount())
        lever = rotations.turned(pose.attitude, mount.origin)
        a, b, c = (p + d for p, d in zip(pose.position, lever, strict=True))
        x, y, z = rotations.turned(self.attitude, (a, b, c))
        u, v, w = self.origin
        attitude = rotations.product(pose.attitude, mount.attitude)
        attitude = rotations.product(self.attitude, attitude)
        return Pose((x + u, y + v, z + w), attitude, pose.residual)


@dataclass(frozen=True, slots=True)
class Settings:
    """What is asked of a motion capture system.

    Attributes:
        system: "qualisys" for its RT server by the maker's client, "motioncapture" for that
            library.
        kind: of system, where it is "motioncapture": "vicon", "optitrack", "vrpn", ...
        host: of its server.
        port: of Qualisys' little-endian server; the others have theirs.
        bodies: their names in the capture system, by our names.
        axes: how its frames stand in ours.
    """

    system: str
    bodies: Mapping[str, str]
    kind: str = ""
    host: str = "127.0.0.1"
    port: int = 22223
    axes: Axes = field(default_factory=Axes)

    def to_json(self) -> str:
        """All of it as text."""
        return json.dumps(asdict(self))

    @staticmethod
    def from_json(text: str) -> Settings:
        """What `to_json` wrote."""
        values = json.loads(text)
        axes = values.pop("axes")
        mounts = {
            name: Mount(tuple(m["origin"]), tuple(m["attitude"]))
            for name, m in axes["mounts"].items()
        }
        placed = Axes(tuple(axes["origin"]), tuple(axes["attitude"]), mounts)
        return Settings(**values, axes=placed)
