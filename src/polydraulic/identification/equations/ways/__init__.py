"""The ways in which numbers of a machine are found, each where a log has the sensors for it. Read `so_far`, then each way.

`by_flows`: pilots, and circuits from spools, pressures and flows. `by_pressures`: masses and friction from pressures and positions.
`by_runs`: what is left, from commands and positions and whatever else there is, through simulation.
"""
