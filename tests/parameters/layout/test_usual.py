import pytest

from helpers.small_crane import write_crane, write_crossover_crane
from polydraulic import load_machine
from polydraulic.parameters.layout.usual import unusual
from polydraulic.parameters.load import machine_names


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('at.x = {value = 1.8, unit = "m"', 'at.x = {value = 5, unit = "km"', "links.arm.at.x = 5000 m: usual is 0 m to 15 m"),
        ('pump.relief = {value = 250, unit = "bar"', 'pump.relief = {value = 250, unit = "psi"', "circuits.main.pump.relief = 17.24 bar"),
        ('pump.flow = {value = 40, unit = "L/min"', 'pump.flow = {value = 40, unit = "m3/h"', None),
        ('pump.flow = {value = 40, unit = "L/min"', 'pump.flow = {value = 16810, unit = "in3/s"', "circuits.main.pump.flow"),
        ('pilot.gain = {value = 8, unit = "mm/V"', 'pilot.gain = {value = 8, unit = "m/V"', "functions.slew.pilot.gain: voltage of full travel"),
        ("inertia.xx = {value = 2,", "inertia.xx = {value = 0.002,", "links.arm.inertia.xx: radius of gyration"),
        ("mass = {value = 250", "mass = {value = 250000", "links.boom.mass = 250000 kg"),
    ],
)  # fmt: skip
def test_absurd_values_are_named_with_what_is_usual(tmp_path, old, new, words):
    found = unusual(load_machine(write_crane(tmp_path, old, new)))
    if words is None:
        assert found == []
    else:
        assert any(line.startswith(words) and "usual is" in line for line in found), found


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("valve.bypass = {value = [30, 14, 2, 0]", "valve.bypass = {value = [0, 0, 10, 15]", "bypass rises with travel at"),
        ("valve.inlet = {value = [0, 0, 6, 20]", "valve.inlet = {value = [0, 20, 6, 0]", "inlet falls with travel at"),
        ("valve.inlet = {value = [0, 0, 6, 20]", "valve.inlet = {value = [0, 0, 6, 6]", None),
    ],
)  # fmt: skip
def test_an_orifice_that_closes_where_it_should_open_is_named(tmp_path, old, new, words):
    found = unusual(load_machine(write_crane(tmp_path, old, new)))
    if words is None:
        assert found == []
    else:
        assert found
        assert all(f".valve.{words}" in line and "check the order" in line for line in found), found


def test_the_machines_of_the_package_are_usual():
    for name in machine_names():
        if name != "cat215b":
            assert unusual(load_machine(name)) == []


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("value = [0, 1, 6, 12]", "value = [0, 1, 6, 12000]", "circuits.main.crossover.conductance"),
        ("opening_pressure = {value = 1.5", "opening_pressure = {value = 150", "circuits.main.crossover.opening_pressure = 150 bar"),
        ("taking.flow = {value = 40", "taking.flow = {value = 40000", "circuits.main.taking.flow = 40000 l/min"),
    ],
)  # fmt: skip
def test_absurd_values_of_a_crossover_are_named(tmp_path, old, new, words):
    found = unusual(load_machine(write_crossover_crane(tmp_path, old, new)))
    assert [line for line in found if line.startswith(words)], found
    assert unusual(load_machine(write_crossover_crane(tmp_path))) == []
