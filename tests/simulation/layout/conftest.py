import pytest

from helpers.small_crane import write_crane, write_crossover_crane
from polydraulic import load_machine


@pytest.fixture(scope="session")
def crane(tmp_path_factory):
    return load_machine(write_crane(tmp_path_factory.mktemp("crane")))


@pytest.fixture(scope="session")
def joined_crane(tmp_path_factory):
    """The crane with a crossover between its pumps."""
    return load_machine(write_crossover_crane(tmp_path_factory.mktemp("joined")))
