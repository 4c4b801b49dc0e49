"""Parameter sets and scenarios: TOML files -> typed trees in SI.

Read `schema` first (what there is), then `load` (how it is read), `signals`, `scenario` and `operator`.
"""
