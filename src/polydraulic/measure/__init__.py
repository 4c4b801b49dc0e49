"""Measured logs: from files of many kinds to tables that can be learnt from, and back, from simulated runs to logs.

Read `channels` (the channel map), `logs` (what files hold; `csv_log`, `parquet_log`, `mdf_log`, `mat_log`), `clock` and `values` (what is
wrong with times and values; `findings` lists all of it), `resample` (one raster, gaps stay gaps), `importing` (all of this, block
by block). Then what a log can tell: `coverage`, `deadband`, `flows` with `smoothing`; `quality` is the report of it. `sensors` and
`record` are a virtual test bench. Needs the extra `measure`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
