"""The kernels of a block: the same bits without the compiler, and circuits of any length as they are solved elsewhere."""

import numpy as np
import pytest

from helpers.small_crane import write_crossover_crane
from polydraulic import load_machine
from polydraulic._kernel import in_plain_python
from polydraulic.flow.layout.circuit_sample import solved_valves
from polydraulic.machine.circuits.crossover.circuit import CrossoverOrifice, crossover_3, crossover_4
from polydraulic.machine.pump import limited_pump
from polydraulic.machine.valve import Orifices
from polydraulic.parameters.layout.schema import position_column
from polydraulic.watch.block import AlarmTests, BlockJudge, kernels_of
from polydraulic.watch.kernels.alarms import BEGINS, GOES_ON, NONE
from polydraulic.watch.kernels.numbers import HEAD_OF_LIVE
from polydraulic.watch.kernels.rows import JUDGED, TAKEN
from polydraulic.watch.kernels.signals import NOTHING, is_known
from polydraulic.watch.kernels.stays import FLAT
from polydraulic.watch.kernels.text import block_text
from polydraulic.watch.kernels.windows import volume_balance
from polydraulic.watch.residuals import Residuals, case_of
from polydraulic.watch.watched import plan_of, watched

SENSORS = ("voltage", "spool", "p_a", "p_b", "q_in", "q_out")


def made_rows(of, rng):
    """A block of smooth signals within what sensors of the machine may read."""
    time = np.arange(of.shape.rows) * of.shape.raster
    rows = np.zeros((len(time), 1 + len(of.columns)))
    rows[:, 0] = time
    for k, column in enumerate(of.columns, 1):
        owner, _, what = column.partition(".")
        f = of.machine.functions[0] if what == "p_pump" else of.machine.function(owner)
        wave = np.sin(2.0 * time + rng.uniform(0.0, 6.0)) + rng.normal(0.0, 1e-3, len(time))
        middle, half = 0.5 * (f.stops.low + f.stops.high), 0.2 * (f.stops.high - f.stops.low)
        rows[:, k] = {
            "voltage": 0.7 + 0.2 * wave,
            "spool": (0.7 + 0.2 * wave) * f.pilot.gain,
            "p_a": 60e5 + 20e5 * wave,
            "p_b": 40e5 + 20e5 * wave,
            "p_pump": 90e5 + 20e5 * wave,
            "q_in": 1e-3 + 2e-4 * wave,
            "q_out": 1e-3 + 2e-4 * wave,
        }.get(what, middle + half * wave)
    return rows


def test_a_block_has_the_same_bits_in_plain_python():
    machine = load_machine("wheel_loader")
    columns = [f"{f.name}.{what}" for f in machine.functions for what in SENSORS]
    columns += [position_column(machine, f) for f in machine.functions]
    of = watched(machine, columns, 0.05)
    noise = {c: 1e5 if ".p_" in c else 8e-6 if ".q_" in c else 1e-4 for c in columns}
    n = len(of.directions)
    judge = BlockJudge(plan_of(of, noise), [(0.0, 1.0)] * len(of.channels), np.full(n, 0.01), np.full(n, 0.01))
    judge.rows[:] = made_rows(of, np.random.default_rng(2))
    judge.judge()
    results = [judge.work, judge.states]
    kept = [values.copy() for values in results]
    assert np.all(np.isfinite(judge.pull))
    assert np.all(judge.white_information >= 0.0)
    assert np.sum(judge.white_information > 0.1) > 0.7 * n
    assert FLAT not in judge.states
    for values in results:
        values[:] = 0
    in_plain_python(judge.kernels.judge_block)(judge.numbers, judge.work, judge.live, judge.marks)
    assert all(np.array_equal(a, b) for a, b in zip(kept, results, strict=True))


