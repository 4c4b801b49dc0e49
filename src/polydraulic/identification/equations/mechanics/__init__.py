"""Masses and friction of a machine from pressures and positions, by regression. Read `fit`, then `motion_rows`.

`fit_mechanics` makes rows of a log (`log_pieces`, `motion_rows`, by the regressor of `inertia`), solves them robustly, goes on with all rows and
their noise (`noisy_motion`), and brings the machine's numbers to them; `base_parameters` says which combinations of masses any motion can tell.
"""
