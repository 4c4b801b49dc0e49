"""A machine that has what its file does not: how far the identified one is from it, with networks of what is left, and with effects identified.

``python benchmarks/identify_second.py [--quick] [--seed N]``: it prints Markdown tables and asserts nothing. The second truth is cat215b with spools that
lag behind their pilots by 0.3 mm, flow forces against springs of 100 N/mm, friction that holds, and lines a third softer than the file says. The
file to begin from, which declares none of these, sensors and judges are those of ``benchmarks/identify.py``; ten minutes of log.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

from identify import FULL, JUDGED, SCENARIOS, recorded
from polydraulic import build_flow, load_machine, load_scenario, random_operator, simulate
from polydraulic.identification import identify, learn_residuals
from polydraulic.identification.log_replay import joints_of
from polydraulic.machine.frames import link_frames, placed
from polydraulic.parameters.layout.parts import Effects, FlowForce
from polydraulic.thesis.rough_machine import rough_machine
from show import table

SECONDS, JUDGES = 600.0, range(4000, 4010)
LAG, FORCE, SOFTER = 3e-4, FlowForce(1e5, 870.0, np.radians(69.0)), 1.3
# what is free where nobody says so, effects of spools, whether friction holds, and lines
ASKED = ("functions.*.valve.*", "functions.*.pilot.*", "circuits.*.pump.*")
ASKED += ("functions.*.valve.hysteresis", "functions.*.valve.flow_force.spring_rate", "functions.*.line.compliance_*")
ASKED += ("functions.*.friction.sticks",)


def second(machine):
    """The machine with effects that its file does not declare."""
    effects = Effects(True, None, LAG, FORCE)
    softer = {
        f"functions.{f.name}.line.{key}": SOFTER * getattr(f.line, key)
        for f in machine.functions
        for key in ("compliance_a", "compliance_b")
    }
    functions = tuple(f._replace(effects=effects) for f in machine.functions)
    return machine._replace(functions=functions).with_values(softer)


def states_of(machine, flow, scenario):
    """Tip in m, angles in deg and pressures at ports in bar, (n_row, n) each."""
    run = simulate(machine, flow, scenario)
    angles = run.matrix([joint.column for joint in joints_of(machine)])
    tip = placed(link_frames(machine, angles), *machine.tip)
    ports = run.matrix([f"{name}.{port}" for name in machine.names for port in ("p_a", "p_b")])
    return tip, np.degrees(angles), 1e-5 * ports


def errors(true, machine, flow, scenarios):
    """Largest distance of the tip, mm; rms errors of angles, deg, and of pressures, bar; a row each. `true` are its states."""
    found = []
    for scenario, exact in zip(scenarios, true, strict=True):
        ours = states_of(machine, flow, scenario)
        far = 1e3 * np.linalg.norm(ours[0] - exact[0], axis=1).max()
        found.append([far, *(np.sqrt(np.mean((a - b) ** 2)) for a, b in zip(ours[1:], exact[1:], strict=True))])
    return np.array(found)


def effects_of(truth, found):
    """Effects that were found, with standard errors, a row each; of lines, how much softer they are than the file says."""
    rows = []
    for path, new in found.changes.items():
        what, (value, error) = path.rpartition(".")[2], (new.value, new.uncertainty)
        if what == "hysteresis":
            rows.append([truth, path, f"{1e3 * value:.4f} mm", f"{1e3 * error:.4f} mm"])
        elif what == "spring_rate":
            rows.append([truth, path, f"{1e-3 * value:.1f} N/mm", f"{1e-3 * error:.1f} N/mm"])
        elif what.startswith("compliance"):
            old = next(n.value for n in found.before.numbers if n.path == path)
            rows.append([truth, path, f"{value / old:.3f} of the file's", f"{error / old:.3f}"])
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="three minutes of log, two operators")
    parser.add_argument("--seed", type=int, default=3011, help="of the operator who is recorded")
    options = parser.parse_args()
    seconds, judges = (180.0, JUDGES[:2]) if options.quick else (SECONDS, JUDGES)
    nominal = load_machine("cat215b")
    start = rough_machine(nominal, np.random.default_rng(options.seed))
    scenarios = [load_scenario(name) for name in SCENARIOS]
    operators = [random_operator(seed, 60.0, limit=JUDGED) for seed in judges]
    rows, left, numbers = [], [], []
    for truth, true in (("as the equations", nominal), ("with effects", second(nominal))):
        with tempfile.TemporaryDirectory() as folder:
            log = recorded(true, Path(folder), options.seed, seconds, FULL)
        pairs = []
        for asked, name in (((), "identified"), (ASKED, "effects identified")):
            found = identify(log, start, free=asked)
            learnt = learn_residuals(found)
            left += [
                [
                    truth,
                    name,
                    r.function,
                    f"{r.before:.2%}",
                    f"{r.after:.2%}",
                    f"{r.low:.1%} to {r.high:.1%}",
                    "yes" if r.kept else "no",
                ]
                for r in learnt.judged
            ]
            print(found, learnt, sep="\n", file=sys.stderr, flush=True)
            numbers += effects_of(truth, found) if asked else []
            pairs.append((name, found.machine, "exact"))
            if learnt.models:
                flow = build_flow("residual", found.machine, models=learnt.models)
                pairs.append((f"{name}, and networks of what is left", found.machine, flow))
        if true is not nominal:
            pairs.append(("true curves, no effects", nominal, "exact"))
        exact = [[states_of(true, "exact", scenario) for scenario in of] for of in (scenarios, operators)]
        for name, machine, flow in pairs:
            planned, by_chance = errors(exact[0], machine, flow, scenarios), errors(exact[1], machine, flow, operators)
            middle = np.median(by_chance, axis=0)
            rows.append(
                [truth, name, *(f"{mm:.0f}" for mm in planned[:, 0]), f"{middle[0]:.0f}", f"{by_chance[:, 0].max():.0f}",
                 f"{middle[1]:.2f}", f"{middle[2]:.1f}"]
            )  # fmt: skip
            print(rows[-1], file=sys.stderr, flush=True)
    heads = ["truth", "machine", *SCENARIOS, f"{len(operators)} operators, median", "worst", "angles, deg rms", "pressures, bar rms"]  # fmt: skip
    table(f"Largest distance of the tip, mm, and state errors of operators; {seconds / 60.0:g} min of log", heads, rows)
    table("Effects identified", ["truth", "number", "found", "standard error"], numbers)
    heads = ["truth", "machine", "function", "left of the pump's flow", "with a network", "proved range", "kept"]
    table("Flows that circuits do not have at the driven spools, on blocks of time held out", heads, left)


if __name__ == "__main__":
    main()
