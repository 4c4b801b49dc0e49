"""Numbers of a machine found through simulation, from whatever sensors there are. Read `fit`, then `windows` and `runs`."""
