from .bench.recording import record
from .bench.sensors import example_sensors, load_sensors
from .channels import ChannelMap, channel_map, load_channels
from .checks.coverage import coverage
from .checks.deadband import deadband, find_deadbands
from .flows import add_flows, reconstruct_flow
from .formats.logs import open_log
from .importing import Imported, import_log
from .log_units import conversion
from .quality import write_quality
from .smoothing import assumption, differentiate
from .suggest import suggest_channels

__all__ = [
    "ChannelMap",
    "Imported",
    "add_flows",
    "assumption",
    "channel_map",
    "conversion",
    "coverage",
    "deadband",
    "differentiate",
    "example_sensors",
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
