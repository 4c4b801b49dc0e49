import pytest

from exports import made


@pytest.fixture(scope="session")
def exported_models():
    return made()
