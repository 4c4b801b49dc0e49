import re

import numpy as np
import pytest

from helpers.joint_log import DEAD_TIME, EDGES, LAG, joint_log
from polydraulic.errors import InputError
from polydraulic.networks.dynamic.command_response import (
    find_response,
    longest_lag_in_rows,
    response_facts,
    response_in_words,
)

LOG = joint_log(gap=False)
SPANS = [(0, 900), (950, len(LOG))]


def log_with_play(n=2400):
    """A lever that often turns before it is back at rest, whose valve follows 0.12 behind, and a joint."""
    time = np.arange(n)
    lever = np.sin(0.05 * time) + 0.5 * np.sin(0.131 * time + 1.0)
    valve, joint = 0.0, np.zeros(n)
    for t in range(1, n):
        valve = np.clip(valve, lever[t - 1] - 0.12, lever[t - 1] + 0.12)
        joint[t] = joint[t - 1] + 0.02 * (min(max(valve - 0.2, 0.0), 0.8) - min(max(-0.3 - valve, 0.0), 0.8))
    return lever, joint


@pytest.fixture(scope="module")
def found():
    return [find_response(LOG[f"lever.{j}"], LOG[j], SPANS, 16, (f"lever.{j}", j)) for j in "ab"]


def test_dead_time_lag_and_dead_zone_are_found(found):
    for response, edges in zip(found, EDGES, strict=True):
        assert [edge for edge, _ in response.edges] == pytest.approx(edges, abs=0.06)
        assert response.dead_time == pytest.approx(DEAD_TIME - 1, abs=0.5)  # a row ago is at once
        assert response.dead_time + response.lag == pytest.approx(DEAD_TIME - 1 + LAG, abs=0.5)
        assert response.weights.sum() == pytest.approx(1.0)
        assert response.play == 0.0


def test_play_between_lever_and_valve_is_found():
    lever, joint = log_with_play()
    response = find_response(lever, joint, [(0, len(lever))], 16, ("u", "y"))
    assert response.play == pytest.approx(0.24, abs=0.03)
    assert [edge for edge, _ in response.edges] == pytest.approx((0.2, -0.3), abs=0.05)
    assert "with a play of 0.2" in response_in_words(response_facts(response, "u", "V", 0.05))
    first, full = response.edges[0]
    from_below, from_above = (response.ramps(np.repeat([0.0, before, 0.6], 10))[-1, 0] for before in (0.3, 1.0))
    assert from_above - from_below == pytest.approx(response.play / (full - first), abs=0.01)


def test_stops_are_those_that_the_joint_was_driven_against(found):
    assert found[0].stops == (True, True)
    free = joint_log(stop=9.0, gap=False)
    assert not find_response(free["lever.a"], free["a"], SPANS, 16, ("lever.a", "a")).stops[1]


def test_a_stop_that_a_joint_was_driven_against_briefly_is_found():
    lever = np.repeat(np.random.default_rng(4).uniform(-1.0, 1.0, size=100), 12)
    change = 0.02 * (np.maximum(lever - 0.2, 0.0) + np.minimum(lever + 0.2, 0.0))

    def joint_up_to(end):
        joint = np.zeros(len(lever))
        for t in range(1, len(lever)):
            joint[t] = min(joint[t - 1] + change[t - 1], end)
        return joint

    free = joint_up_to(np.inf)
    ended = joint_up_to(free.max() - 0.08 * np.ptp(free))
    assert 0 < np.sum((ended == ended.max()) & (change > 0.0)) <= 16  # rows in which the lever drives it on
    for joint, upper in ((free, False), (ended, True)):
        assert find_response(lever, joint, [(0, len(lever))], 16, ("u", "y")).stops == (False, upper)


def test_openings_read_the_command_of_rows_before(found):
    command = np.where(np.arange(60) < 30, 0.0, 1.0)
    opened = found[0].ramps(command)
    assert np.array_equal(opened[16:31], np.zeros((15, 2)))
    assert opened[-1] == pytest.approx([1.0, 0.0], abs=0.05)
    assert (np.diff(opened[30:, 0]) >= 0.0).all()


