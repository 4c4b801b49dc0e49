"""Torques of the oil that push joints as they go, and those that do not."""

import re

import numpy as np
import pytest

from helpers.machine_log import changed
from polydraulic.errors import InputError
from polydraulic.identification.doubts import torques
from polydraulic.identification.doubts.torques import beyond_relief, check_torques, torque_doubts
from polydraulic.parameters.layout.schema import position_columns
from polydraulic.tables import Table


def doubts(machine, table):
    """With signs of positions that levers have shown to be right."""
    return [*beyond_relief(machine, table)] or torque_doubts(machine, table, position_columns(machine)).named


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


def test_exchanged_ports_and_a_turned_sign_are_the_same_to_a_motor_where_no_lever_tells(true, log):
    either = ("swing.p_a", "swing.p_b", "swing.angle")
    swapped = changed(log, swing_p_a=log["swing.p_b"], swing_p_b=log["swing.p_a"])
    for wrong in (swapped, changed(log, swing_angle=-log["swing.angle"])):
        [(columns, text)] = torque_doubts(true, wrong).named
        assert columns == either
        assert "fit it with the two exchanged, or with the sign of swing.angle turned: mend that" in text
    [(columns, _)] = torque_doubts(true, swapped, right=["swing.angle"]).named
    assert columns == either[:2]


def test_a_turned_sign_that_moves_other_joints_is_named_alone(true, log):
    turned = changed(log, boom_angle=-log["boom.angle"])
    [(columns, text)] = torque_doubts(true, turned).named
    assert columns == ("boom.angle",)
    assert re.search(r"at boom \(.*, stick \(.* fit it with the sign of boom.angle turned: turn it where", text)
    with pytest.raises(InputError, match="fit it with the sign of boom.angle turned"):
        check_torques(true, turned)
    found = torque_doubts(true, turned, right=["boom.angle"])
    assert (found.named, [text.split()[0] for text in found.apart]) == ([], ["boom", "stick"])


def test_what_no_single_mistake_explains_is_refused_by_who_needs_torques(true, log):
    dead = changed(log, boom_p_a=np.full(len(log), 1e5))
    assert doubts(true, dead) == []
    with pytest.raises(InputError, match=r"do not go with motion.* at boom \(corr.*: look at the signs of positions"):
        check_torques(true, dead)


def test_a_joint_that_rests_says_nothing(true, log):
    """Friction carries whatever the oil pushes with."""
    still = changed(log, swing_angle=log["swing.angle"][0] + 0.0 * log["time"], swing_p_a=2e7 + 0.0 * log["time"])
    assert torque_doubts(true, still).apart == []


@pytest.mark.parametrize("seed", range(5))
def test_torques_go_with_those_of_a_file_whose_masses_are_half_off(true, log, seed):
    share = 0.5 * np.random.default_rng(seed).normal(size=len(true.links))
    masses = {f"links.{link.name}.mass": link.mass * np.exp(x) for link, x in zip(true.links, share, strict=True)}
    check_torques(true.with_values(masses), log)


def test_without_all_positions_or_with_rows_too_far_apart_torques_tell_nothing(true, log):
    swapped = changed(log, boom_p_a=log["boom.p_b"], boom_p_b=log["boom.p_a"])
    few = [name for name in swapped.names if name != "stick.angle"]
    assert doubts(true, Table({name: swapped[name] for name in few}, {})) == []
    assert doubts(true, Table({name: swapped[name][::10] for name in swapped.names}, {})) == []
    assert len(doubts(true, swapped)) == 1


def test_of_a_long_log_a_last_piece_that_is_cut_short_is_left_out(true, log, monkeypatch):
    half = len(log) // 2
    pieces = Table(
        {**log.columns, "segment": np.repeat([0.0, 1.0], [half, len(log) - half])}, {**log.units, "segment": "1"}
    )
    monkeypatch.setattr(torques, "_MOST_ROWS", half + 3)  # of which no acceleration is seen
    swapped = {"swing_p_a": log["swing.p_b"], "swing_p_b": log["swing.p_a"]}
    assert doubts(true, pieces) == []
    assert [columns for columns, _ in doubts(true, changed(pieces, **swapped))] == [("swing.p_a", "swing.p_b")]
