import pytest

from helpers.exports import made


@pytest.fixture(scope="session")
def exported_models():
    return made()
