"""Columns, rasters, files and comparison of trajectories."""

import dataclasses

import numpy as np
import pytest

from polydraulic import compare, load_scenario, simulate
from polydraulic.errors import InputError
from polydraulic.tables import read_table, write_table
from polydraulic.thesis.excavator import LINKS

OF_A_LINK = {
    "voltage": "V", "spool": "m", "p_a": "Pa", "p_b": "Pa", "angle": "rad", "rate": "rad/s", "q_in": "m3/s",
    "q_out": "m3/s", "p_in": "Pa", "p_out": "Pa",
}  # fmt: skip
OF_A_CIRCUIT = {"q_pump": "m3/s", "q_bypass": "m3/s", "q_relief": "m3/s", "p_pump": "Pa"}


def test_every_link_and_circuit_has_its_columns(whole):
    expected = {"time": "s", "series.p_between": "Pa"} | {f"effector.{axis}": "m" for axis in "xyz"}
    expected |= {f"{link}.{name}": unit for link in LINKS for name, unit in OF_A_LINK.items()}
    expected |= {f"{circuit}.{name}": unit for circuit in ("boom", "series") for name, unit in OF_A_CIRCUIT.items()}
    assert whole["exact"].units == expected
    assert set(whole["exact"].names) == set(expected)
    assert all(len(whole["exact"][name]) == 121 for name in expected)


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_run_comes_back_from_a_file_to_the_last_bit(whole, tmp_path, ending):
    run = whole["iterative"]
    write_table(run, tmp_path / f"run.{ending}")
    found = read_table(tmp_path / f"run.{ending}")
    assert found.names == run.names
    assert found.units == run.units
    assert all(np.array_equal(found[name], run[name]) for name in run.names)
    assert found.info == (run.info if ending == "parquet" else {})


def test_a_raster_in_seconds_thins_the_rows(machine, whole):
    thin = simulate(machine, "exact", load_scenario("task"), t_end=0.6, raster=0.02)
    assert thin["time"] == pytest.approx(np.arange(31) * 0.02)
    assert all(np.array_equal(thin[name], whole["exact"][name][::4]) for name in thin.names if name != "time")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"raster": 0.012}, "raster = 0.012 s: must be a whole number of time steps of 0.005 s, for example 0.05"),
        ({"raster": 0.0}, "raster = 0.0 s"),
        ({"raster": -0.01}, "raster = -0.01 s"),
        ({"raster": float("nan")}, "raster = nan s"),
        ({"raster": 0.01, "every": 2}, "every = 2 and raster = 0.01 s both say when to record"),
        ({"raster": 0.01, "dt": 0.0}, "dt = 0.0 s"),
    ],
)
def test_bad_rasters_are_named(machine, options, message):
    with pytest.raises(InputError, match=message):
        simulate(machine, "exact", load_scenario("task"), **options)


def test_comparison_states_how_far_the_tips_are_apart(whole):
    exact = whole["exact"]
    columns = {name: values.copy() for name, values in exact.columns.items()}
    columns["effector.x"][10] += 0.3
    columns["effector.z"][10] -= 0.4
    columns["effector.y"][-1] += 0.1
    found = compare(exact, dataclasses.replace(exact, columns=columns))
    tip = found["effector.distance"]
    assert (tip.unit, tip.time) == ("m", pytest.approx(0.05))
    assert tip.largest == pytest.approx(0.5)
    assert tip.final == pytest.approx(0.1)
    assert tip.rms == pytest.approx(np.sqrt(0.26 / 121))
    assert set(found) == {*exact.names} - {"time"} | {"effector.distance"}
    assert found["boom.angle"].largest == 0.0
