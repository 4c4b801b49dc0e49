import pytest

from polydraulic import InputError
from polydraulic.parameters.deviations import Deviation, Fault, ScheduledFault, TimedFault, scheduled

FLOW = "circuits.work.pump.flow"


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ({"amount": (1.0, 2.0)}, "one amount per time"),
        ({"amount": (float("nan"),)}, "finite"),
        ({"amount": (1.0, 2.0), "time": (1.0, 1.0)}, "rise"),
        ({"amount": (1.0,), "time": (-1.0,)}, "rise"),
        ({"amount": (1.0,), "how": "divided"}, "must be one of"),
    ],
)
def test_what_is_no_deviation_is_refused(what, says):
    with pytest.raises(InputError, match=says):
        Deviation(**({"of": FLOW, "how": "times"} | what))


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("boom.pump_worn", ScheduledFault("boom.pump_worn")),
        ("boom.pump_worn 10 %", ScheduledFault("boom.pump_worn", 0.1)),
        ("boom.pump_worn 10% from 2 min", ScheduledFault("boom.pump_worn", 0.1, begin=120.0)),
        ("boom.angle.freeze from 1 s to 500 ms", None),
        ("tip.payload_unknown 0.3 t to 9 s", ScheduledFault("tip.payload_unknown", 300.0, end=9.0)),
        ("a.b -2 % from 1.5 s to 3 s over 1 s", ScheduledFault("a.b", -0.02, 1.5, 3.0, 1.0)),
    ],
)
def test_a_text_says_what_happens_when(text, found):
    if found is None:
        with pytest.raises(InputError, match="must be later than its beginning, 1 s"):
            scheduled(text)
        return
    assert scheduled(text) == found
    assert scheduled(str(found)) == found
    assert scheduled(found) is found


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "must be NAME"),
        ("boom.pump_worn 10", "number with its unit"),
        ("boom.pump_worn 10 bar", "number with its unit"),
        ("boom.pump_worn 10 % from 5", "begin = '5': must be a number with its unit, for example 60 s"),
        ("boom.pump_worn 10 % after 5 s", "size = '10 % after 5 s'"),
        ("boom.pump_worn from 1e12 s", "must lie in"),
        ("boom.pump_worn from 1 furlong", "begin"),
        (7, "must be NAME"),
    ],
)
def test_what_is_no_such_text_is_refused(text, says):
    with pytest.raises(InputError, match=says):
        scheduled(text)


def test_a_fault_of_ones_own_has_its_size_in_its_numbers():
    own = Fault("mine", "mine", (Deviation(FLOW, "times", (0.5,)),))
    assert scheduled(own) == ScheduledFault(own)
    with pytest.raises(InputError, match="'mine': size and growth are those of its numbers"):
        ScheduledFault(own, 0.1)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"begin": "3"}, "begin = '3'"),
        ({"size": "10 %"}, "size = '10 %'"),
        ({"end": None, "growth": True}, "growth = True"),
    ],
)
def test_what_is_no_number_is_refused_in_a_schedule(given, says):
    with pytest.raises(InputError, match=f"'boom.pump_worn': {says}: must be a number in SI"):
        ScheduledFault("boom.pump_worn", **({"end": 5.0} | {k: v for k, v in given.items() if v is not None}))


def test_one_amount_alone_is_a_tuple_too():
    with pytest.raises(InputError, match=r"amounts and times must be tuples, for example \(0.5,\)"):
        Deviation(FLOW, "times", 0.5)


def test_a_timed_fault_changes_at_its_stages_until_it_is_over():
    grown = Fault("grown", "grown", (Deviation(FLOW, "times", (0.9, 0.8), (1.0, 3.0)),))
    timed = TimedFault(grown, 10.0, 12.5)
    assert timed.changes(grown.numbers) == [11.0, 12.5]
    assert [timed.since(t) for t in (9.0, 11.0, 12.5)] == [-1.0, 1.0, -1.0]
    assert timed.after(10.0).changes(grown.numbers) == [1.0, 2.5]
    assert TimedFault(grown, 10.0).changes(()) == []
    assert str(timed) == "grown from 10 s to 12.5 s: grown"
