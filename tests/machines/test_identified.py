"""Machines that were identified from a short log are good files, and run for as long as others."""

import numpy as np
import pytest

from helpers.operator_log import operator_log
from polydraulic import load_machine, random_operator, simulate
from polydraulic.identification import identify
from polydraulic.parameters.load import machine_names
from polydraulic.tables import Table

OFF = {"inlet": 1.3, "bypass": 0.8, "outlet_positive": 1.3, "outlet_negative": 0.7, "gain": 1.1, "flow": 1.05}
PIECES, SECONDS = 6, 600.0


def served():
    """Machines whose circuits `identify` knows."""
    return [name for name in machine_names() if all(c.kind == "series" for c in load_machine(name).circuits)]


def log_of(name, sensors):
    """Of an operator who does not drive spools to their ends."""
    log = operator_log(name, seconds=200.0, seed=77)
    if sensors == "all":
        return log
    few = [n for n in log.names if n == "time" or n.endswith((".voltage", ".angle", ".position"))]
    return Table({n: log[n] for n in few}, {n: log.unit(n) for n in few})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "sensors"),
    [*((name, "all") for name in served()), *((name, "commands") for name in ("wheel_loader", "cat215b_crossover"))],
)
def test_an_hour_of_random_operators(name, sensors, call, tmp_path):
    true, path = load_machine(name), tmp_path / "identified.toml"
    ends = {n.path: OFF.get(n.path.partition("[")[0].rpartition(".")[2], 1.0) for n in true.numbers}
    start = true.with_values({n.path: ends[n.path] * n.value for n in true.numbers if ends[n.path] != 1.0})
    identify(log_of(name, sensors), start).write(path)
    code, out, _ = call("machine", "check", str(path))
    assert code == 0
    assert out.rstrip().endswith(": good")
    machine, beyond = load_machine(path), 0
    for seed in range(PIECES):
        operator = random_operator(500 + seed, SECONDS, limit=1.0, functions=machine.names)
        run = simulate(machine, "exact", operator, every=20)
        assert run.info["steps_not_converged"] < 1e-3 * run.info["steps"]  # held at the last pass, and counted
        beyond += run.info["steps_beyond_log"]
        for f in machine.functions:
            place = "position" if machine.link(f.moves).joint == "prismatic" else "angle"
            assert np.all(run[f"{f.name}.{place}"] >= f.stops.low - 1e-6)
            assert np.all(run[f"{f.name}.{place}"] <= f.stops.high + 1e-6)
            for port in ("p_a", "p_b"):
                assert np.all(run[f"{f.name}.{port}"] <= f.line.relief * (1.0 + 1e-9))
        assert all(np.isfinite(run[column]).all() for column in run.names)
    assert beyond > 0  # these operators go further than the one who was logged
