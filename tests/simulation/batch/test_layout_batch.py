"""Batches of machines of other layouts have the bits of single runs."""

import numpy as np
import pytest

from helpers.small_crane import write_crane
from polydraulic import InputError, load_machine, simulate, simulate_batch
from polydraulic.parameters.scenario import random_operator


@pytest.fixture(scope="module")
def crane(tmp_path_factory):
    return load_machine(write_crane(tmp_path_factory.mktemp("crane")))


@pytest.fixture(scope="module")
def heavy(crane):
    return crane._replace(links=tuple(link._replace(mass=1.3 * link.mass) for link in crane.links))


def test_machines_in_lanes_have_the_bits_of_single_ones(crane, heavy):
    scenarios = [random_operator(seed, 3.0, functions=crane.names) for seed in range(6)]
    machines = [crane, heavy, crane, heavy, crane, crane]
    batch = simulate_batch(machines, "exact", scenarios, keep=["rows"])
    for i in (0, 1, 5):
        run = simulate(machines[i], "exact", scenarios[i])
        for name in batch.names:
            assert np.array_equal(batch[name][i], run[name]), (i, name)
    assert not np.array_equal(batch["lift.angle"][0], batch["lift.angle"][2])
    assert batch.not_converged.sum() == 0
    assert batch.units["extend.position"] == "m"


def test_voltages_and_states_have_the_size_of_the_machine(crane):
    with pytest.raises(InputError, match=r"\(n_step, 3\)"):
        simulate_batch(crane, "exact", np.zeros((10, 4)))
    with pytest.raises(InputError, match=r"\(15,\)"):
        simulate_batch(crane, "exact", np.zeros((10, 3)), x0=np.zeros(20))
    with pytest.raises(InputError, match="extend voltage in step 2"):
        simulate_batch(crane, "exact", np.where(np.arange(30).reshape(10, 3) == 8, np.nan, 0.0))


def test_machines_of_different_layouts_do_not_mix(crane):
    with pytest.raises(InputError, match="2 layouts; a batch holds machines of one layout"):
        simulate_batch([crane, "cat215b"], "exact", np.zeros((10, 3)))
