"""Times as texts, held to Python's own dates."""

from datetime import UTC, datetime, timedelta, timezone

import numpy as np
import pyarrow as pa
import pytest

from polydraulic.columns.timestamps import ORDERS, DateOrder, has_zone, seconds, since_1970, time_kind

MOMENTS = [datetime(2000, 1, 1, tzinfo=UTC) + timedelta(days=137 * k, seconds=3601.25 * k) for k in range(60)]


@pytest.mark.parametrize(
    ("form", "order"),
    [
        ("%Y-%m-%dT%H:%M:%S.%f", None),
        ("%Y-%m-%d %H:%M:%S.%fZ", None),
        ("%Y/%m/%d %H:%M:%S.%f", None),
        ("%Y-%m-%dT%H:%M:%S,%f", None),
        ("%d.%m.%Y %H:%M:%S,%f", None),
        ("%d.%m.%y, %H:%M:%S.%f", None),
        ("%d-%b-%Y %H:%M:%S.%f", None),
        ("%d/%m/%Y %H:%M:%S.%f", ORDERS[0]),
        ("%m/%d/%Y %H:%M:%S.%f", ORDERS[1]),
        ("%m/%d/%Y %I:%M:%S.%f %p", ORDERS[1]),
        ("%d-%m-%Y_%H:%M:%S.%f", ORDERS[0]),
        ("%Y%m%dT%H%M%S.%f", None),
        ("%Y%m%d %H%M%S,%f", None),
        ("%Y%m%d_%H%M%S.%fZ", None),
        ("%b %d, %Y %I:%M:%S.%f %p", None),
        ("%B %d, %Y, %H:%M:%S.%f", None),
        ("%a, %d %b %Y %H:%M:%S.%f +0000", None),
        ("%a %b %d %H:%M:%S.%f %Y", None),
        ("%Y-%m-%dT%H:%M:%S.%fZ[Europe/Berlin]", None),
    ],
)
def test_dates_of_every_common_form(form, order):
    texts = [moment.strftime(form) for moment in MOMENTS]
    assert time_kind(texts) == "stamp"
    found = seconds(pa.array([*texts, None, "later"]), "stamp", order)
    assert found[:-2] == pytest.approx([moment.timestamp() for moment in MOMENTS], abs=1e-6)
    assert np.isnan(found[-2:]).all()


@pytest.mark.parametrize(
    ("name", "hours"), [("CET", 1), ("CEST", 2), ("MESZ", 2), ("EST", -5), ("PDT", -7), ("GMT", 0)]
)
def test_zones_may_be_said_by_name(name, hours):
    texts = [
        moment.astimezone(timezone(timedelta(hours=hours))).strftime(f"%d.%m.%Y %H:%M:%S.%f {name}")
        for moment in MOMENTS
    ]
    assert time_kind(texts) == "stamp"
    assert has_zone(texts)
    assert seconds(pa.array(texts), "stamp") == pytest.approx([moment.timestamp() for moment in MOMENTS], abs=1e-6)


@pytest.mark.parametrize("zone", [" IST", " CST", " CDT", "[Europe/Berlin]", " [America/Chicago]"])
def test_a_name_of_two_zones_and_a_place_without_an_offset_are_no_time(zone):
    texts = [f"2024-03-31T01:59:57{zone}", f"31.03.2024 1:59:57 PM{zone}"]
    assert time_kind(texts) == ""
    assert not has_zone(texts)
    assert np.isnan(seconds(pa.array(texts), "stamp")).all()


@pytest.mark.parametrize(
    "text", ["31.03.2024 1:59:03 PM CET", "Mar 31, 2024 1:59:03 p.m. +01:00", "20240331T135903+01"]
)
def test_a_zone_is_seen_behind_every_time_that_it_is_taken_off(text):
    assert has_zone([text])
    assert seconds(pa.array([text, "x"]), "stamp")[0] == datetime(2024, 3, 31, 12, 59, 3, tzinfo=UTC).timestamp()


@pytest.mark.parametrize("hours", [-7.5, 0.0, 2.0])
def test_zones_are_taken_off(hours):
    zone = timezone(timedelta(hours=hours))
    texts = [moment.astimezone(zone).strftime("%d.%m.%Y %H:%M:%S.%f%z") for moment in MOMENTS[:5]]
    iso = [moment.astimezone(zone).isoformat() for moment in MOMENTS[:5]]
    assert has_zone(texts)
    for given in (texts, iso):
        assert seconds(pa.array(given), "stamp") == pytest.approx([m.timestamp() for m in MOMENTS[:5]], abs=1e-6)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("13:59:57.01", 50397.01), ("13:59", 50340.0), ("1:59:57,5 PM", 50397.5), ("12:00:01 AM", 1.0), ("12:30 pm", 45000.0),
        ("-00:00:01.5", -1.5), ("100:00:00", 360000.0), ("59:57.5", 3597.5), ("13:60:00", np.nan), ("noon", np.nan),
        ("0 days 00:00:01.250000", 1.25), ("-1 days +23:59:59.5", -0.5), ("1 day, 0:00:02", 86402.0), ("3 days 10:00", 295200.0),
    ],
)  # fmt: skip
def test_times_of_day(text, expected):
    assert seconds(pa.array([text]), "clock") == pytest.approx([expected], nan_ok=True)


@pytest.mark.parametrize("text", ["31.02.2024 10:00:00", "2024-13-01 10:00", "29.02.2023", "1.5", "10:00:00"])
def test_what_is_no_date_gives_none(text):
    assert np.isnan(seconds(pa.array([text, "x"]), "stamp")).all()


def test_without_an_order_slashes_give_none():
    assert np.isnan(seconds(pa.array(["13/04/2024 10:00", "x"]), "stamp")).all()


def test_a_day_above_12_tells_the_order():
    for text, order in (("13/04/2024", ORDERS[0]), ("04-13-2024", ORDERS[1]), ("3/4/2024", None)):
        found = DateOrder()
        found.look(pa.array(["01/02/2024", None]))
        found.look(pa.array([text]))
        assert (found.order, found.settled, found.needed) == (order, order is not None, True)
    iso = DateOrder()
    iso.look(pa.array(["2024-03-04"]))
    assert iso.settled


def test_what_is_no_time_is_of_no_kind():
    assert [time_kind(cells) for cells in (["1.5", "2"], ["boom"], [], ["1.2.3"])] == ["", "", "", "stamp"]


def test_ticks_are_rounded_once():
    ticks = 1_711_850_398 * 10**9 + np.arange(1000) * 12_345
    found = since_1970(pa.array(ticks), 10**9)
    exact = np.array([int(tick) / 10**9 for tick in ticks])
    assert np.max(np.abs(found - exact)) <= np.spacing(exact[0])
