"""What is kept, read again, and made anew."""

import numpy as np
import pytest

from polydraulic.networks import Model, Network, Variable
from polydraulic.tables import Table
from polydraulic.thesis.cache import open_lab
from polydraulic.thesis.excavator import pump_of, with_pumps

NETWORK = Network((), (0.0,), (1.0,), (0.0,), (1.0,), 2.0, 1.0)
MODEL = Model((Variable("x", "m"),), Variable("y", "Pa"), (NETWORK,))


@pytest.fixture
def count():
    calls = []

    def made(value):
        def make():
            calls.append(value)
            return value

        return make

    made.calls = calls
    return made


def test_a_result_is_made_once_and_read_by_the_next_lab(machine, tmp_path, count):
    table = Table({"t": np.arange(3.0)}, {"t": "s"}, {"steps": 2})
    for _ in range(2):
        lab = open_lab(machine, tmp_path)
        for _ in range(2):
            assert lab.computed.data("some numbers", count({"a": [1.0, None]})) == {"a": [1.0, None]}
            found = lab.computed.table("run", count(table))
            assert found.info == table.info
            assert np.array_equal(found["t"], table["t"])
            assert lab.computed.models("nets", count([MODEL]))[0].networks == MODEL.networks
    assert len(count.calls) == 3


@pytest.mark.parametrize("folder", [True, False])
def test_a_lab_knows_what_it_has(machine, tmp_path, folder):
    place = tmp_path if folder else None
    lab = open_lab(machine, place)
    assert not lab.computed.has_data("some numbers")
    lab.computed.data("some numbers", lambda: [1.0])
    assert lab.computed.has_data("some numbers")
    assert open_lab(machine, place).computed.has_data("some numbers") == folder


def test_another_machine_shares_nothing_and_old_results_go(machine, tmp_path, count):
    first = open_lab(machine, tmp_path)
    first.computed.data("n", count(1.0))
    other = with_pumps(machine, flow=2.0 * pump_of(machine, "boom").flow)
    open_lab(other, tmp_path).computed.data("n", count(2.0))
    assert count.calls == [1.0, 2.0]
    assert not first.computed.folder.exists()


def test_without_a_folder_results_stay_in_memory(machine, count):
    lab = open_lab(machine)
    assert [lab.computed.data("n", count(1.0)) for _ in range(2)] == [1.0, 1.0]
    assert count.calls == [1.0]


def test_a_failure_leaves_nothing(machine, tmp_path):
    lab = open_lab(machine, tmp_path)
    with pytest.raises(ZeroDivisionError):
        lab.computed.data("n", lambda: 1 / 0)
    with pytest.raises(ValueError):
        lab.computed.data("n", lambda: float("nan"))
    assert lab.computed.folder.exists() is False or not list(lab.computed.folder.iterdir())


@pytest.mark.parametrize("damage", [b"", b"[2.0]\n", b"\xff\xfe"], ids=["empty", "another number", "no text"])
def test_a_result_that_was_damaged_is_made_again(machine, tmp_path, count, damage):
    first = open_lab(machine, tmp_path)
    first.computed.data("n", count([1.0]))
    (first.computed.folder / "n.data.json").write_bytes(damage)
    assert not open_lab(machine, tmp_path).computed.has_data("n")
    assert open_lab(machine, tmp_path).computed.data("n", count([1.0])) == [1.0]
    assert len(count.calls) == 2
    assert open_lab(machine, tmp_path).computed.data("n", count([1.0])) == [1.0]
    assert len(count.calls) == 2
