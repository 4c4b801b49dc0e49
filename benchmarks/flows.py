"""Every flow model next to the exact one: distance of the stick's tips, error over its inputs, size, and time a step.

``python benchmarks/flows.py [--operators N]``: it prints Markdown tables and asserts nothing. Networks are the ones that
come with the package; no scenario took part in their training.
"""

import argparse

import numpy as np

from polydraulic import build_flow, compare, load_machine, load_scenario, random_operator, simulate
from polydraulic.flow import table_bytes
from polydraulic.flow.polynomial import shipped_models
from polydraulic.simulation.layout.flow_points import sample_flow
from polydraulic.thesis.excavator import LINKS, pump_of, spool_of, with_pumps
from polydraulic.thesis.timing import PAIRS, time_runs
from show import table

SCENARIOS = ("sine", "step", "pulse", "task")
FLOWS = {
    "exact": ("exact", {}),
    "iterative, eps 0.05": ("iterative", {}),
    "stiff": ("stiff", {}),
    "tlm": ("tlm", {}),
    "polynomial, cascade": ("polynomial", {}),
    "polynomial-fine": ("polynomial-fine", {}),
    "polynomial, direct": ("polynomial", {"arrangement": "direct"}),
    "neural": ("neural", {}),
    "lookup, 12 points": ("lookup", {"points": 12}),
    "lookup, 24 points": ("lookup", {}),
    "lookup, 48 points": ("lookup", {"points": 48}),
}


def distance(machine, flow, scenario, exact):
    """Largest distance of the tips in mm."""
    return 1e3 * compare(exact, simulate(machine, flow, scenario))["effector.distance"].largest


def map_errors(machine, model, n=20000):
    """Root mean square and largest error of the input flows over spools and line pressures, % of the pump's flow."""
    rng, travel = np.random.default_rng(0), spool_of(machine).end
    highest = [min(machine.function(link).line.relief, pump_of(machine, "boom").relief) for link in LINKS]
    spool, p_in = rng.uniform(-travel, travel, (n, 3)), rng.uniform(0.0, highest, (n, 3))
    ours, true = (sample_flow(machine, one, spool, p_in, p_in).q_in for one in (model, "exact"))
    error = 100.0 * (ours - true) / pump_of(machine, "series").flow
    return np.sqrt(np.mean(error**2, axis=0)), np.abs(error).max(axis=0)


def torque_limit(machine):
    """Networks with and without those of the limit, on pumps that have one."""
    limited = with_pumps(machine, torque_limit_enabled=True)
    models = {
        "cascade, with those of the limit": build_flow("polynomial", limited),
        "polynomial-fine, with those of the limit": build_flow("polynomial-fine", limited),
        "direct, with those of the limit": build_flow("polynomial", limited, arrangement="direct"),
        "cascade, without": build_flow("polynomial", limited, models=shipped_models()),
    }
    scenarios = [load_scenario(name) for name in SCENARIOS]
    pairs = [(scenario, simulate(limited, "exact", scenario)) for scenario in scenarios]
    rows = [[name, *(f"{distance(limited, model, s, e):.1f}" for s, e in pairs)] for name, model in models.items()]
    table("The same with a torque limit, from exact with it, mm", ["networks", *SCENARIOS], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--operators", type=int, default=20, help="random operators of 60 s")
    options = parser.parse_args()
    machine = load_machine("cat215b")
    models = {name: build_flow(kind, machine, **settings) for name, (kind, settings) in FLOWS.items()}
    scenarios = [load_scenario(name) for name in SCENARIOS]
    operators = [random_operator(seed, 60.0) for seed in range(options.operators)]
    exact = {scenario.name: simulate(machine, "exact", scenario) for scenario in (*scenarios, *operators)}
    rows = []
    for name, model in models.items():
        found = [distance(machine, model, scenario, exact[scenario.name]) for scenario in scenarios]
        by_chance = [distance(machine, model, scenario, exact[scenario.name]) for scenario in operators]
        rows.append([name, *(f"{value:.1f}" for value in (*found, np.median(by_chance), np.quantile(by_chance, 0.95)))])
    header = ["flow model", *SCENARIOS, f"{len(operators)} operators, median", "95 %"]
    table("Largest distance of the tip from the exact run, mm", header, rows)
    rows = []
    for name, model in models.items():
        if not model.stores_oil:
            rms, largest = map_errors(machine, model)
            errors = [f"{a:.3g} / {b:.3g}" for a, b in zip(rms, largest, strict=True)]
            rows.append([name, *errors, f"{table_bytes(model) / 1e6:.3g}"])
    header = ["flow model", *LINKS, "arrays, MB"]
    table("Error of the input flow over random spools and pressures, rms / largest, % of the pump's flow", header, rows)
    times = {name: time_runs(machine, models, load_scenario(name), base="exact") for name in ("sine", "task")}
    rows = [[name, *(str(found[name].ratio) for found in times.values())] for name in models if name != "exact"]
    table(f"CPU time of a step, ratio to exact, median and quartiles of {PAIRS} pairs", ["flow model", *times], rows)
    for name, found in times.items():
        print(f"\nexact, {name}: {found['exact'].seconds / 2600 * 1e9:.0f} ns a step")
    torque_limit(machine)


if __name__ == "__main__":
    main()
