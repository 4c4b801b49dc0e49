from polydraulic.flow.layout import slots
from polydraulic.parameters.load import load_machine

CIRCUITS = {c.name: c for c in load_machine("cat215b_bucket").circuits}
ARM = next(c for c in load_machine("excavator_22t").circuits if c.name == "arm")


def said(place):
    """Names of an output and of its inputs."""
    return place[0].name, [v.name for v in place[1]]


def test_two_valves_have_the_names_of_swing_and_stick():
    series, both = CIRCUITS["series"], ["swing.travel", "stick.travel", "swing.p_in", "stick.p_in"]
    assert [said(place) for place in slots.inlet(series, "swing")] == [("swing.q_in", both)]
    assert [said(place) for place in slots.inlet(series, "stick")] == [
        ("stick.q_in", ["series.q_passed", "stick.travel", "stick.p_in"]),
        ("stick.q_in", both),
    ]
    assert said(slots.inlet_limited(series, "stick")) == ("stick.q_in_limited", both)
    assert said(slots.second_at_relief(series)) == (
        "stick.q_in_relief",
        ["swing.travel", "stick.travel", "stick.root_below_relief"],
    )
    assert said(slots.outlet("boom")[1]) == ("boom.q_out", ["boom.spool", "boom.root_p_out"])


def test_more_valves_read_what_reaches_them_and_what_stands_behind():
    assert ARM.functions == ("swing", "stick", "bucket")
    (direct,), (cascade, other) = slots.inlet(ARM, "swing"), slots.inlet(ARM, "stick")
    assert [v.name for v in direct[1]] == [
        *("swing.travel", "stick.travel", "bucket.travel"), *("swing.p_in", "stick.p_in", "bucket.p_in"),
    ]  # fmt: skip
    assert [v.name for v in cascade[1]] == [
        *("arm.q_passed_1", "stick.travel", "bucket.travel", "stick.p_in", "bucket.p_in"),
    ]
    assert other[1] == direct[1]
    assert [v.name for v in slots.inlet(ARM, "bucket")[0][1]] == ["arm.q_passed_2", "bucket.travel", "bucket.p_in"]


def test_what_passes_the_first_valve_has_modes():
    output, inputs = slots.passed_at_relief(ARM)
    assert (output.name, output.unit) == ("arm.q_passed_1_relief", "m3/s")
    assert "swing.p_in" not in [v.name for v in inputs]
    assert slots.passed_limited(CIRCUITS["series"])[0].name == "series.q_passed_limited"
