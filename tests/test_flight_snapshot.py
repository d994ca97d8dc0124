"""A snapshot comes out of JSON as it went in."""

import json

from flight_snapshots import snapshot
from multilift.flight.snapshot import from_dict, to_dict


def test_a_snapshot_survives_json():
    shown = snapshot()
    assert from_dict(json.loads(json.dumps(to_dict(shown), allow_nan=False))) == shown
