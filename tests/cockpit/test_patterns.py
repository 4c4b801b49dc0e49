import pytest

from polydraulic import load_machine
from polydraulic.cockpit.patterns import lever_patterns

# as ISO 10968 and SAE J1177 have them: right and forward are positive at a stick, to the left, up and out are positive at a joint
EXCAVATOR = {
    "iso": {"swing": (0, -1.0), "stick": (1, 1.0), "bucket": (2, 1.0), "boom": (3, -1.0)},
    "sae": {"swing": (0, -1.0), "boom": (1, -1.0), "bucket": (2, 1.0), "stick": (3, 1.0)},
}


@pytest.mark.parametrize("name", ["cat215b_bucket", "excavator_22t"])
def test_an_excavator_has_its_levers_where_the_standards_have_them(name):
    assert lever_patterns(load_machine(name)) == EXCAVATOR


def test_every_function_of_any_machine_has_an_axis_of_its_own():
    for name in ("cat215b", "loader_crane", "wheel_loader"):
        machine = load_machine(name)
        for pattern in lever_patterns(machine).values():
            assert tuple(pattern) == machine.names
            assert len({axis.axis for axis in pattern.values()}) == len(machine.names)