def test_a_response_is_told_in_units_of_the_log(found):
    facts = response_facts(found[0], "lever.a", "V", 0.05)
    assert facts["dead_time"] == pytest.approx(0.05 * found[0].dead_time)
    words = response_in_words(facts)
    assert words.startswith("lever.a moves it beyond 0.")
    bare = response_in_words(facts | {"unit": "1"})
    assert bare == words.replace(" V", "")
    assert words.endswith("s; it was driven against its lower and its upper stop")


def test_what_a_log_cannot_show_is_no_number(found):
    short = found[0]._replace(
        edges=((0.3, 1.621), (-0.2, -0.7)), seen=(0.805, -0.805), dead_time=0.49, lag=1.5, play=0.0
    )
    facts = response_facts(short, "u", "V", 0.02)
    assert (facts["edges"], facts["seen"], facts["dead_time"]) == ([[0.3, None], [-0.2, -0.7]], [0.805, -0.805], 0.0)
    assert response_in_words(facts).startswith(
        "u moves it beyond 0.3, fully beyond the 0.805 V seen and beyond -0.2, fully at -0.7 V, with no dead time and a lag of 0.03 s;"
    )
    there = response_facts(short._replace(dead_time=0.5, edges=((0.3, 0.75),), seen=(0.805,)), "u", "V", 0.02)
    assert (there["dead_time"], there["edges"]) == (0.01, [[0.3, 0.75]])
    near = response_facts(short._replace(edges=((0.3, 0.8),), seen=(0.805,)), "u", "V", 0.02)
    assert near["edges"] == [[0.3, None]]  # hardly any lever went beyond it
    assert ", fully at 0.75 V, after a dead time of 0.01 s with a lag of 0.03 s;" in response_in_words(there)


def test_a_response_longer_than_the_longest_lag_says_which_would_do():
    late = np.concatenate([np.full(8, LOG["a"][0]), LOG["a"][:-8]])
    for raster, unit, remedy in ((None, "rows", r"longest_lag = (\S+)"), (0.05, "s", r"--longest (\S+)")):
        told = (
            rf"'y' follows 'u' with a dead time of \S+ {unit} and a lag of \S+ {unit}, .* {unit}: give {remedy} or more"
        )
        with pytest.raises(InputError, match=told) as refused:
            find_response(LOG["lever.a"], late, SPANS, 12, ("u", "y"), raster)
        needed = float(re.search(remedy, str(refused.value))[1]) / (raster or 1.0)
        assert needed > 12.0
        assert find_response(LOG["lever.a"], late, SPANS, round(needed), ("u", "y")).dead_time > 7.0


def test_what_cannot_be_found_is_refused():
    n = len(LOG)
    rest, other = np.zeros(n), np.random.default_rng(0).uniform(-1.0, 1.0, n)
    with pytest.raises(InputError, match=r"'u' stands still at 0: it moves nothing"):
        find_response(rest, LOG["a"], SPANS, 16, ("u", "y"))
    with pytest.raises(InputError, match=r"'u' explains \d+% of how 'y' moves; 20% is the least"):
        find_response(other, LOG["a"], SPANS, 16, ("u", "y"))
    with pytest.raises(InputError, match="no 33 rows follow each other"):
        find_response(LOG["lever.a"], LOG["a"], [(0, 20)], 16, ("u", "y"))


def test_the_usual_longest_lag_fits_any_raster():
    assert [longest_lag_in_rows(None, raster) for raster in (0.5, 0.05, 0.02, 0.005, 0.001)] == [4, 16, 40, 120, 120]
    assert longest_lag_in_rows(1.5, 0.02) == 75
    with pytest.raises(
        InputError, match=r"longest = 0.8 s takes 160 rows of 0.005 s, 120 are the most.* give --longest 0.6 or less"
    ):
        longest_lag_in_rows(0.8, 0.005)
