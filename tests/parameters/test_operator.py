"""The random operator: repeatable, within its limit, and with the statistics that its description states."""

import numpy as np
import pytest

from polydraulic import load_scenario, random_operator
from polydraulic.errors import InputError
from polydraulic.parameters.operator import RASTER
from polydraulic.thesis.excavator import LINKS

T = np.arange(0.0, 3000.0, RASTER)


@pytest.fixture(scope="module")
def voltages():
    return random_operator(42, 3000.0).voltages(T)


def test_the_same_seed_gives_the_same_hand_whatever_the_duration(voltages):
    assert np.array_equal(random_operator(42, 20.0).voltages(T[:900]), voltages[:900])
    assert not np.array_equal(random_operator(43, 20.0).voltages(T[:900]), voltages[:900])
    one = random_operator(42, 20.0, links=("stick",))
    assert one.locked == ("swing", "boom")
    assert np.array_equal(one.voltages(T[:900])[:, 2], voltages[:900, 2])


def test_it_starts_at_rest_and_stays_within_its_limit(voltages):
    assert np.all(voltages[0] == 0.0)
    assert np.abs(voltages).max(axis=0) == pytest.approx([0.8] * 3, rel=0.01)
    assert np.abs(voltages).max() <= 0.8
    small = random_operator(42, 3000.0, limit=0.4).voltages(T)
    assert small == pytest.approx(0.5 * voltages, abs=1e-12)


def test_the_hand_is_slow(voltages):
    power = np.abs(np.fft.rfft(voltages, axis=0)) ** 2
    above = np.fft.rfftfreq(len(T), RASTER) > 2.0
    assert np.all(power[above].sum(axis=0) < 0.005 * power.sum(axis=0))


def test_it_rests_reverses_and_moves_all_links_together(voltages):
    resting = (np.abs(voltages) < 0.02).mean(axis=0)
    assert np.all((resting > 0.13) & (resting < 0.2))
    for link in voltages.T:
        sides = np.sign(link[np.abs(link) > 0.05])
        assert 12.0 < np.count_nonzero(np.diff(sides)) / 50.0 < 20.0  # a minute
    assert np.all(np.abs(voltages.mean(axis=0)) < 0.05)
    assert 0.4 < (np.abs(voltages) > 0.1).all(axis=1).mean() < 0.6
    assert np.abs(np.corrcoef(voltages.T) - np.eye(3)).max() < 0.15


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seed": -1}, "seed = -1: must be a whole number, at least 0"),
        ({"seed": 1.5}, "seed = 1.5"),
        ({"seed": True}, "seed = True"),
        ({"duration": 0.0}, "duration = 0.0 s: must lie in"),
        ({"duration": float("inf")}, "duration = inf s"),
        ({"limit": 0.0}, "limit = 0.0 V"),
        ({"links": ()}, "links = \\(\\): must be some of"),
        ({"links": ("bucket",)}, "links = \\('bucket',\\)"),
    ],
)
def test_bad_arguments_are_named(options, message):
    with pytest.raises(InputError, match=message):
        random_operator(**{"seed": 1, **options})


def test_its_name_is_a_scenario():
    found = load_scenario("random:7:12.5")
    assert (found.name, found.duration, found.locked) == ("random:7", 12.5, ())
    t = np.linspace(0.0, 12.5, 50)
    assert np.array_equal(found.voltages(t), random_operator(7, 12.5).voltages(t))
    assert load_scenario("random:7").duration == 60.0
    assert list(LINKS) == list(found.voltage)


@pytest.mark.parametrize(
    "name",
    ["random:", "random:x", "random:1:y", "random:1.5", "random:1:2:3:4", "random:1:2:x", "random:-1", "random:1:0"],
)
def test_names_that_are_no_operator_are_named(name):
    with pytest.raises(InputError, match=f"scenario '{name}': must be random:SEED or random:SEED:SECONDS"):
        load_scenario(name)
