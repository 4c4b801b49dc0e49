from polydraulic.machine.state import State, initial_state
from polydraulic.parameters.schema import LINKS


def test_a_machine_begins_at_rest_as_its_set_says(machine):
    x = initial_state(machine)
    assert State._fields == ("spool", "p_a", "p_b", "angle", "rate")
    for link in LINKS:
        start = getattr(machine, link).initial
        assert [getattr(part, link) for part in x] == [0.0, start.p_a, start.p_b, start.angle, 0.0]
