"""The ways in which numbers of a machine are found, each where a log has the sensors for it. Read `so_far`, then each way.

`by_spools`: pilots, hysteresis and flow forces from voltages and spools. `by_flows`: circuits from spools, pressures and flows.
`by_pressures`: masses and friction from pressures and positions. `by_runs`: what is left, from commands and positions and whatever
else there is, through simulation.
"""
