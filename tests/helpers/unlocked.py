"""A machine's own scenarios that let all of its functions move."""

from polydraulic import load_scenario
from polydraulic.parameters.scenario import scenario_names


def unlocked_scenarios(machine):
    """Names of those that lock no function."""
    return [name for name in scenario_names(machine) if not load_scenario(name).locked]
