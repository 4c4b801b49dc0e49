"""Doubtful inputs are named: voltages in a wrong unit, parts of a scenario that come after its end."""

import numpy as np
import pytest

from polydraulic import load_scenario, simulate, simulate_batch
from polydraulic.parameters.load import load_machine
from polydraulic.parameters.loads import Loads, Payload
from polydraulic.parameters.scenario import Scenario, scenario_machine, scenario_names
from polydraulic.parameters.signals import Constant, Piecewise, Sine
from polydraulic.simulation.input_check import input_warnings, voltage_warnings
from polydraulic.simulation.summary import warnings

FULL = {"boom": 0.7, "stick": 1.0}


@pytest.mark.parametrize(
    "signal", [Constant(-300.0), Sine(300.0, 1.0), Piecewise(np.array([0.0, 1.0]), np.array([0.0, 300.0]))]
)
def test_a_voltage_far_beyond_full_lever_is_named(signal):
    (found,) = input_warnings(Scenario("s", 2.0, {"boom": signal}), FULL)
    assert found == "boom: the lever's voltage reaches 300 V, and 0.7 V gives full travel; check its unit"
    assert input_warnings(Scenario("s", 2.0, {"boom": signal}, locked=("boom",)), FULL) == []
    assert input_warnings(Scenario("s", 2.0, {"boom": Constant(2.0)}), FULL) == []


def test_what_comes_after_the_end_is_named_unless_the_end_was_asked_for():
    late = Piecewise(np.array([0.0, 3.0, 3.5]), np.array([0.0, 0.0, 0.5]))
    loads = Loads({"z": late}, Payload((0.0, 9.0), (50.0, 0.0)))
    scenario = Scenario("s", 2.0, {"stick": late}, loads=loads)
    assert input_warnings(scenario, FULL) == [
        "the voltage of stick changes after the end at 2 s and is not run",
        "the force along z changes after the end at 2 s and is not run",
        "the payload changes after the end at 2 s and is not run",
    ]
    assert input_warnings(scenario, FULL, t_end=1.0) == []
    longer = Scenario("s", 10.0, {"stick": late}, loads=loads)
    assert input_warnings(longer, FULL) == []


def test_a_run_says_so_and_usual_ones_do_not():
    run = simulate("cat215b", "exact", Scenario("mV", 0.1, {"boom": Constant(500.0)}))
    assert warnings(run)[0].startswith("boom: the lever's voltage reaches 500 V")
    for name in [*scenario_names(), "random:3:5"]:
        machine = load_machine(scenario_machine(name))
        scenario = load_scenario(name, functions=machine.names)
        assert input_warnings(scenario, dict.fromkeys(machine.names, 0.5)) == [], name


def test_a_batch_names_the_machine_where_each_function_gets_the_most():
    voltage = np.zeros((3, 4, 2))
    voltage[1, 2], voltage[2, 3] = (-300.0, 2.0), (80.0, 5.0)
    full = np.array([[0.7, 1.0], [0.7, 1.0], [0.1, np.inf]])
    assert voltage_warnings(("boom", "stick"), voltage, np.arange(3), full) == [
        "machine 2: boom: the lever's voltage reaches 80 V, and 0.1 V gives full travel; check its unit"
    ]
    assert voltage_warnings(("boom", "stick"), voltage, np.array([0, 0]), full[:2]) == []


def test_a_batch_says_so_in_the_words_of_a_run_and_usual_ones_do_not():
    held = Scenario("percent", 0.02, {"boom": Constant(80.0)})
    said = simulate("cat215b", "exact", held).info["doubtful_inputs"]
    array = np.zeros((4, len(load_machine("cat215b").names)))
    array[:, load_machine("cat215b").names.index("boom")] = 80.0
    assert simulate_batch("cat215b", "exact", held).info["doubtful_inputs"] == said
    assert simulate_batch("cat215b", "exact", array).info["doubtful_inputs"] == said
    several = simulate_batch("cat215b", "exact", np.array([0.0 * array, array]), keep=["rows"])
    assert several.info["doubtful_inputs"] == [f"machine 1: {said[0]}"]
    assert warnings(several.table(0))[0] == f"machine 1: {said[0]}"
    locked = Scenario("locked", 0.02, {"boom": Constant(80.0)}, ("boom",))
    for usual in (locked, 0.01 * array):
        assert "doubtful_inputs" not in simulate_batch("cat215b", "exact", usual).info
