"""A network in each region of the inputs.

`region_regressor` with given regions, or regions found by `split_search` and `tree`; `learn_from` learns a function to a tolerance.
"""
