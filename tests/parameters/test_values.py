import re

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.parameters.load import as_machine, machine_entries
from polydraulic.parameters.scenario import as_scenario, load_scenario
from polydraulic.parameters.values import leaves_of


def test_values_are_put_in_their_places_and_nothing_else_changes(machine):
    inlet = machine.function("boom").valve.inlet
    found = machine.with_values(
        {
            "boom.body.mass": np.float32(900),
            "pumps.torque_limit_enabled": True,
            "boom.valve.inlet": np.array(inlet) * 2,
            "boom.valve.inlet[5]": 1,
        }
    )
    body = machine.boom.body._replace(mass=900.0)
    valve = machine.function("boom").valve._replace(inlet=(*(2 * value for value in inlet[:5]), 1.0))
    pumps = machine.pumps._replace(torque_limit_enabled=True)
    assert found == machine._replace(pumps=pumps, boom=machine.boom._replace(body=body, valve=valve))
    assert {type(value) for value in found.function("boom").valve.inlet} == {float}
    assert type(found.boom.body.mass) is float
    assert machine.with_values({}) == machine


def test_every_number_of_a_parameter_file_has_a_path(machine):
    assert list(leaves_of(Machine)) == [entry.key for entry in machine_entries("cat215b")]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"boom.mass": 900}, "boom.mass: there is no such value; near it: boom.body.mass, "),
        ({"bucket.body.mass": 900}, "near it: .*boom.body.mass"),
        ({"colour": 1}, "colour: there is no such value"),
        ({"mass": 1}, "mass: there is no such value; near it: boom.body.mass, stick.body.mass"),
        ({3: 1}, "3: there is no such value"),
        ({"boom.body": 900}, "boom.body: holds boom.body.mass, boom.body.cg, .*; give one of them"),
        ({"boom.body.mass": -1}, "boom.body.mass = -1: must be finite and above 0 kg"),
        ({"boom.body.mass": float("nan")}, "boom.body.mass = nan: must be finite"),
        ({"boom.body.mass": "900 kg"}, "boom.body.mass = '900 kg': must be a number"),
        ({"boom.body.mass": True}, "boom.body.mass = True: must be a number"),
        ({"boom.body.mass": [900]}, r"boom.body.mass = \[900\]: must be a number"),
        ({"boom.body.mass[0]": 900}, r"boom.body.mass\[0\]: is a single value"),
        ({"pumps.torque_limit_enabled": 1}, "torque_limit_enabled = 1: must be True or False"),
        ({"spool.knots": [0.0, 1.0]}, r"spool.knots = \[0.0, 1.0\]: must be 6 numbers"),
        ({"spool.knots": "012345"}, "spool.knots = '012345': must be 6 numbers"),
        ({"spool.knots": 1.0, "spool.knots[2]": 1.0}, "spool.knots = 1.0: must be 6 numbers"),
        ({"spool.knots[6]": 1.0}, r"spool.knots\[6\]: the last one is spool.knots\[5\]"),
        ({"boom.valve.inlet[5]": -1}, r"boom.valve.inlet\[5\] = -1: must be finite and in \[0, inf\]"),
        ({"boom.valve.inlet": [0, 0, 1, 1, 1, -1]}, r"boom.valve.inlet\[5\] = -1"),
        ({"boom.initial.angle": 3.0}, "boom.initial.angle = 3.0: must be within the stops"),
        ({"pumps.relief": 1.0}, "pumps.relief = 1.0: must be above tank.return_pressure"),
    ],
)
def test_what_cannot_be_is_one_clear_error(machine, values, message):
    with pytest.raises(InputError, match="a machine with these values cannot be made: .*" + message):
        machine.with_values(values)


def test_one_error_names_all_that_is_wrong(machine):
    with pytest.raises(InputError) as error:
        machine.with_values({"boom.mas": 1, "boom.body.mass": 0, "stick.body.mass": 500, "swing.stops.low": "no"})
    assert re.findall(r"(?:: |; )(\S+?)(?: =|: there)", str(error.value)) == [
        "boom.mas",
        "boom.body.mass",
        "swing.stops.low",
    ]
    with pytest.raises(InputError, match="boom.friction.static = 0.0: .*stick.friction.static = 0.0: "):
        machine.with_values({"boom.friction.static": 0, "stick.friction.static": 0})


def test_what_is_given_stays_and_names_are_loaded(machine):
    scenario = load_scenario("task")
    assert as_machine(machine) is machine
    assert as_machine("cat215b") == load_machine("cat215b")
    assert as_scenario(scenario) is scenario
    assert as_scenario("single_08").name == "single_08"
    with pytest.raises(InputError, match="a parameter set is given by its name or the path .*, not as NoneType"):
        as_machine(None)
    with pytest.raises(InputError, match="a scenario is given by its name .*, not as int"):
        as_scenario(3)
    with pytest.raises(InputError, match="unknown parameter set 'cat'; choose one of"):
        as_machine("cat")


STRANGE = [10**400, -(10**400), 10**5000, 1e308, -1e308, 1e-308, [[]], [10**400] * 6, [1e308] * 6]


@pytest.mark.parametrize("value", STRANGE, ids=map(str, range(len(STRANGE))))
def test_no_value_is_too_strange_for_an_error(machine, value):
    for path in leaves_of(Machine):
        with pytest.raises(InputError, match="a machine with these values cannot be made"):
            machine.with_values({path: value})
