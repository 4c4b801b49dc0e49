"""Circuits of a pump and many valves, as text that is generated around kernels written by hand; circuits that are joined."""
