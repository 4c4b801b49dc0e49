"""A virtual test bench: simulated runs as `sensors` read them, written as logs by `recording`."""
