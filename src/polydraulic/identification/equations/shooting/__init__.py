"""Numbers of a machine found through simulation, from whatever sensors there are. Read `fit`, then `windows` and `runs`.

`fit_by_shooting` cuts a log into windows (`windows`), simulates all of them side by side with their slopes (`runs`), and lowers the misfit over
numbers and states.
"""
