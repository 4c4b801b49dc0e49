"""What is said of circuits that were found by flows: every threshold from both sides."""

import numpy as np
import pytest

from polydraulic import load_machine
from polydraulic.identification.equations.circuits import CircuitFound, ValveFound
from polydraulic.identification.equations.free_numbers import Freedom, entries_of
from polydraulic.identification.equations.sensors import AT_VALVE, Signals
from polydraulic.identification.equations.ways.by_flows import _circuit_changes, _refused, _remarks
from polydraulic.parameters.layout.parts import ValveCurves

MACHINE = load_machine("cat215b")
BOOM = MACHINE.circuit("boom")
FREE = Freedom(dict.fromkeys(entries_of(MACHINE), float("nan")), False)


def valve(errors=0.05, least=0.5, seen=0.02, left=0.0, **changes):
    """A valve whose inlet is 1 at its last knot and `least` at the second; `errors` are those of all its curves there."""
    curve = (0.0, least, 1.0)
    known = {key: np.array([0.0, errors, 0.05]) for key in ("inlet", "bypass", "outlet_positive", "outlet_negative")}
    curves = ValveCurves((0.0, 0.01, 0.02), curve, curve, curve, curve)
    return ValveFound(curves, known, (0.005, seen), (0.0, 1e7), left, np.nan, 900, (True, True))._replace(**changes)


def told(of, trades=()):
    return _remarks(MACHINE, {"boom": CircuitFound({"boom": of}, {}, [], 900, list(trades))})


@pytest.mark.parametrize(
    ("of", "named"),
    [
        (valve(errors=0.0499), False),
        (valve(errors=0.0501), True),  # a tenth of what it is
        (valve(errors=np.nan), True),
        (valve(errors=0.5, least=0.0199), False),  # as good as shut
        (valve(errors=0.5, least=0.0201), True),
        (valve(errors=0.5, seen=0.0099), False),  # beyond what the log has seen
        (valve(errors=0.5, seen=0.01), True),
    ],
)
def test_conductances_of_an_open_valve_are_known_within_a_tenth(of, named):
    found = [text for text in told(of) if "is not known within" in text]
    assert (
        found
        == [
            f"functions.boom.valve.{key} is not known within 10 % at 10 mm: there the log hardly depends on it"
            for key in ("inlet", "bypass", "outlet_positive", "outlet_negative")
        ]
        * named
    )


@pytest.mark.parametrize(("short", "named"), [(0.9e-4, False), (1.1e-4, True)])
def test_travel_that_was_never_seen_is_told_from_a_tenth_of_a_millimetre_on(short, named):
    last = MACHINE.function("boom").valve.knots[-1]
    found = [text for text in told(valve(seen=last - short)) if "was never seen" in text]
    assert found == ["functions.boom.valve beyond 14.22 mm was never seen, to 20 mm: the old curves' shape"] * named


def test_sensors_that_contradict_each_other_and_trades_are_told():
    flow = BOOM.pump.flow
    assert not [text for text in told(valve(left=0.199 * flow)) if "contradict" in text]
    for of in (valve(left=0.201 * flow), valve()._replace(q_out_left=0.201 * flow)):
        assert "flows of boom are 20 % of the pump's off" in "\n".join(told(of))
    assert told(valve(), ["a trades against b"])[-1] == "a trades against b"


@pytest.mark.parametrize(("rows", "why"), [(500, ""), (499, "the spool of boom hardly ever leaves its centre")])
def test_a_spool_leaves_its_centre_in_five_hundred_rows(rows, why):
    tenth = 0.1 * MACHINE.function("boom").valve.knots[-1]
    spool = np.where(np.arange(600) < rows, -1.001 * tenth, 0.999 * tenth)
    here = Signals(dict.fromkeys((*AT_VALVE, "q_in"), spool), {}, {})
    assert _refused(MACHINE, BOOM, {"boom": here}, FREE) == why
    assert _refused(MACHINE, BOOM, {"boom": here}, Freedom({}, True)) == "none of its numbers is free"
    without = here._replace(values=dict.fromkeys(AT_VALVE, spool))
    assert _refused(MACHINE, BOOM, {"boom": without}, FREE) == "the log has no boom.q_in or boom.angle"


def test_what_a_log_does_not_show_of_a_circuit_is_kept_and_said():
    notes: list[str] = []
    found = CircuitFound({"boom": valve(errors=np.nan, outlets=(True, False))}, {"flow": (2e-3, 1e-5)}, [], 900, [])
    changes = _circuit_changes(MACHINE, BOOM, found, FREE, "log.csv", notes)
    assert (changes["circuits.boom.pump.flow"].value, changes["circuits.boom.pump.flow"].uncertainty) == (2e-3, 1e-5)
    assert changes["functions.boom.valve.inlet"].uncertainty == (0.0, float("inf"), 0.05)
    assert changes["functions.boom.valve.knots"].uncertainty == (0.0, 0.0, 0.0)
    assert notes == [
        "functions.boom.valve.outlet_negative: kept; the log has too few rows with a spool on that side and a flow out",
        "circuits.boom.pump.relief: kept; the log does not show it",
    ]
