"""Parameter sets and scenarios: TOML files -> typed trees in SI.

Read `schema` first (what there is), then `load` (how it is read), `signals`, `scenario` and `operator`.
"""

from polydraulic.parameters.load import Entry, load_machine, machine_entries
from polydraulic.parameters.scenario import Scenario, load_scenario, random_operator, scenario_names
from polydraulic.parameters.schema import LINKS, Machine
from polydraulic.parameters.signals import Constant, Piecewise, Signal, Sine

__all__ = [
    "LINKS",
    "Constant",
    "Entry",
    "Machine",
    "Piecewise",
    "Scenario",
    "Signal",
    "Sine",
    "load_machine",
    "load_scenario",
    "machine_entries",
    "random_operator",
    "scenario_names",
]
