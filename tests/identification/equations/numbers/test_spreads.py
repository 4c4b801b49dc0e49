"""Spreads of numbers of which nobody says how far they may be off."""

import pytest

from polydraulic import load_machine
from polydraulic.errors import InputError
from polydraulic.identification.equations.numbers.spreads import spreads_of

NAN = float("nan")


def test_entries_become_single_numbers():
    machine = load_machine("loader_crane")
    found = spreads_of(
        machine,
        {"functions.slew.valve.inlet": NAN, "links.inner.mass": 25.0, "functions.slew.pilot.dead_time": NAN},
    )
    assert list(found)[:4] == [f"functions.slew.valve.inlet[{k}]" for k in (2, 3, 4, 5)]
    assert found["functions.slew.valve.inlet[5]"] == pytest.approx(0.3 * machine.function("slew").valve.inlet[5])
    assert found["links.inner.mass"] == 25.0
    assert found["functions.slew.pilot.dead_time"] == 0.05


def test_what_has_no_usual_spread_is_refused():
    machine = load_machine("loader_crane")
    with pytest.raises(InputError, match=r"functions\.inner\.line\.leakage' is 0: give it a spread"):
        spreads_of(machine, {"functions.inner.line.leakage": NAN})
    with pytest.raises(InputError, match="no such number"):
        spreads_of(machine, {"links.inner.weight": NAN})


@pytest.mark.parametrize(
    ("path", "share"),
    [
        ("circuits.series.pump.flow", 0.1), ("circuits.series.pump.relief", 0.05), ("circuits.series.pump.torque_limit_start", 0.1),
        ("functions.boom.pilot.gain", 0.2), ("functions.boom.pilot.time_constant", 0.3), ("links.boom.mass", 0.3),
    ],
)  # fmt: skip
def test_a_number_may_be_off_by_a_share_that_goes_by_its_kind(path, share):
    machine = load_machine("cat215b")
    value = next(number.value for number in machine.numbers if number.path == path)
    assert spreads_of(machine, {path: NAN}) == {path: pytest.approx(share * abs(value), rel=1e-12)}
