"""From poses to positions, velocities, attitudes, rates and cable directions, each with an age."""
