"""Every flow model next to the exact one: errors over the map, distance of the stick's tips, and time a step, in one run.

``python benchmarks/flows.py [--operators N]``: it prints Markdown tables and asserts nothing. Networks are the ones that come
with the package; no scenario took part in their training.
"""

import argparse

import numpy as np

from polydraulic import build_flow, compare, load_machine, load_scenario, simulate
from polydraulic.flow.polynomial import shipped_models
from polydraulic.flow.sample import sample_flow
from polydraulic.parameters import random_operator
from polydraulic.studies.timing import time_runs
from polydraulic.units import to_si

SCENARIOS = ("sine", "step", "pulse", "task")
FLOWS = {
    "exact": ("exact", {}),
    "iterative, eps 0.05": ("iterative", {}),
    "stiff": ("stiff", {}),
    "tlm": ("tlm", {}),
    "polynomial, cascade": ("polynomial", {}),
    "polynomial, direct": ("polynomial", {"arrangement": "direct"}),
    "neural": ("neural", {}),
}


def table(title, header, rows):
    print(f"\n### {title}\n\n| {' | '.join(header)} |\n|{'---|' * len(header)}")
    for row in rows:
        print(f"| {' | '.join(row)} |")


def distance(machine, flow, scenario, exact):
    """Largest distance of the tips in mm."""
    return 1e3 * compare(exact, simulate(machine, flow, scenario))["effector.distance"].largest


def over_the_map(machine, section, n=400_000):
    """Travels and pressures of all links at random up to relief, (n, 3) each; a fifth of them on faces and in corners."""
    rng, spool = np.random.default_rng(99), machine.spool
    low, high = np.zeros(6), np.append(np.full(3, spool.knots[-1]), np.full(3, machine.pumps.relief))
    high[3] = machine.swing.line.relief
    if section == "D":  # both valves of the series circuit open, the first still passes something on
        low[[0, 2]], high[0] = np.nextafter(spool.deadband, 1.0), spool.bypass_closed
    unit = rng.random((n, 6))
    on_faces = (np.arange(n) % 5 == 0)[:, None] & (rng.random((n, 6)) < rng.random((n, 1)))
    unit[on_faces] = np.round(unit[on_faces])
    return np.split(np.clip(low + (high - low) * unit, low, high), 2, axis=1)


def maps(title, machine, models):
    """Errors of the input flows over the whole box and section D."""
    rows, exact = [], build_flow("exact", machine)
    for section in ("whole", "D"):
        spool, p = over_the_map(machine, section)
        true = sample_flow(exact, spool, p, np.zeros_like(p)).q_in
        for name, model in models.items():
            error = (sample_flow(model, spool, p, np.zeros_like(p)).q_in - true) / to_si(1.0, "in3/s")
            each = zip(np.abs(error).max(axis=0), np.sqrt(np.mean(error**2, axis=0)), strict=True)
            rows.append([name, section, *(f"{largest:.2f} / {rms:.3f}" for largest, rms in each)])
    table(f"Input flows, {title}: largest / rms error, in3/s", ["networks", "box", "swing", "boom", "stick"], rows)


def torque_limit(machine):
    """Networks with and without those of the limit, on pumps that have one."""
    limited = machine._replace(pumps=machine.pumps._replace(torque_limit_enabled=True))
    models = {
        "with those of the limit": build_flow("polynomial", limited),
        "without": build_flow("polynomial", limited, models=shipped_models()),
    }
    maps("torque limit", limited, models)
    scenarios = [load_scenario(name) for name in SCENARIOS]
    exact = [simulate(limited, "exact", scenario) for scenario in scenarios]
    pairs = list(zip(scenarios, exact, strict=True))
    rows = [[name, *(f"{distance(limited, model, s, e):.1f}" for s, e in pairs)] for name, model in models.items()]
    table("The same with a torque limit, from exact with it, mm", ["networks", *SCENARIOS], rows)
    seconds = time_runs(limited, {"exact": build_flow("exact", limited), **models}, load_scenario("task"))
    print("\ntask, time a step, ratio to exact:", {name: round(s / seconds["exact"], 2) for name, s in seconds.items()})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--operators", type=int, default=20, help="random operators of 60 s")
    options = parser.parse_args()
    machine = load_machine("cat215b")
    models = {name: build_flow(kind, machine, **settings) for name, (kind, settings) in FLOWS.items()}
    scenarios = [load_scenario(name) for name in SCENARIOS]
    operators = [random_operator(seed, 60.0) for seed in range(options.operators)]
    exact = {scenario.name: simulate(machine, "exact", scenario) for scenario in (*scenarios, *operators)}
    maps(
        "relief valves on",
        machine,
        {name: models[name] for name in FLOWS if FLOWS[name][0] in ("polynomial", "neural")},
    )
    rows = []
    for name, model in models.items():
        found = [distance(machine, model, scenario, exact[scenario.name]) for scenario in scenarios]
        by_chance = [distance(machine, model, scenario, exact[scenario.name]) for scenario in operators]
        rows.append([name, *(f"{value:.1f}" for value in (*found, np.median(by_chance), np.quantile(by_chance, 0.95)))])
    header = ["flow model", *SCENARIOS, f"{len(operators)} operators, median", "95 %"]
    table("Largest distance of the tip from the exact run, mm", header, rows)
    seconds = {name: time_runs(machine, models, load_scenario(name)) for name in ("sine", "task")}
    rows = [[name, *(f"{values[name] / values['exact']:.2f}" for values in seconds.values())] for name in models]
    table("Time a step, ratio to exact", ["flow model", *seconds], rows)
    for name, values in seconds.items():
        steps = round(load_scenario(name).duration / 5e-3)
        print(f"\nexact, {name}: {values['exact'] / steps * 1e9:.0f} ns a step")
    torque_limit(machine)


if __name__ == "__main__":
    main()
