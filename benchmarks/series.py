"""Cost of n valves in series next to the two that have a closed form: single circuits, and lanes of 64 with the passes outside of the lane loop.

``python benchmarks/series.py`` prints and asserts nothing. States are random spools of the machine's valves and random port pressures;
every result is summed. What the certificate refuses is repaired inside of the times; how many that are stands behind them.
"""

import importlib.util
import re
import sys
import tempfile
from pathlib import Path

import numpy as np

from polydraulic import load_machine
from polydraulic.machine.circuits.series.text import SERIES_IMPORTS, series_text
from polydraulic.simulation.layout.prepare import prepare_layout
from polydraulic.thesis.excavator import pump_of, with_pumps
from polydraulic.thesis.timing import PAIRED, paired_times
from show import show

BLOCKS, LANES, ROWS = 100, 64, 52  # numbers of lanes side by side in a flat array, rows of a block

HAND = """

@kernel
def of_all(s):
    c = s.circuit
    return s.q_in_1 + s.q_in_2 + s.p_between_1 + c.q_pump + c.q_bypass + c.q_relief + c.p_pump


@driver
def single(rows, pump):
    total = 0.0
    for block in range(BLOCKS):
        part = rows[block * ROWS * LANES:]
        for lane in range(LANES):
            total += of_all(series_2(VALVES, pump))
    return total


@driver
def lanes(rows, pump):
    total = 0.0
    for block in range(BLOCKS):
        part = rows[block * ROWS * LANES:]
        for lane in range(LANES):
            part[RESULT * LANES + lane] = of_all(series_2_at(pump.flow, VALVES, pump))
        for lane in range(LANES):
            total += part[RESULT * LANES + lane]
    return total
"""

GENERATED = """

@kernel
def of_all(s):
    c = s.circuit
    return FLOWS + c.q_pump + c.q_bypass + c.q_relief + c.p_pump


@kernel
def put(part, lane, x):
PUT


@driver
def single(rows, pump):
    total = 0.0
    for block in range(BLOCKS):
        part = rows[block * ROWS * LANES:]
        for lane in range(LANES):
            total += of_all(series_N(VALVES, pump))
    return total


@driver
def repaired(rows, pump):
    count = 0
    for block in range(BLOCKS):
        part = rows[block * ROWS * LANES:]
        for lane in range(LANES):
            count += series_N(VALVES, pump).status
    return count


@kernel
def lanes_alone(part, pump):
    for lane in range(LANES):
        put(part, lane, series_N_begin(pump))
        path = series_N_path(ORIFICES)
PUT_PATH
    for _ in range(PASSES):
        left = 0
        for lane in range(LANES):
            x = series_N_pass(PassedN(GET), PathN(GET_PATH), PORTS, pump)
            put(part, lane, x)
            left += 0 if x.still else 1
        if left == 0:
            break
    for lane in range(LANES):
        s = series_N_end(PassedN(GET), PathN(GET_PATH), VALVES, pump)
        part[STATUS * LANES + lane] = s.status
        part[RESULT * LANES + lane] = of_all(s)


@driver
def unrepaired(rows, pump):
    for block in range(BLOCKS):
        lanes_alone(rows[block * ROWS * LANES:], pump)


@driver
def lanes(rows, pump):
    total = 0.0
    for block in range(BLOCKS):
        part = rows[block * ROWS * LANES:]
        lanes_alone(part, pump)
        for lane in range(LANES):
            if part[STATUS * LANES + lane] != 0.0:
                part[RESULT * LANES + lane] = of_all(series_N_repair(VALVES, pump))
            total += part[RESULT * LANES + lane]
    return total
"""


