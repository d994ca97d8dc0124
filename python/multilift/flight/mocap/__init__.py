"""Motion capture: sources of poses, and a Qualisys RT server of our own."""
