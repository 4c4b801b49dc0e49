"""polydraulic: polynomial abductive networks and real-time simulation of mobile hydraulic machines.

The names below are loaded when first used, so that importing the package, or asking the command line for help,
costs nothing. Layers, lowest first: `parameters`, `machine` and `networks`, `flow`, `simulation`, `export` and `measure`, `studies`.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from polydraulic.errors import InputError, SimulationError
    from polydraulic.flow import build_flow
    from polydraulic.networks import AbductiveRegressor, RegionRegressor, load_models
    from polydraulic.parameters import load_machine, load_scenario
    from polydraulic.simulation import compare, reference, simulate, simulate_batch
    from polydraulic.tables import Table, read_table, write_table

__version__ = "0.1.0"

_HOME = {
    "AbductiveRegressor": "networks",
    "InputError": "errors",
    "RegionRegressor": "networks",
    "SimulationError": "errors",
    "Table": "tables",
    "build_flow": "flow",
    "compare": "simulation",
    "load_machine": "parameters",
    "load_models": "networks",
    "load_scenario": "parameters",
    "read_table": "tables",
    "reference": "simulation",
    "simulate": "simulation",
    "simulate_batch": "simulation",
    "write_table": "tables",
}

__all__ = [
    "AbductiveRegressor",
    "InputError",
    "RegionRegressor",
    "SimulationError",
    "Table",
    "build_flow",
    "compare",
    "load_machine",
    "load_models",
    "load_scenario",
    "read_table",
    "reference",
    "simulate",
    "simulate_batch",
    "write_table",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'polydraulic' has no attribute {name!r}")
    return getattr(import_module(f"polydraulic.{_HOME[name]}"), name)
