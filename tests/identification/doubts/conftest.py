"""The healthy machine and its log, of which tests of doubts change something."""

import pytest

from helpers.machine_log import machine_log
from polydraulic import load_machine


@pytest.fixture(scope="package")
def true():
    return load_machine("cat215b")


@pytest.fixture(scope="package")
def log():
    return machine_log(120.0)
