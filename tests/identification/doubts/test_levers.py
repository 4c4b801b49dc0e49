"""Joints that go the way their levers send them, and those that do not."""

import re

import numpy as np
import pytest

from helpers.machine_log import changed, machine_log
from polydraulic.identification.doubts.levers import Votes, lever_doubts, lever_votes, votes_of
from polydraulic.tables import Table

PLACE = "boom.angle"


def bare(log, *parts):
    """What a log has of some quantities alone."""
    keep = [name for name in log.names if name == "time" or name.split(".")[-1] in parts]
    return Table({name: log[name] for name in keep}, {name: log.unit(name) for name in keep})


def doubts(machine, table):
    return list(lever_doubts(machine, table, lever_votes(machine, table)))


@pytest.mark.parametrize("every", [1, 5, 25, 50])
def test_nothing_is_said_of_a_healthy_log_however_seldom_its_rows_come(true, log, every):
    assert doubts(true, Table({name: log[name][::every] for name in log.names}, log.units)) == []


@pytest.mark.parametrize(
    ("parts", "turned", "wrong"),
    [
        (("voltage", "angle"), "boom.voltage", {"boom.voltage", PLACE}),
        (("voltage", "angle"), PLACE, {"boom.voltage", PLACE}),
        (("spool", "angle"), "boom.spool", {"boom.spool", PLACE}),
        (("voltage", "spool", "angle"), "boom.voltage", {"boom.voltage"}),
        (("voltage", "spool", "angle"), "boom.spool", {"boom.spool"}),
        (("voltage", "spool", "angle"), PLACE, {PLACE}),
    ],
)
def test_a_turned_sign_is_named_and_which_it_is_where_two_others_agree(true, log, parts, turned, wrong):
    found = doubts(true, bare(changed(log, **{turned.replace(".", "_", 1): -log[turned]}), *parts))
    assert [set(columns) for columns, _ in found] == [wrong]
    assert "boom.angle goes against boom." in found[0][1]
    assert "wrong sign: turn it where the log is imported" in found[0][1]


def test_exchanged_channels_are_named_with_whose_they_are(true, log):
    table = changed(log, boom_voltage=log["stick.voltage"], stick_voltage=log["boom.voltage"])
    told = dict(doubts(true, bare(table, "voltage", "angle")))
    assert "follows stick.voltage: channels of boom and stick are exchanged" in told["boom.voltage", PLACE]
    assert "follows boom.voltage: channels of stick and boom are exchanged" in told["stick.voltage", "stick.angle"]
    assert len(told) == 2


def test_a_lever_of_another_day_or_with_another_centre_is_named(true, log):
    other = machine_log(120.0, seed=2)
    (columns, text), *rest = doubts(true, bare(changed(log, boom_voltage=other["boom.voltage"]), "voltage", "angle"))
    assert (columns, rest) == (("boom.voltage", PLACE), [])
    assert "they are not of the same joint, or their clocks are apart" in text
    for strange in (log["boom.voltage"] + 2.5, 1e-3 * log["boom.voltage"], np.zeros(len(log))):
        found = doubts(true, bare(changed(log, boom_voltage=strange), "voltage", "angle"))
        assert [columns for columns, _ in found] == [("boom.voltage",)]
        assert "hardly ever on both sides of zero: take off its centre" in found[0][1]


def test_few_moves_and_none_tell_nothing(true, log):
    turned = changed(log, boom_voltage=-log["boom.voltage"])
    short = Table({name: turned[name][:200] for name in turned.names}, turned.units)
    assert doubts(true, bare(short, "voltage", "angle")) == []
    still = changed(turned, boom_angle=0.3 + 1e-4 * np.random.default_rng(0).normal(size=len(log)))
    boom = true.function("boom")
    assert votes_of(true, still, boom, "voltage", boom).moves < 8
    assert doubts(true, bare(still, "voltage", "angle")) == []


@pytest.mark.parametrize(
    ("factor", "added", "match"),
    [
        (1 / 25.4, 0.0, "stick.spool goes 0.039. times as far as the file's pilot drives it by stick.voltage"),
        (4.0, 0.0, "stick.spool goes (3.9|4.0). times as far"),
        (1.0, 5e-4, "stick.spool reads 0.[45]... mm while its lever rests"),
    ],
)
def test_a_spool_in_another_unit_or_off_its_centre_is_named(true, log, factor, added, match):
    [(columns, text)] = doubts(true, changed(log, stick_spool=factor * log["stick.spool"] + added))
    assert columns == ("stick.spool",)
    assert re.search(match, text)


def test_moves_are_counted_until_they_tell():
    assert [Votes(2, 6).turned, Votes(1, 6).turned, Votes(1, 7).turned] == [False, False, True]
    assert [Votes(10, 6).astray, Votes(9, 6).astray, Votes(14, 2).astray] == [True, False, False]
    assert Votes(0, 0).share == 0.0
