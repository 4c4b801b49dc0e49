"""How a network grows.

Read `moments` and `scoring` (every candidate node from matrix products), `synthesis` (layer by layer under the predicted squared
error), `least_squares`, `refine` (all coefficients together), `unseen` (what networks do on rows that they have not seen) and `one_output`;
then the estimators `regressor` and `classifier`.
"""
