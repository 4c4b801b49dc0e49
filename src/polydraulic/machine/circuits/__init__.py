"""Circuits of a pump and several valves, as text that is generated for a layout around kernels written by hand."""
