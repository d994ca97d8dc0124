"""The flight program: motion capture in, MAVLink out, real or simulated autopilots in the loop."""
