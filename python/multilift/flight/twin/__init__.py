"""What stands in for the rig: autopilots on MAVLink that fly the spatial plant."""
