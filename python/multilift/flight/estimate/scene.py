"""The estimator of a scenario: which bodies there are, and what ties them."""

from __future__ import annotations

from multilift.flight.estimate.config import Cable, Tuning
from multilift.flight.estimate.estimator import Estimator
from multilift.models.spatial.scenario import SpatialScenario

#: Name of the payload in frames and estimates; vehicles are vehicle_1, vehicle_2, ...
PAYLOAD = "payload"


def estimator_for(scenario: SpatialScenario, tuning: Tuning | None = None) -> Estimator:
    """An estimator of the scenario's vehicles, payload and cables.

    Cables are tied to the vehicles' origins, as in the plant, and to the payload's attachments.
    """
    vehicles = [f"vehicle_{k + 1}" for k in range(scenario.count)]
    cables = [
        Cable(name, PAYLOAD, payload_point=(x, y, z))
        for name, (x, y, z) in zip(vehicles, scenario.values["plant"]["attachment"], strict=True)
    ]
    return Estimator([*vehicles, PAYLOAD], cables, tuning)


def tuning_for(scenario: SpatialScenario) -> Tuning:
    """The tuning for what the scenario says of its motion capture; as it is for what it does not.

    Nothing here can measure how late poses are at the least: the scenario says so.
    """
    delay = float(scenario.values["motion_capture"]["delay"])
    return Tuning(latency=delay) if delay else Tuning()
