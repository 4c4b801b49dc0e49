"""How a network grows.

Read `moments` and `scoring` (every candidate node from matrix products), `synthesis` (layer by layer under the predicted squared
error), `least_squares` and `leave_one_out`, `refine` (all coefficients together); then the estimators `regressor` and `classifier`.
"""
