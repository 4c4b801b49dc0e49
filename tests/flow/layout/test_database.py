import numba
import numpy as np
import pytest

from polydraulic import InputError, load_machine
from polydraulic.flow import circuit_table, sample_circuit
from polydraulic.flow.layout.database import series_circuit_of
from polydraulic.identification import fit_table
from polydraulic.simulation.layout.flow_points import sample_flow


def test_columns_belong_together():
    plant = load_machine("loader_crane")
    table = sample_circuit(plant, "slew_and_reach", 500, rng=np.random.default_rng(1))
    c = plant.circuits[1]
    full = c.pump.flow
    for f in c.functions:
        assert np.array_equal(table[f"{f}.travel"], np.abs(table[f"{f}.spool"]))
        assert table[f"{f}.q_out"] == pytest.approx(table[f"{f}.k_out"] * table[f"{f}.root_p_out"])
        valve, at = plant.function(f).valve, table[f"{f}.spool"] < 0.0
        assert table[f"{f}.k_out"][at] == pytest.approx(
            np.interp(table[f"{f}.travel"][at], valve.knots, valve.outlet_negative)
        )
    first, second = table["slew_and_reach.q_passed_1"], table["slew_and_reach.q_passed_2"]
    assert np.all(table["reach.q_in"] + second <= first + 1e-9 * full)
    free = table["slew_and_reach.p_pump"] < c.pump.relief
    assert (table["slew.q_in"] + first)[free] == pytest.approx(full, rel=1e-9)
    assert np.all(first[table["slew.travel"] > 0.008] <= 1e-9 * full)  # past the closing of the bypass
    assert table.unit("slew_and_reach.q_passed_1") == "m3/s"
    assert table.info["circuit"] == "slew_and_reach"


def test_pressures_may_be_chosen_and_the_relief_valve_left_out():
    table = sample_circuit("wheel_loader", "work", 300, rng=np.random.default_rng(1), pressure=(1e5, 2e5), relief=False)
    assert table["lift.p_in"].min() >= 1e5
    assert table["lift.p_in"].max() <= 2e5
    total = table["tilt.q_in"] + table["work.q_passed"]
    assert np.ptp(total[table["work.p_pump"] < 1.8e7]) < 1e-12


def test_any_machine_has_its_own_circuits(machine):
    rng = np.random.default_rng(3)
    assert "boom.q_in" in sample_circuit(machine, None, 5, rng=rng).names  # the first one
    assert "lift.q_in" in sample_circuit("wheel_loader", None, 5, rng=rng).names


def test_a_table_at_given_points_is_that_of_the_whole_text(machine):
    """Next to the flow model by itself, whose kernels stand in the text of the step."""
    table = sample_circuit(machine, "series", 200, rng=np.random.default_rng(4))
    points = [np.zeros((200, 3)) for _ in range(3)]
    for array, what in zip(points, ("spool", "p_in", "p_out"), strict=True):
        array[:, [0, 2]] = table.matrix([f"{name}.{what}" for name in ("swing", "stick")])
    found = sample_flow(machine, "exact", *points)
    for place, name in ((0, "swing"), (2, "stick")):
        assert table[f"{name}.q_in"] == pytest.approx(found.q_in[:, place], abs=1e-12 * found.q_in.max())
        assert table[f"{name}.k_out"] == pytest.approx(found.k_out[:, place], rel=1e-12, abs=1e-20)
    assert table["series.p_pump"] == pytest.approx(found.p_pump[:, 1], rel=1e-9)
    assert found.q_bypass.shape == (200, 2)
    with pytest.raises(InputError, match=r"spool, p_in and p_out have shapes \(5, 3\)"):
        circuit_table(machine, "series", *np.zeros((3, 5, 3)))


def test_what_cannot_be_sampled_is_named(machine):
    rng = np.random.default_rng(1)
    with pytest.raises(InputError, match="rows = 0: must be at least 1"):
        sample_circuit("wheel_loader", "work", 0, rng=rng)
    with pytest.raises(InputError, match=r"unknown circuit 'boom'; choose one of \['work'\]"):
        sample_circuit("wheel_loader", "boom", 5, rng=rng)
    with pytest.raises(InputError, match=r"unknown circuit 'work'; choose one of \['boom', 'series'\]"):
        sample_circuit(machine, "work", 5, rng=rng)
    for circuit in (None, "main_giving"):
        with pytest.raises(
            InputError, match="'main_giving' is of the kind 'crossover'; .*, of which this machine has none"
        ):
            sample_circuit("cat215b_crossover", circuit, 5, rng=rng)
    plant = load_machine("loader_crane")
    joined = plant._replace(circuits=(plant.circuits[0], plant.circuits[1]._replace(kind="crossover")))
    assert "inner.q_in" in sample_circuit(joined, None, 5, rng=rng).names  # the one that there is
    for circuit in ("slew_and_reach", "boom"):
        with pytest.raises(InputError, match=r"choose one of \['lift'\]"):
            sample_circuit(joined, circuit, 5, rng=rng)
    plant = load_machine("wheel_loader")
    other = plant._replace(circuits=(plant.circuits[0]._replace(kind="shared"),))
    with pytest.raises(
        InputError, match="circuit 'work' is of the kind 'shared'; databases and networks are of valves"
    ):
        series_circuit_of(other, "work")


@pytest.mark.skipif(
    bool(numba.config.DISABLE_JIT), reason="networks grow slowly in plain Python; tests of their kernels run in it"
)
def test_a_sampled_table_is_what_fit_takes():
    table = sample_circuit("wheel_loader", "work", 400, rng=np.random.default_rng(1))
    found = fit_table(table, ["work.q_passed", "lift.travel", "lift.p_in"], ["lift.q_in"])
    assert [v.name for v in found.models[0].inputs] == ["work.q_passed", "lift.travel", "lift.p_in"]
