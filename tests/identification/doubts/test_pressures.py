"""Pressures that push joints as they go, and those that do not."""

import re

import numpy as np
import pytest

from helpers.machine_log import changed
from polydraulic.identification.doubts.pressures import pressure_doubts
from polydraulic.tables import Table


def doubts(machine, table):
    return list(pressure_doubts(machine, table))


@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0])
def test_nothing_is_said_of_a_healthy_log_even_where_masses_are_guessed(true, log, factor):
    guessed = true.with_values({f"links.{link.name}.mass": factor * link.mass for link in true.links})
    assert doubts(guessed, log) == []


@pytest.mark.parametrize("name", ["swing", "boom", "stick"])
def test_exchanged_ports_are_named(true, log, name):
    swapped = changed(log, **{f"{name}_p_a": log[f"{name}.p_b"], f"{name}_p_b": log[f"{name}.p_a"]})
    [(columns, text)] = doubts(true, swapped)
    assert columns == (f"{name}.p_a", f"{name}.p_b")
    assert "fit it with the two exchanged" in text


@pytest.mark.parametrize(
    ("factor", "ports", "match"),
    [
        (0.1, "ab", "times 10: look at their unit"),
        (0.1, "a", "fit it with stick.p_a times 10: look at its unit"),
        (0.1, "b", "fit it with stick.p_b times 10: look at its unit"),
        (1 / 14.5038, "ab", "times 14.5"),
        (
            10.0,
            "ab",
            "stick.p_a and stick.p_b read up to .* bar, and no relief valve of the file opens above 344.7 bar",
        ),
    ],
)
def test_another_unit_is_named_with_its_factor(true, log, factor, ports, match):
    wrong = changed(log, **{f"stick_p_{port}": factor * log[f"stick.p_{port}"] for port in ports})
    [(columns, text)] = doubts(true, wrong)
    assert columns == tuple(f"stick.p_{port}" for port in ports)
    assert re.search(match, text)


def test_what_a_sensor_is_off_by_is_no_contradiction(true, log):
    ports = [name for name in log.names if ".p_" in name]
    for worse in (lambda p: p + 3e5, lambda p: np.minimum(p, 1.5e7), lambda p: np.round(p / 2e5) * 2e5):
        assert doubts(true, Table({**log.columns, **{name: worse(log[name]) for name in ports}}, log.units)) == []


def test_without_all_positions_or_with_rows_too_far_apart_torques_tell_nothing(true, log):
    swapped = changed(log, boom_p_a=log["boom.p_b"], boom_p_b=log["boom.p_a"])
    few = [name for name in swapped.names if name != "stick.angle"]
    assert doubts(true, Table({name: swapped[name] for name in few}, {})) == []
    assert doubts(true, Table({name: swapped[name][::10] for name in swapped.names}, {})) == []
    assert len(doubts(true, swapped)) == 1
