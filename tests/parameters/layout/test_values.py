import re

import numpy as np
import pytest

from helpers.small_crane import write_crane, write_crossover_crane
from polydraulic import InputError, load_machine
from polydraulic.parameters.layout.schema import LayoutMachine
from polydraulic.parameters.load import machine_entries, machine_names

LAYOUTS = [name for name in machine_names() if isinstance(load_machine(name), LayoutMachine)]


@pytest.fixture(scope="module")
def crane(tmp_path_factory):
    return load_machine(write_crane(tmp_path_factory.mktemp("crane")))


def whole(path):
    return re.sub(r"\[\d+\]$", "", path)


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_number_of_a_machine_file_has_a_path(name):
    machine = load_machine(name)
    written = {entry.key for entry in machine_entries(name) if not isinstance(entry.value, bool)}
    may_be_left_out = {f"functions.{f}.line.external_leakage" for f in machine.names}
    assert {whole(number.path) for number in machine.numbers} == written | may_be_left_out
    assert all(number.quantity.allows(number.value) for number in machine.numbers)


@pytest.mark.parametrize("name", LAYOUTS)
def test_every_number_can_be_put_where_it_is(name):
    machine = load_machine(name)
    assert machine.with_values({n.path: n.value for n in machine.numbers}) == machine
    assert machine.with_values({}) == machine


def test_each_number_is_changed_alone(crane):
    before = {n.path: n.value for n in crane.numbers}
    coupled = re.compile(r"\.number$|\.inertia\.|\[0\]$|\.initial\.|\.coulomb$|cylinder.rod$")  # what goes with others
    free = [path for path in before if not coupled.search(path)]
    assert len(free) > 80
    for path in free:
        changed = crane.with_values({path: before[path] * 1.0001 + 1e-12})
        assert {n.path for n in changed.numbers if n.value != before[n.path]} == {path}


def test_values_are_put_in_their_places(crane):
    found = crane.with_values(
        {
            "links.boom.mass": np.float32(300),
            "functions.extend.initial.position": 0.3,
            "functions.slew.valve.inlet[3]": 1e-5,
            "functions.lift.friction.sticks": True,
            "tip.at.x": 1,
        }
    )
    assert found.link("boom").mass == 300.0
    assert type(found.link("boom").mass) is float
    assert found.function("extend").initial.angle == 0.3
    assert found.function("slew").valve.inlet == (*crane.function("slew").valve.inlet[:3], 1e-5)
    assert found.function("lift").effects.sticks is True
    assert type(found.tip[1]["x"]) is float


def test_tables_of_a_valve_are_resized_together(crane):
    where, valve = "functions.lift.valve", crane.function("lift").valve
    tables = {f"{where}.{key}": [*values, 2 * values[-1]] for key, values in valve._asdict().items()}
    found = crane.with_values(tables | {f"{where}.inlet[4]": 1e-4})
    assert len(found.function("lift").valve.knots) == 5
    assert found.function("lift").valve.inlet[4] == 1e-4
    tables.pop(f"{where}.bypass")
    with pytest.raises(InputError, match=r"functions.lift.valve.bypass: 4 numbers for 5 knots; must be as many"):
        crane.with_values(tables)
    with pytest.raises(InputError, match=r"functions.lift.valve.knots: 17 numbers; must be 2 to 16"):
        crane.with_values({f"{where}.{key}": [0.001 * i for i in range(17)] for key in valve._fields})
    with pytest.raises(InputError, match=r"inlet\[5\]: the last one is functions.lift.valve.inlet\[3\]"):
        crane.with_values({f"{where}.inlet[5]": 1e-4})


def test_numbers_of_a_crossover_have_the_paths_of_a_file(tmp_path):
    machine = load_machine(write_crossover_crane(tmp_path))
    x = machine.crossovers[0]
    where = f"circuits.{x.name}"
    found = machine.with_values({f"{where}.giving.flow": 1e-3, f"{where}.crossover.opening_pressure": 2e5})
    assert found.circuit(x.giving).pump.flow == 1e-3
    assert found.crossovers[0].valve.opening_pressure == 2e5
    with pytest.raises(InputError, match=f"{where}.crossover.conductance: 1 numbers for the"):
        machine.with_values({f"{where}.crossover.conductance": [0.0]})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"functions.lift.pilot": 1}, "functions.lift.pilot: holds functions.lift.pilot.gain, .*; give one of them"),
        ({"links.boom.mas": 1}, "links.boom.mas: there is no such value; near it: links.boom.mass"),
        ({"links.boom.mass": -1}, r"links.boom.mass = -1: must be 0 kg or more"),
        ({"links.boom.cg.y": 0.1}, "links.boom.cg.y: there is no such value"),
        ({"functions.lift.backlash": 0.1}, "functions.lift.backlash: there is no such value"),
        ({"functions.extend.initial.angle": 0.1}, "functions.extend.initial.angle: there is no such value"),
        ({"functions.lift.friction.sticks": 1}, "sticks = 1: must be True or False"),
        ({"functions.lift.valve.inlet": 1.0}, "functions.lift.valve.inlet = 1.0: must be a list of numbers"),
        ({"functions.lift.valve.inlet": []}, r"functions.lift.valve.inlet = \[\]: must be a list of numbers"),
        ({"functions.lift.valve.inlet[0]": 1e-6}, r"functions.lift.valve.inlet\[0\]: must be 0 at the centred spool"),
        ({"functions.lift.cylinder.number": 1.5}, "functions.lift.cylinder.number = 1.5: must be a whole number"),
        ({"gravity": 40.0}, r"gravity = 40.0: must be in \[0, 30\] m/s2"),
    ],
)
def test_what_cannot_be_is_one_clear_error(crane, values, message):
    with pytest.raises(InputError, match="a machine with these values cannot be made: .*" + message):
        crane.with_values(values)


def test_one_error_names_all_that_is_wrong(crane):
    with pytest.raises(InputError) as error:
        crane.with_values({"links.boom.mas": 1, "links.boom.mass": -1, "gravity": "no"})
    assert [word in str(error.value) for word in ("links.boom.mas:", "links.boom.mass = -1", "gravity = 'no'")] == [
        True
    ] * 3
