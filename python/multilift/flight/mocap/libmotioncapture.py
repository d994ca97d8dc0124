"""Frames by the library `motioncapture`, for the systems that it speaks to.

It waits without end and tells neither frame numbers nor capture times, so it only ever runs in a
process of its own, see `multilift.flight.mocap.child`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

from multilift.errors import MissingExtraError
from multilift.flight.mocap.errors import CaptureError
from multilift.flight.mocap.frames import Frame, Pose
from multilift.flight.mocap.settings import Settings


def frames(settings: Settings) -> Iterator[Frame]:
    """All frames from now on; the library gives metres already.

    Raises:
        CaptureError: no server, or no such kind of system.
        MissingExtraError: motioncapture is not installed.
    """
    try:
        import motioncapture  # noqa: PLC0415
    except ImportError:
        raise MissingExtraError("motioncapture", "fly", "motion capture") from None
    options = {"hostname": settings.host, "enable_pointcloud": "0"}
    if settings.kind == "qualisys":
        options["port"] = str(settings.port - 1)  # the base port, from which it counts itself
    try:
        system = motioncapture.connect(settings.kind, options)
    except RuntimeError as error:
        raise CaptureError(
            f"{settings.kind} at {settings.host}: {error}\n"
            "  what to do: check host and kind, and that the system streams rigid bodies"
        ) from None
    while True:
        system.waitForNextFrame()
        received = time.monotonic()
        yield Frame(None, None, received, _bodies(system.rigidBodies, settings))


def _bodies(found: Any, settings: Settings) -> dict[str, Pose]:
    bodies = {}
    for ours, theirs in settings.bodies.items():
        body = found.get(theirs)
        if body is not None:
            x, y, z = map(float, body.position)
            turn = body.rotation
            pose = Pose((x, y, z), (turn.w, turn.x, turn.y, turn.z))
            bodies[ours] = settings.axes.ours(ours, pose)
    return bodies
