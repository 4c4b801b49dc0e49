"""Shares by which people judge networks, and which of them are named."""

from types import SimpleNamespace

import pytest

from helpers.small_crane import write_crane
from polydraulic import load_machine
from polydraulic.flow.training.map_shares import LARGE, large_errors, map_shares


@pytest.fixture(scope="module")
def crane(tmp_path_factory):
    return load_machine(write_crane(tmp_path_factory.mktemp("crane")))


def learnt(name, unit, largest, high=2.0):
    return SimpleNamespace(
        output=SimpleNamespace(name=name, unit=unit),
        training={"largest_error": largest},
        networks=[SimpleNamespace(y_high=high)],
    )


def test_flows_are_shares_of_their_pump_and_conductances_of_the_widest_orifice(crane):
    flow = crane.circuits[0].pump.flow
    f = crane.circuits[0].functions[0]
    models = [
        learnt(f"{f}.q_in", "m3/s", 0.1 * flow),
        learnt(f"{crane.circuits[0].name}.q_passed", "m3/s", 0.2 * flow),
        learnt(f"{f}.k_out", "m3/s/Pa^0.5", 0.5),
    ]
    shares = map_shares(models, crane)
    assert list(shares.values()) == pytest.approx([0.1, 0.2, 0.25])


def test_what_is_worse_than_expected_and_asked_is_named_with_what_to_do():
    shares = {"lift.q_in": 0.39, "tilt.q_in": 0.004, "lift.k_out": 0.06}
    (line,) = large_errors(shares, 0.02, 9)
    assert "lift.q_in (39%), lift.k_out (6%) of the whole" in line
    assert "tilt" not in line
    assert "--regions 18 or more" in line
    assert "lift.k_out" not in large_errors(shares, 0.1, 9)[0]  # no worse than asked
    assert large_errors({"a.q_in": LARGE}, 0.02, 9) == []
    assert "--kind polynomial" in large_errors(shares, 0.02, None)[0]
