"""A flight again, from its log, beside its simulation and what the autopilots recorded."""
