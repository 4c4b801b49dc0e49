"""Masses and friction of a machine from pressures and positions, by regression. Read `fit`, then `motion_rows`."""
