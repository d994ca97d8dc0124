"""One vehicle's MAVLink 2 link: frames, units, signatures, guards, acknowledgements, parameters."""
