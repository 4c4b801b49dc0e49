import pytest

from helpers.small_crane import write_crane
from polydraulic import load_machine


@pytest.fixture(scope="session")
def crane(tmp_path_factory):
    return load_machine(write_crane(tmp_path_factory.mktemp("crane")))
