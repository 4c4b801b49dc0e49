"""A machine identified from recorded logs of a known one: how far its tip is from the true machine's.

``python benchmarks/identify.py [--quick] [--seed N]``: it prints Markdown tables and asserts nothing. The machine to begin from knows of each
valve where it opens, where its bypass closes and its full travel, with straight lines between conductances that are off by up to half; its
pumps give 5 % too much, its pilots are off by 10 and 20 %. Sensors are those of `record --example`. The seed of the log is one that
nothing was chosen by; judges are chapter 8's operators, and the scenarios of cat215b. The same of a wheel loader, with its own cycle and operators.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from polydraulic import load_machine, load_scenario, random_operator, read_table, simulate
from polydraulic.identification import identify
from polydraulic.identification.log_replay import joints_of
from polydraulic.machine.frames import link_frames, placed
from polydraulic.measure import example_sensors, import_log, load_channels, load_sensors, record
from polydraulic.tables import Table
from polydraulic.thesis.rough_machine import rough_machine
from show import table

SCENARIOS = ("task", "sine", "step", "pulse")
LIMITED = ("task", "step")
UNITS = {"spool": "mm", "p_a": "bar", "p_b": "bar", "q_in": "l/min", "q_out": "l/min", "voltage": "V", "angle": "deg"}
RANGES = {"mm": [-16, 16], "bar": [-10, 500], "l/min": [-400, 800], "V": [-1.5, 1.5], "deg": [-99999, 99999]}
FULL, JUDGED = 1.1, 0.8  # V: full travel of all spools, and of the operators who judge
OTHER, OTHER_FULL, OTHER_SCENARIO = "wheel_loader", 0.86, "wheel_loader_cycle"


def recorded(machine, folder, seed, seconds, limit):
    """An imported log of an operator who gives at most `limit` volts."""
    sensors, raw, channels, out = (folder / name for name in ("sensors.toml", "raw.parquet", "map.toml", "log.parquet"))
    sensors.write_text(example_sensors(machine=machine).replace("seed = 1", f"seed = {seed}"))
    record(machine, [random_operator(seed, seconds, limit=limit, functions=machine.names)], load_sensors(sensors), raw)
    lines = ['raster = "20 ms"', "[[channel]]", 'source = "time"', 'role = "time"', 'unit = "s"']
    for name in machine.names:
        for what, unit in UNITS.items():
            role = "output" if what in ("q_in", "q_out", "angle") else "input"
            lines += [
                "[[channel]]",
                f'source = "{name}.{what}"',
                f'role = "{role}"',
                f'unit = "{unit}"',
                f"range = {RANGES[unit]}",
            ]
    channels.write_text("\n".join(lines) + "\n")
    import_log(raw, load_channels(channels), out)
    return read_table(out)


def limited(machine):
    """The same with a torque limit of its pumps."""
    return machine.with_values({f"{c.pump_path}.torque_limit_enabled": True for c in machine.circuits})


def distance(true, other, scenario):
    """Largest distance of the tips, mm."""
    columns = [joint.column for joint in joints_of(true)]
    tips = [placed(link_frames(m, simulate(m, "exact", scenario).matrix(columns)), *m.tip) for m in (true, other)]
    return 1e3 * float(np.linalg.norm(tips[0] - tips[1], axis=1).max())


def identified(true, seed, seconds, limit, flows):
    """The machine that an identification makes of a rough one and a log of the true one, with sensors of flow or without."""
    start = rough_machine(true, np.random.default_rng(seed))
    with tempfile.TemporaryDirectory() as folder:
        log = recorded(true, Path(folder), seed, seconds, limit)
    if not flows:
        log = Table({n: v for n, v in log.columns.items() if ".q_" not in n}, log.units, log.info)
    began = time.perf_counter()
    found = identify(log, start)
    print(f"{len(log)} rows, {time.perf_counter() - began:.0f} s", file=sys.stderr, flush=True)
    for line in (*found.remarks, *found.kept):
        print(f"  {line}", file=sys.stderr, flush=True)
    return found.machine


def judged(name, true, machine, scenarios, torque_limited, judges):
    """A row of the table: distances of the tips, and their median and largest over operators."""
    away = [distance(true, machine, load_scenario(s)) for s in scenarios]
    away += [distance(limited(true), limited(machine), load_scenario(s)) for s in torque_limited]
    operators = [random_operator(seed, 60.0, limit=JUDGED, functions=true.names) for seed in judges]
    by_chance = [distance(true, machine, operator) for operator in operators]
    row = [name, *(f"{mm:.1f}" for mm in (*away, np.median(by_chance), max(by_chance)))]
    print(row, file=sys.stderr, flush=True)
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="5 minutes of log, two operators")
    parser.add_argument("--seed", type=int, default=3011, help="of the operator who is recorded")
    options = parser.parse_args()
    seconds, judges = (300.0, range(4000, 4002)) if options.quick else (1800.0, range(4000, 4010))
    of_operators = [f"{len(judges)} operators, median", "worst"]
    said = f"{seconds / 60.0:g} min of log"
    true = load_machine("cat215b")
    rows = [
        judged(name, true, identified(true, options.seed, seconds, limit, flows), SCENARIOS, LIMITED, judges)
        for name, limit, flows in (
            ("full stroke", FULL, True),
            ("no flow sensors", FULL, False),
            ("80 % of the stroke", 0.8 * JUDGED, True),
        )
    ]
    heads = ["log", *SCENARIOS, *(f"torque-limited {s}" for s in LIMITED), *of_operators]
    table(f"Largest distance of the tip from the true machine, mm; {said}", heads, rows)
    true = load_machine(OTHER)
    rows = [
        judged(name, true, identified(true, options.seed, seconds, OTHER_FULL, flows), (OTHER_SCENARIO,), (), judges)
        for name, flows in (("full stroke", True), ("no flow sensors", False))
    ]
    table(f"The same of {OTHER}, mm; {said}", ["log", OTHER_SCENARIO, *of_operators], rows)


if __name__ == "__main__":
    main()
