"""What circuits see, from what sensors read."""

import numpy as np
import pytest

from helpers.machine_log import machine_log
from polydraulic.errors import InputError
from polydraulic.identification.machine_fit import Known, by_port, visited
from polydraulic.parameters.schema import LINKS
from polydraulic.tables import Table


def test_a_missing_channel_is_named(machine):
    with pytest.raises(InputError, match=r"no column 'swing.spool'"):
        by_port(Known.of(machine), Table({"boom.spool": np.zeros(3)}, {}))


def test_units_are_those_of_si(machine):
    log = machine_log()
    with pytest.raises(InputError, match=r"column 'boom.p_a' is in 'bar'; a machine is learnt in SI, this in 'Pa'"):
        by_port(Known.of(machine), Table(log.columns, {**log.units, "boom.p_a": "bar"}))
    seen = by_port(Known.of(machine), log)
    assert {name: seen.unit(name) for name in ("time", "boom.travel", "boom.k_out", "series.q_passed")} == {
        "time": "s", "boom.travel": "m", "boom.k_out": "m3/s/Pa^0.5", "series.q_passed": "m3/s",
    }  # fmt: skip
    for link in LINKS:
        forward = log[f"{link}.spool"] > 0.0
        assert np.all(seen[f"{link}.p_in"][forward] == np.maximum(log[f"{link}.p_a"][forward], 0.0))


def test_borders_keep_enough_values_on_either_side():
    values = np.concatenate([np.full(100, -2.0), np.full(30, -0.5), np.full(100, 0.5), np.full(10, 3.0)])
    assert visited([-1.0, 0.0, 1.0], values) == [-1.0]  # 30 values do not carry a part, nor do 10
    assert visited([-1.0, 0.0, 1.0], np.repeat([-2.0, -0.5, 0.5, 3.0], 100)) == [-1.0, 0.0, 1.0]
    assert visited([1.0], np.zeros(10)) == []
