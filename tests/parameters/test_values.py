"""What is given stays, names are loaded; and no value is too strange for one clear error."""

import pytest

from polydraulic import load_machine, load_scenario
from polydraulic.errors import InputError
from polydraulic.parameters.load import as_machine
from polydraulic.parameters.scenario import as_scenario


def test_what_is_given_stays_and_names_are_loaded(machine):
    scenario = load_scenario("task")
    assert as_machine(machine) is machine
    assert as_machine("cat215b") == load_machine("cat215b")
    assert as_scenario(scenario, machine.names) is scenario
    assert as_scenario("single_08", machine.names).name == "single_08"
    with pytest.raises(InputError, match="a parameter set is given by its name or the path .*, not as NoneType"):
        as_machine(None)
    with pytest.raises(InputError, match="a scenario is given by its name .*, not as int"):
        as_scenario(3, machine.names)
    with pytest.raises(InputError, match="unknown parameter set 'cat'; choose one of"):
        as_machine("cat")


STRANGE = [10**400, -(10**400), 10**5000, 1e308, -1e308, 1e-308, [[]], [10**400] * 6, [1e308] * 6]


@pytest.mark.parametrize("value", STRANGE, ids=map(str, range(len(STRANGE))))
def test_no_value_is_too_strange_for_an_error(machine, value):
    for number in machine.numbers:
        with pytest.raises(InputError, match="a machine with these values cannot be made"):
            machine.with_values({number.path: value})
