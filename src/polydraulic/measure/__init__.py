"""Measured logs: from files of many kinds to tables that can be learnt from, and back, from simulated runs to logs.

Read `channels` (the channel map), `formats.logs` (what files hold), `checks.clock` and `checks.channel_check` (what is wrong with times
and values; `findings` lists all of it), `resample` (one raster, gaps stay gaps), `importing` (all of this, block by block). Then what
can be seen in a log: `checks.coverage`, `checks.deadband`, `flows` with `smoothing`; `quality` is the report of it. `bench` is a virtual
test bench. Needs the extra `measure`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
