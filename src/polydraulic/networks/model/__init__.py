"""What a network is: nodes, tables, regions, files and the compiled evaluation.

Needs NumPy and numba alone. Read `nodes` (the polynomials), `table` (networks as plain arrays) with `rows_table` (many rows in
lanes), `partition` (which network answers where), `model` and `model_file` (what leaves training), `lags` (what makes a model
dynamic), `slopes` and `compiled`.
"""
