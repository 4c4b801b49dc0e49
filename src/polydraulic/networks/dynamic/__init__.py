"""Networks with memory: they read lagged inputs and their own earlier answers.

Read `spans` (rows without gaps), `rows` (what one row does), `free_run` (the compiled loop), `dynamic_regressor` (the estimator), `lag_selection`; growth by
free runs: `lagged_terms`, `term_growth`, `term_network`, `refine_free_run`. Joints: `command_response`, `joint_network`, `joint_regressor`.
"""
