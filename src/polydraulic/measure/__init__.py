"""Measured logs: from files of many kinds to tables that can be learnt from, and back, from simulated runs to logs.

Read `channels` (the channel map), `logs` (what files hold; `csv_log`, `parquet_log`, `mdf_log`, `mat_log`), `clock` and `values` (what is
wrong with times and values; `findings` lists all of it), `resample` (one raster, gaps stay gaps), `importing` (all of this, block
by block). Then what a log can tell: `coverage`, `deadband`, `flows` with `smoothing`; `quality` is the report of it. `sensors` and
`record` are a virtual test bench. Needs the extra `measure`.
"""

from polydraulic.measure.channels import ChannelMap, load_channels
from polydraulic.measure.conversion import conversion
from polydraulic.measure.coverage import coverage
from polydraulic.measure.deadband import deadband, find_deadbands
from polydraulic.measure.flows import add_flows, reconstruct_flow
from polydraulic.measure.importing import Imported, import_log
from polydraulic.measure.logs import open_log
from polydraulic.measure.quality import write_quality
from polydraulic.measure.record import record
from polydraulic.measure.sensors import load_sensors
from polydraulic.measure.smoothing import assumption, differentiate
from polydraulic.measure.suggest import suggest_channels

__all__ = [
    "ChannelMap",
    "Imported",
    "add_flows",
    "assumption",
    "conversion",
    "coverage",
    "deadband",
    "differentiate",
    "find_deadbands",
    "import_log",
    "load_channels",
    "load_sensors",
    "open_log",
    "reconstruct_flow",
    "record",
    "suggest_channels",
    "write_quality",
]
