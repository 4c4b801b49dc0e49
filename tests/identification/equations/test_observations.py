import numpy as np
import pytest

from polydraulic import load_machine, random_operator, simulate
from polydraulic.identification.equations.circuits import balances
from polydraulic.identification.equations.observations import blocks_of_time, mean_weights, windows
from polydraulic.identification.equations.sensors import read_function
from polydraulic.tables import Table


def test_windows_stay_within_segments():
    found = windows(np.array([0] * 7 + [1] * 4 + [2] * 2), 4)
    assert found.tolist() == [[0, 1, 2, 3], [3, 4, 5, 6], [7, 8, 9, 10]]
    assert windows(np.array([0, 0, 1]), 1).ravel().tolist() == [0, 1, 2]
    assert mean_weights(1).tolist() == [1.0]
    assert mean_weights(3) @ [1.0, 2.0, 3.0] == pytest.approx(2.0)


@pytest.mark.parametrize(("seconds", "last", "length"), [(580.0, 19, 29.0), (630.0, 20, 30.0)])
def test_blocks_of_time_are_twenty_or_last_half_a_minute(seconds, last, length):
    time = 5.0 + 0.5 * np.arange(2 * int(seconds))
    block = blocks_of_time(time)
    assert block[-1] == last
    assert np.bincount(block)[:-1] == pytest.approx(2 * length, abs=1)
    assert blocks_of_time(np.zeros(3)).tolist() == [0, 0, 0]


def test_flows_of_silent_sensors_are_not_known():
    machine = load_machine("cat215b")
    run = simulate(load_machine("cat215b"), "exact", random_operator(5, 10.0), raster=0.02)
    names = [f"{f}.{what}" for f in machine.names for what in ("spool", "p_a", "p_b", "q_in", "q_out", "angle")]
    columns = {"time": run["time"], **{name: run[name].copy() for name in names}}
    columns["boom.q_in"][100:200] = np.nan
    columns["boom.angle"][300:400] = np.nan
    log, segment = Table(columns, {}).partial(), np.zeros(len(run), dtype=np.int64)
    signals = {f.name: read_function(machine, f, log, segment, 0.02, False) for f in machine.functions}
    boom = balances(machine, machine.names, signals, segment, 0.02)["boom"]
    assert np.flatnonzero(~boom.known_in).tolist() == list(range(100, 200))
    assert boom.known_out.all()
    assert np.all(boom.q_in[100:200] == 0.0)
    without = {
        name: s._replace(values={what: v for what, v in s.values.items() if what != "q_in"})
        for name, s in signals.items()
    }
    windows = balances(machine, machine.names, without, segment, 0.02)["boom"]
    over = ((windows.rows[:, 0] >= 300) & (windows.rows[:, 0] < 400)) | (
        (windows.rows[:, -1] >= 300) & (windows.rows[:, -1] < 400)
    )
    assert not windows.known_in[over].any()
    assert np.isfinite(windows.q_in).all()


def test_balanced_flows_are_those_that_were_simulated():
    machine = load_machine("cat215b")
    run = simulate(load_machine("cat215b"), "exact", random_operator(5, 40.0), raster=0.02)
    names = [f"{f}.{what}" for f in machine.names for what in ("spool", "p_a", "p_b", "angle")]
    log = Table({"time": run["time"], **{name: run[name] for name in names}}, {})
    segment = np.zeros(len(log), dtype=np.int64)
    signals = {f.name: read_function(machine, f, log, segment, 0.02, False) for f in machine.functions}
    for name, of in balances(machine, machine.names, signals, segment, 0.02).items():
        flows = [run[f"{name}.{port}"][of.rows] @ mean_weights(of.rows.shape[1]) for port in ("q_in", "q_out")]
        for known, ours, exact in zip((of.known_in, of.known_out), (of.q_in, of.q_out), flows, strict=True):
            assert known.sum() > 20
            assert np.median(np.abs(ours - exact)[known]) < 0.01 * machine.circuits[0].pump.flow, name


def test_balanced_flows_are_closer_with_the_clocks_of_a_simulation():
    """A step moves the joint by the rate at its end, and fills lines by the rate at its start: positions are a step ahead."""
    machine = load_machine("cat215b")
    run = simulate(machine, "exact", random_operator(5, 60.0), raster=0.02)
    segment = np.zeros(len(run["time"]), dtype=np.int64)
    log = Table({name: run[name] for name in run.names if ".q_" not in name}, {})
    signals = {f.name: read_function(machine, f, log, segment, 0.02, False) for f in machine.functions}
    for name, of in balances(machine, machine.names, signals, segment, 0.02).items():
        exact = run[f"{name}.q_in"][of.rows] @ mean_weights(of.rows.shape[1])
        off = [(of.q_in + of.rates_in @ leads - exact)[of.known_in] for leads in ((0.0, 0.0), (0.0, -0.005))]
        assert np.sqrt(np.mean(off[1] ** 2)) < 0.75 * np.sqrt(np.mean(off[0] ** 2)), name