def test_rows_have_the_same_bits_in_plain_python():
    machine = load_machine("wheel_loader")
    columns = [f"{f.name}.{what}" for f in machine.functions for what in ("spool", "voltage")]
    of = watched(machine, columns, 0.1)
    n, rng = len(of.directions), np.random.default_rng(5)
    tests = AlarmTests(np.ones(n), np.full(n, 0.05), 1.0, 4.0, [2] * len(columns))
    watches = [
        BlockJudge(
            plan_of(of, dict.fromkeys(columns, 1e-4)),
            [(1e-9, 1.0)] * len(of.channels),
            np.zeros(n),
            np.full(n, 0.01),
            tests,
        )
        for _ in range(2)
    ]
    whole = in_plain_python(watches[1].kernels.watch_row)
    became = []
    for k in range(200):
        f = machine.functions[0]
        row = np.array([0.5e-3 * np.sin(0.3 * k), 0.1 * np.sin(0.3 * k)] * (len(columns) // 2)) + rng.normal(
            0.0, 1e-4, len(columns)
        )
        row[0] += 0.2 * f.valve.knots[-1] if k > 60 else 0.0
        judge = watches[1]
        became.append(watches[0].row(0.1 * k, row))
        assert became[-1] == whole(judge.numbers, judge.work, judge.live, judge.marks, 0.1 * k, row)
    assert {TAKEN, JUDGED + NONE, JUDGED + BEGINS, JUDGED + GOES_ON} <= set(became)
    assert np.array_equal(watches[0].live, watches[1].live)
    assert np.array_equal(watches[0].marks, watches[1].marks)


def flows_in(machine, functions):
    """What a plan finds to flow into actuators whose spools rest at 0.6 of their travel, (n_row, n); pumps' pressures, ports, and those travels."""
    columns = [f"{f}.{what}" for f in functions for what in ("spool", "p_a", "p_b", "q_in")]
    pumps = [f"{c.name}.p_pump" for c in machine.circuits if set(c.functions) <= set(functions)]
    columns += pumps
    of = watched(machine, columns, 0.05)
    residuals = Residuals(columns, of.shape, of.channels)
    own, rows = residuals.of(case_of(machine)), made_rows(of, np.random.default_rng(3))
    for f in functions:  # still spools, since sensors are smoothed
        rows[:, 1 + columns.index(f"{f}.spool")] = 0.6 * machine.function(f).valve.knots[-1]
    arrays = residuals.plan.arrays()
    work, kernels = np.zeros(arrays.size), kernels_of(machine)
    live = np.concatenate([np.zeros(HEAD_OF_LIVE), rows.ravel()])
    kernels.run_plan(arrays.ints, arrays.floats, live, work)
    judged, names = rows[of.shape.judged], [channel.name for channel in of.channels]

    def made(column):
        begin = own[names.index(column)]
        return judged[:, 1 + columns.index(column)] - work[begin : begin + of.shape.inside]

    flows, pressures = (np.column_stack([*map(made, some)]) for some in ([f"{f}.q_in" for f in functions], pumps))
    ports = judged[:, [1 + columns.index(f"{f}.p_a") for f in functions]]
    return flows, pressures, ports, [0.6 * machine.function(f).valve.knots[-1] for f in functions]


@pytest.mark.parametrize(
    ("name", "valves"), [("wheel_loader", 2), pytest.param("excavator_22t", 3, marks=pytest.mark.slow)]
)
def test_flows_and_the_pumps_pressure_are_those_of_the_circuit(name, valves):
    machine = load_machine(name)
    c = next(c for c in machine.circuits if len(c.functions) >= valves)
    flows, pressures, ports, travels = flows_in(machine, c.functions)
    curves = [machine.function(f).valve for f in c.functions]
    pump = limited_pump(c.pump.flow, c.pump.relief, machine.tank.return_pressure, c.pump)
    sample, proved = solved_valves(curves, pump, np.array([travels] * len(ports)), ports)
    assert proved.all()
    assert flows == pytest.approx(sample.q_in, rel=1e-9, abs=1e-12)
    assert pressures[:, 0] == pytest.approx(sample.p_pump, rel=1e-9)
    assert np.all(pressures > machine.tank.return_pressure)


@pytest.mark.slow_to_compile
@pytest.mark.parametrize("valves", [3, 4])
def test_flows_are_those_of_circuits_that_a_crossover_joins(valves, tmp_path):
    machine = load_machine(write_crossover_crane(tmp_path) if valves == 3 else "cat215b_crossover")
    x, solve = machine.crossovers[0], crossover_3 if valves == 3 else crossover_4
    both = [machine.circuit(x.giving), machine.circuit(x.taking)]
    functions = [f for c in both for f in c.functions]
    flows, pressures, ports, travels = flows_in(machine, functions)
    curves = [machine.function(f).valve for f in functions]
    opened = [
        Orifices(float(np.interp(at, v.knots, v.inlet)), float(np.interp(at, v.knots, v.bypass)), 0.0)
        for at, v in zip(travels, curves, strict=True)
    ]
    conductance = float(np.interp(travels[-1], curves[-1].knots, x.valve.conductance))
    pumps = [limited_pump(c.pump.flow, c.pump.relief, machine.tank.return_pressure, c.pump) for c in both]
    crossing, passed = CrossoverOrifice(conductance, x.valve.opening_pressure), 0
    for row, pressed, port in zip(flows, pressures, ports.tolist(), strict=True):
        found = solve(crossing, *opened, *port, *pumps)
        giving = [found.giving.q_in_1] if valves == 3 else [found.giving.q_in_1, found.giving.q_in_2]
        assert row == pytest.approx([*giving, found.taking.q_in_1, found.taking.q_in_2], rel=1e-9, abs=1e-12)
        assert pressed == pytest.approx([found.giving.circuit.p_pump, found.taking.circuit.p_pump], rel=1e-9)
        passed += found.q_cross > 0.0
    assert passed > 0


@pytest.mark.parametrize("relief", [300e5, 101e5, 50e5])
def test_a_balance_of_flows_that_are_not_known_is_not_known(relief):
    """Near and beyond a relief setting what is let go is found from the same flows."""
    n, long = 5, 4
    work, numbers = np.zeros(8 * n), np.array([0.1, 0.0, 0.0, 0.0, relief, 5e5, 5e-5])
    # volume, pressure, smoothed pressure, the other pressure, spool, flow in and flow out
    work[n : 3 * n], work[5 * n : 6 * n] = 100e5, 1e-3
    ints = np.array([7 * n, 1, 0, n, 2 * n, 3 * n, 4 * n, 5 * n, 6 * n, 0, long, 1, 0])
    volume_balance(ints, numbers, work, 0)
    assert is_known(work[7 * n])
    work[5 * n + 2] = NOTHING
    volume_balance(ints, numbers, work, 0)
    assert not is_known(work[7 * n])


def test_texts_hold_the_circuits_that_are_asked_for():
    assert "def circuit_3" in block_text((1, 3))
    assert "def circuit_2" not in block_text((1, 3))
    assert "def crossing_4" in block_text((1,), (4,))
    assert "crossover" not in block_text((1, 3))
