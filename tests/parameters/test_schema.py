from typing import get_type_hints

from polydraulic.parameters.layout.parts import CylinderSize, FlowForce, PumpParameters
from polydraulic.parameters.schema import Friction, Initial, Line, Pilot, Quantity, Stops, SwingMotor, Tank
from polydraulic.units import FACTORS

PARTS = (CylinderSize, FlowForce, Friction, Initial, Line, Pilot, PumpParameters, Stops, SwingMotor, Tank)


def quantities(cls):
    for hint in get_type_hints(cls, include_extras=True).values():
        if isinstance(hint, type) and issubclass(hint, tuple):
            yield from quantities(hint)
        else:
            yield from getattr(hint, "__metadata__", ())


def test_a_range_says_what_it_allows():
    share, length = Quantity("1", low=0.0, high=1.0), Quantity("m", above=0.0)
    assert [share.allows(value) for value in (-0.1, 0.0, 1.0, 1.1)] == [False, True, True, False]
    assert [length.allows(value) for value in (0.0, 1e-9, 1e9)] == [False, True, True]
    assert (share.demand(-0.1), length.demand(-0.1)) == ("must be in [0, 1]", "must be above 0 m")
    assert Quantity("m", above=0.0, high=2.0).demand(3.0) == "must be above 0 m, at most 2 m"
    assert Quantity("kg", low=0.0).demand(-1.0) == "must be 0 kg or more"
    assert Quantity("kg").demand(float("nan")) == "must be finite and a number of kg"
    assert [Quantity("m").allows(value) for value in (1e20, -1e20, 1e21, 1e-31, 10**400, float("nan"))] == [
        True,
        True,
        *[False] * 4,
    ]


def test_every_parameter_of_a_machine_has_a_unit_that_can_be_converted():
    found = [quantity for part in PARTS for quantity in quantities(part)]
    assert len(found) > 30
    assert {quantity.unit for quantity in found} <= set(FACTORS)
