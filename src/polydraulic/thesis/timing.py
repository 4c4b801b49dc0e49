"""Run times: compiled loops warm, models in turn, medians of repeats."""

from statistics import median
from time import perf_counter
from typing import Any

from polydraulic.parameters.scenario import Scenario
from polydraulic.parameters.schema import Machine
from polydraulic.simulation.loop import run
from polydraulic.simulation.runs import arrange


def time_runs(
    machine: Machine, models: dict[str, Any], scenario: Scenario, *, repeats: int = 31, dt: float = 5e-3
) -> dict[str, float]:
    """Median seconds that the loop takes for a scenario with each flow model.

    The models take turns, so that a change of the machine's speed meets all of them alike.
    """
    arranged = {name: arrange(machine, model, scenario, dt=dt) for name, model in models.items()}
    seconds: dict[str, list[float]] = {name: [] for name in models}
    for repeat in range(repeats + 1):
        for name, arguments in arranged.items():
            start = perf_counter()
            run(*arguments)
            if repeat:  # the first turn compiles
                seconds[name].append(perf_counter() - start)
    return {name: median(values) for name, values in seconds.items()}