def circuit(name, n, text, folder):
    """Loops over n valves; a block's rows are conductances and port pressures, what passes leave and read, status and result."""
    orifices = [f"Orifices(part[{2 * j} * LANES + lane], part[{2 * j + 1} * LANES + lane], 0.0)" for j in range(n)]
    ports = [f"part[{2 * n + j} * LANES + lane]" for j in range(n)]
    fields = ["q_pump", "least", "dq", *(f"{letter}_{j}" for letter in ("w", "dw") for j in range(1, n)), "largest"]
    resistances = [f"{letter}_{j}" for letter in "ab" for j in range(1, n + 1)]
    flows = [*(f"s.q_in_{j}" for j in range(1, n + 1)), *(f"s.p_between_{j}" for j in range(1, n))]
    rows = [f"part[{3 * n + i} * LANES + lane]" for i in range(len(fields) + 1 + len(resistances))]
    places, still = dict(zip(fields, rows, strict=False)), rows[len(fields)]
    path = dict(zip(resistances, rows[len(fields) + 1 :], strict=True))
    words = {
        "VALVES": ", ".join([*orifices, *ports]),
        "ORIFICES": ", ".join(orifices),
        "PORTS": ", ".join(ports),
        "PUT_PATH": "\n".join(f"        {place} = path.{field}" for field, place in path.items()),
        "GET_PATH": ", ".join(path.values()),
        "FLOWS": " + ".join(flows),
        "PUT": "\n".join([*(f"    {place} = x.{field}" for field, place in places.items()), f"    {still} = x.still"]),
        "GET": ", ".join([*places.values(), f"{still} > 0.0"]),
        "BLOCKS": str(BLOCKS),
        "ROWS": str(ROWS),
        "STATUS": str(ROWS - 2),
        "RESULT": str(ROWS - 1),
        "LANES": str(LANES),
    }
    for word, meant in words.items():
        text = re.sub(rf"\b{word}\b", meant, text)
    text = re.sub(r"(?<=series_)N\b|(?<=series_)N(?=_)|(?<=Passed)N\b|(?<=Path)N\b", str(n), text)
    imports = [
        *SERIES_IMPORTS,
        "from polydraulic._kernel import driver",
        "from polydraulic.machine.circuits.series.short import series_2, series_2_at",
        "from polydraulic.machine.valve import Orifices",
    ]
    path = Path(folder) / f"benchmark_{name}.py"
    path.write_text("\n".join(imports) + "\n\n\n" + series_text(n) + text)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module


def random_states(machine, n, rng):
    """Blocks of lanes with random valves and port pressures."""
    ready, knots = prepare_layout(machine, 5e-3), machine.functions[0].valve.knots
    tables = [ready.valves.valve_swing, ready.valves.valve_stick, ready.valves.valve_boom]
    orifices = getattr(ready.module, f"orifices_{len(knots)}")
    rows = np.zeros((BLOCKS, ROWS, LANES))
    for j in range(n):
        spools = rng.uniform(0.0, knots[-1], (BLOCKS, LANES))
        found = np.array([[orifices(x, tables[j % 3])[:2] for x in block] for block in spools])
        rows[:, 2 * j], rows[:, 2 * j + 1] = found[:, :, 0], found[:, :, 1]
    rows[:, 2 * n : 3 * n] = rng.uniform(0.0, pump_of(machine, "boom").relief, (BLOCKS, n, LANES))
    return rows.ravel()


def packed(function):
    """Divisions and roots of a compiled loop that take several lanes at once, and those that take one."""
    text = function.inspect_asm(function.signatures[0])
    single = len(re.findall(r"\tv?(?:div|sqrt)sd\t", text))
    wide = len(re.findall(r"\tv(?:div|sqrt)pd\t[^\n]*%[yz]mm", text))
    return f"{wide} packed, {single} single divisions and roots without repair"


def main():
    machine, rng, per = load_machine("cat215b"), np.random.default_rng(0), BLOCKS * LANES
    by_hand, numbers = "2 valves, by hand", (2, 3, 4, 6)
    names = {n: f"{n} valves" for n in numbers}
    with tempfile.TemporaryDirectory() as folder:
        hand = circuit("hand", 2, HAND, folder)
        made = {n: circuit(f"series_{n}", n, GENERATED, folder) for n in numbers}
        states = {n: random_states(machine, n, rng) for n in numbers}
        for limited in (False, True):
            pump = prepare_layout(with_pumps(machine, torque_limit_enabled=limited), 5e-3).valves.pump_series
            calls = {by_hand: lambda pump=pump: hand.single(states[2], pump)}
            calls |= {names[n]: lambda n=n, pump=pump: made[n].single(states[n], pump) for n in numbers}
            notes = {names[n]: f"{made[n].repaired(states[n], pump)} of {per} repaired" for n in numbers}
            title = f"single circuits{', torque limit' if limited else ''}: {PAIRED}"
            show(title, paired_times(calls), "ns", per=per, notes=notes)
        pump = prepare_layout(machine, 5e-3).valves.pump_series
        calls = {by_hand: lambda: hand.lanes(states[2], pump)}
        calls |= {names[n]: lambda n=n: made[n].lanes(states[n], pump) for n in numbers}
        for n in numbers:
            made[n].unrepaired(states[n], pump)
        times = paired_times(calls)
        notes = {names[n]: packed(made[n].unrepaired) for n in numbers}
        show(f"lanes of {LANES}: {PAIRED}", times, "ns", per=per, notes=notes)


if __name__ == "__main__":
    main()
