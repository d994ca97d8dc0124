"""Real autopilot firmware flies the simulated vehicles: one physics process serves them all."""
