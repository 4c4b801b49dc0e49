from typing import get_type_hints

import pytest

from polydraulic.parameters.schema import CIRCUITS, LINKS, Machine, Quantity
from polydraulic.units import FACTORS


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
    assert (share.range, length.range) == ("in [0, 1]", "above 0")
    assert Quantity("m", above=0.0, high=2.0).range == "above 0, at most 2"
    assert [Quantity("m").allows(value) for value in (1e20, -1e20, 1e21, 1e-31, 10**400, float("nan"))] == [
        True,
        True,
        *[False] * 4,
    ]


def test_every_parameter_of_a_machine_has_a_unit_that_can_be_converted():
    found = list(quantities(Machine))
    assert len(found) > 60
    assert {quantity.unit for quantity in found} <= set(FACTORS)


def test_each_link_is_fed_by_one_circuit():
    assert sorted(link for links in CIRCUITS.values() for link in links) == sorted(LINKS)
    with pytest.raises(KeyError):
        CIRCUITS["swing"]
