"""A pump and many valves in series: text that is generated around kernels written by hand."""
